//! Devices that are not digital CANopen I/O: a pressure that is measured, and a probe without CANopen, in a line of
//! real processes.

use std::process::Output;

use crate::support::bus::frame;
use crate::support::rig::{BUS, Rig, line};

/// Holds the measured value of the clamp's device, in hundredths of a bar; 10000h lets it go.
fn hold(rig: &Rig, number: u32) {
    let [a, b, c, d] = number.to_le_bytes();
    rig.member().send(&frame(0x621, &[0x23, 0x04, 0x5F, 1, a, b, c, d]));
}

const LETS_GO: u32 = 0x1_0000;

const PROBE: &str = r#"VERSION "1"
BS_:
BU_: Probe Controller
BO_ 2566844672 ProbeState: 3 Probe
 SG_ Broken : 0|2@1+ (1,0) [0|3] "" Controller
 SG_ Alive : 8|4@1+ (1,0) [0|15] "" Controller
 SG_ Check : 16|8@1+ (1,0) [0|255] "" Controller
"#;

/// The shipped line: the clamp's pressure switch is a limit of a measured pressure, the mill's broken tool is found by a
/// probe that sends frames of its own.
fn description() -> String {
    let text = line(1.0);
    let pressure = r#"inputs = ["LS_open", "LS_closed", "low_pressure","#;
    let measured = r#"analogue_inputs = [{ channel = 1, unit = "bar", factor = 0.01, inputs = [{ input = "low_pressure", below = 4.0, hysteresis = 0.2 }] }]
inputs = ["LS_open", "LS_closed", "","#;
    let probe = r#"
[[device]]
name = "tool probe"
station = "mill_1"

[device.dbc]
file = "probe.dbc"

[[device.dbc.receive]]
message = "ProbeState"
timeout_ms = 2000
counter = "Alive"
checksum = { signal = "Check", kind = "crc8" }
inputs = [{ input = "tool_broken", signal = "Broken", equals = 1 }]
"#;
    for there in [pressure, r#"inputs = ["tool_broken","#, "\n[timing]\n"] {
        assert!(text.contains(there), "the shipped line has {there}");
    }
    text.replace(pressure, measured)
        .replace(r#"inputs = ["tool_broken","#, r#"inputs = ["","#)
        .replace("\n[timing]\n", &format!("{probe}\n[timing]\n"))
}

fn status(rig: &Rig) -> Output {
    let mut command = rig.command(&["can", "--bus", BUS, "status"], &["--json"]);
    command.output().expect("the command starts")
}

#[test]
fn a_measured_pressure_and_a_probe_that_speaks_no_canopen() {
    let mut rig = Rig::new(&description());
    rig.file("probe.dbc", PROBE);
    let operator = rig.in_auto();
    operator.cycles(1);
    let output = status(&rig);
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{output:?}"));
    let probe = told["nodes"].as_array().expect("a list").iter().find(|node| node["name"] == "tool probe");
    let probe = probe.unwrap_or_else(|| panic!("the probe is told of: {told}"));
    assert_eq!((&probe["node"], &probe["operational"]), (&serde_json::Value::Null, &true.into()), "{told}");

    // Too low: the clamp stops, and names the channel.
    hold(&rig, 100);
    let low = "low_pressure (clamp 1 io, node 21h, 6401h:01 below 4.00 bar) came on, and is still on";
    operator.wait("the clamp says why", |heard| heard.station("clamp_1").fault.contains(low));
    hold(&rig, LETS_GO);
    operator.recover();
    operator.cycles(1);

    // A broken wire is no pressure at all.
    hold(&rig, 0x7FFF);
    let broken =
        "I/O devices lost (clamp 1 io (node 21h): operational, but analogue input 1 (6401h:01) is at the end of its";
    operator.wait("the clamp says what is broken", |heard| heard.station("clamp_1").fault.contains(broken));
    hold(&rig, LETS_GO);
    operator.wait("its devices are back", |heard| heard.all(|state| state.devices_valid));
    operator.recover();
    operator.cycles(1);
    operator.go_home();
    let report = rig.ends_well(0);
    assert_eq!(report["stations"]["mill_1"]["faults"], 0, "{report}");
}
