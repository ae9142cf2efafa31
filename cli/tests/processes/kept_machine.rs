//! A run that is killed half-way with a motion under way, and run again with the same state directory: the simulated machine
//! stands where it stood, and auto comes back.

use std::os::unix::fs::PermissionsExt as _;
use std::time::Duration;

use linewright_msgs::StationState;

use crate::support::operator::Operator;
use crate::support::rig::{Rig, line};
use crate::support::wait_for;

#[test]
fn a_run_that_is_killed_half_way_goes_on_without_a_lost_position() {
    let mut rig = Rig::new(&line(1.5));
    let operator = rig.in_auto();
    operator.cycles(1);
    rig.eye.wait("the mill feeds", |seen| seen.output("mill_1", "feed"));
    operator.wait("and says so", |heard| heard.station("mill_1").places[2] == StationState::PLACE_OPERATING);
    drop(operator);
    rig.signal("KILL");
    assert!(wait_for(Duration::from_secs(10), || rig.processes().is_empty()), "all end with it: {:?}", rig.processes());
    let files: Vec<_> = std::fs::read_dir(rig.state()).expect("there").map(|file| file.expect("a file")).collect();
    let rights = |file: &std::fs::DirEntry| file.metadata().expect("there").permissions().mode() & 0o777;
    let open: Vec<_> = files.iter().filter(|file| rights(file) & 0o077 != 0).map(|file| file.path()).collect();
    assert!(files.len() > 5 && open.is_empty(), "readable by others: {open:?} of {} files", files.len());
    let kept = std::fs::read_to_string(rig.state().join("plant.json")).expect("positions are kept");
    assert!(kept.contains("\"mill_1\""), "{kept}");

    rig.start(&["--no-auto"]);
    let operator = Operator::join(&rig);
    operator.wait("everything stands", |heard| heard.all(|state| state.stopped));
    assert!(operator.heard().all(|state| !state.fault.contains("position lost")), "{}", operator.picture());
    assert_eq!(operator.station("mill_1").incomplete, [2], "its feed was cut short: {}", operator.picture());
    operator.recover();
    operator.cycles(1);
    assert!(operator.heard().all(|state| state.fault.is_empty()), "{}", operator.picture());
    operator.go_home();
    rig.ends_well(0);
}
