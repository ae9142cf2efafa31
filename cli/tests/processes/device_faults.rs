//! Devices fail by command while a line runs: their station says which device, which object and why; repaired, they are
//! booted again, and the line goes on without a restart.

use linewright_msgs::StationState;

use crate::support::operator::STATIONS;
use crate::support::rig::{BUS, Rig, line};

/// Whose device, an output that is on at the time, what happens, and what the station then says it waits for.
const FAULTS: [(&str, &str, &str, &str, &str); 2] = [
    ("transfer", "transfer io", "advance", "identity", "its product code (object 1018h:02) is 0000FFFFh"),
    ("mill_1", "mill 1 positioning drive", "rapid_advance", "bus-off", "mill 1 positioning drive (node 23h): "),
];

#[test]
fn each_is_named_and_taken_back_after_its_repair() {
    let mut rig = Rig::new(&known_products());
    let operator = rig.in_auto();
    for (station, device, output, what, said) in FAULTS {
        operator.cycles(1);
        rig.eye.wait("off", |seen| !seen.output(station, output));
        rig.eye.wait(output, |seen| seen.output(station, output));
        fail(&rig, station, device, what);
        operator.wait(&format!("{device}: {what}: {said}"), |heard| {
            let waits = &heard.station(station).blocked_by;
            waits.iter().any(|text| text.contains(device) && text.contains(said))
        });
        for other in STATIONS.iter().filter(|other| **other != station) {
            assert!(operator.station(other).incomplete.is_empty(), "{other} finishes what it does");
        }
        fail(&rig, station, device, "clear");
        operator.wait("its devices are back", |heard| heard.all(|state| state.devices_valid));
        if !operator.heard().in_mode(StationState::MODE_AUTO) {
            operator.recover();
        }
    }
    operator.cycles(1);
    operator.go_home();
    rig.signal("INT");
    let (code, report) = rig.ended();
    assert_eq!((code, &report["restarts"]), (0, &0.into()), "{report}");
    assert_eq!(rig.eye.seen().conflicts(), [""; 0]);
}

/// The shipped line, whose I/O devices have to be the product they are.
fn known_products() -> String {
    let text = line(1.0);
    let product = "node = 0x11\nidentity = { product = 401 }\n";
    assert!(text.contains("node = 0x11\n"));
    text.replace("node = 0x11\n", product)
}

fn fail(rig: &Rig, station: &str, device: &str, what: &str) {
    let output = rig.command(&["fail"], &[station, what, "--device", device, "--bus", BUS]).output();
    let output = output.expect("the command starts");
    assert!(output.status.success(), "{output:?}");
}
