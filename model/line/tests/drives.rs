//! Devices that are drives: what is read.

use linewright_line::{
    AtRest, AxisId, DriveMode, DriveTarget, Homing, InputId, OutputId, Owner, Problem, StationId, parse,
};

const DRIVES: &str = include_str!("descriptions/drives.toml");

#[test]
fn a_drive_is_read_with_what_it_leaves_out() {
    let parsed = parse("drives.toml", DRIVES).unwrap_or_else(|problems| panic!("{problems:#}"));
    let unexpected: Vec<&Problem> = parsed.warnings.iter().filter(|w| w.message.contains("drive")).collect();
    assert!(unexpected.is_empty(), "{unexpected:?}");
    let [io, device] = &parsed.line.devices[..] else { panic!("two devices") };
    assert_eq!(io.drive(), None);
    assert_eq!((device.owner, device.node_id()), (Owner::Station(StationId(0)), Some(3)));
    assert!(device.input_bits().is_empty() && device.output_bits().is_empty());
    let station = &parsed.line.stations[0];
    assert_eq!(station.inputs[5..], ["at_0", "at_80", "at_100", "x_fault"]);
    assert_eq!(station.outputs[2..], ["to_0", "to_80", "back_to_80", "to_100"]);
    let drive = device.drive().expect("it is a drive");
    let target = |output, to, at, velocity| DriveTarget { output: OutputId(output), to, at: InputId(at), velocity };
    assert_eq!(
        drive.targets,
        [target(2, 0.0, 5, 250.0), target(3, 80.0, 6, 250.0), target(4, 80.0, 6, 250.0), target(5, 100.0, 7, 60.0)]
    );
    assert_eq!((drive.axis, drive.mode, drive.at_rest), (AxisId(0), DriveMode::Position, AtRest::Hold));
    assert_eq!((drive.fault, drive.quick_stop), (Some(InputId(8)), 5000.0));
    let homing = Homing {
        method: 17,
        fast: 20.0,
        slow: 2.0,
        acceleration: 2000.0,
        offset: -1.5,
        output: OutputId(2),
        done: None,
    };
    assert_eq!(drive.homing, Some(homing));
    assert_eq!(drive.increments(80.0), 80_000);
    assert_eq!(drive.units(-1500.0), -1.5);
    assert_eq!(device.carried_outputs().len(), 5, "the homing's is a target's");
    assert_eq!(io.carried_inputs().len(), 5);
}

#[test]
fn a_homing_may_have_signals_of_its_own() {
    let text = DRIVES.replace("output = \"to_0\", offset = -1.5", "output = \"home_x\", done = \"x_homed\"");
    let parsed = parse("drives.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}"));
    let station = &parsed.line.stations[0];
    assert_eq!((station.inputs[9].as_str(), station.outputs[6].as_str()), ("x_homed", "home_x"));
    let homing = parsed.line.devices[1].drive().and_then(|drive| drive.homing).expect("a homing");
    assert_eq!((homing.output, homing.done, homing.offset), (OutputId(6), Some(InputId(9)), 0.0));
    assert!(parsed.warnings.iter().any(|w| w.message == "nothing uses `home_x`"), "no operation orders it");
}
