//! Devices that are drives: what is read.

use linewright_line::{
    AtRest, AxisId, Drive, DriveIndex, DriveMode, DriveTarget, Homing, InputId, NumberedOrder, OutputId, Owner,
    Problem, StationId, TurnDirection, parse,
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

/// The drive of the description.
fn drive() -> Drive {
    let parsed = parse("drives.toml", DRIVES).unwrap_or_else(|problems| panic!("{problems:#}"));
    parsed.line.devices[1].drive().expect("it is a drive").clone()
}

#[test]
fn the_time_of_a_motion_is_that_of_a_trapezoid_or_a_triangle() {
    let drive = Drive { acceleration: 1000.0, ..drive() };
    // 0.1 s up, 0.1 s down, 10 mm of the way in those, 90 mm at 100 mm/s.
    assert!((drive.time_for(100.0, 100.0) - 1.1).abs() < 1e-12);
    // 2 mm up and 2 mm down: s = a t² / 2.
    assert!((drive.time_for(-4.0, 1000.0) - 2.0 * (2.0 * 2.0 / 1000.0f64).sqrt()).abs() < 1e-12);
    assert_eq!(drive.time_for(0.0, 1.0), 0.0);
}

#[test]
fn of_two_numbers_nothing_that_turns_the_axis_stays_on() {
    const LAMP: u128 = 1 << 7;
    let index = DriveIndex {
        places: 7,
        turn: 360.0,
        direction: TurnDirection::Positive,
        to: vec![OutputId(1), OutputId(2), OutputId(3)],
        place: Vec::new(),
    };
    let target = DriveTarget { output: OutputId(0), to: 0.0, at: InputId(0), velocity: 1.0 };
    let drive = Drive { targets: vec![target], index: Some(index), ..drive() };
    let orders = [NumberedOrder::of(&drive).expect("it is sent to places by number")];
    let order = |place: u128| 1 | place << 1;
    for before in 1..=7 {
        for after in 0..=7 {
            let staying = NumberedOrder::staying(&orders, order(before) | LAMP, order(after) | LAMP);
            assert_eq!(staying & 1 != 0, before == after, "{before} and then {after}");
            assert_eq!(staying & LAMP, LAMP);
        }
        assert_eq!(NumberedOrder::staying(&orders, order(before) | LAMP, 0), 0);
    }
    assert_eq!(NumberedOrder::staying(&[], order(3), order(1)), order(1), "outputs that each mean something");
}
