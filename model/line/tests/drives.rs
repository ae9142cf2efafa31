//! Devices that are drives: what is read, and every rule about them broken once.
//!
//! `«` in a replacement marks where the problem must point, as in `problems.rs`.

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

/// What to replace by what; the beginning of the message; some words of the hint.
type Case<'a> = (&'a [(&'a str, &'a str)], &'a str, &'a str);

#[track_caller]
fn errors(cases: &[Case<'_>]) {
    for (edits, message, hint) in cases {
        let mut text = DRIVES.to_owned();
        for (old, new) in *edits {
            assert!(text.contains(old), "the base has no {old:?}");
            text = text.replacen(old, new, 1);
        }
        let mark = text.find('«').expect("a case marks a place");
        let text = text.replace('«', "");
        let problems = parse("drives.toml", &text).expect_err(message).into_vec();
        let is_it = |p: &&Problem| {
            p.message.starts_with(message)
                && p.span.start == mark
                && !p.is_warning
                && p.hint.as_deref().unwrap_or_default().contains(hint)
        };
        assert!(problems.iter().any(|p| is_it(&p)), "{edits:?} wanted {mark} {message} ({hint}): {problems:#?}");
    }
}

#[test]
fn keys_and_numbers() {
    errors(&[
        (&[("axis = \"x\"\nunits", "units"), ("[device.drive]", "«[device.drive]")], "`drive` needs `axis`", ""),
        (&[("axis = \"x\"\nunits", "axis = «\"y\"\nunits")], "unknown axis `y`", "`x`"),
        (&[("window = 0.05", "window = «0")], "`window` is 0", "above zero"),
        (&[("window = 0.05", "window = «nan")], "`window` is NaN", "above zero"),
        (&[("window = 0.05", "«widow = 0.05")], "unknown key `widow` in `drive`", "`window`"),
        (&[("at_rest = \"hold\"", "at_rest = «\"holt\"")], "unknown at_rest `holt`", "`hold`"),
        (&[("axis = \"x\"\nunits", "mode = «\"torque\"\naxis = \"x\"\nunits")], "unknown mode `torque`", "`velocity`"),
        (&[("to = 100, at = \"at_100\"", "«too = 100, at = \"at_100\"")], "unknown key `too` in a target", "`to`"),
        (&[("method = 17", "method = «0")], "0 is not a homing method", "1 to 37"),
        (&[("method = 17", "method = «128")], "128 is not a homing method", ""),
        (&[("slow = 2", "slow = «30")], "homing slowly at 30 and fast at 20", ""),
        (&[("window = 0.05", "window = «0.0001")], "a window of 0.0001 is less than one increment", "units_per_mm"),
        (
            &[("units_per_mm = 1000", "units_per_mm = 100000000"), ("to = 80, at", "to = «80, at")],
            "a target of 80 is more than a drive counts",
            "",
        ),
    ]);
}

#[test]
fn targets() {
    errors(&[
        (&[("to = 100, at = \"at_100\"", "to = 100, at = «\"at_80\"")], "`at_80` would be on at two places", ""),
        (
            &[("\"back_to_80\", to = 80, at = \"at_80\"", "\"back_to_80\", to = 80, at = «\"also_80\"")],
            "a second input for being at 80",
            "one place, one input",
        ),
        (&[("to = 100, at = \"at_100\"", "to = «80.05, at = \"at_100\"")], "targets 0.0", "two windows"),
        (&[("{ output = \"back_to_80\"", "{ output = «\"to_80\"")], "`to_80` is bound to two bits", ""),
        (&[("fault = \"x_fault\"\ntargets", "fault = «\"C_0\"\ntargets")], "`C_0` is bound to two bits", ""),
        (&[("to = 100, at = \"at_100\"", "to = «101, at = \"at_100\"")], "`to_100` goes to 101, not to 100", ""),
        (&[("complete = \"at_100\"", "complete = «\"at_80\"")], "`to_100` ends where another input", ""),
        (
            &[("normal = { actuator = \"Y_close\"", "normal = { actuator = «\"to_80\"")],
            "`to_80` does not move `clamp`",
            "",
        ),
        (
            &[
                ("recovery = { actuator = \"to_0\"", "recovery = { actuator = «\"Y_more\""),
                ("\"Y_close\"]", "\"Y_close\", \"Y_more\"]"),
            ],
            "`fast forward` moves `x` by something else than its drive",
            "a target",
        ),
    ]);
    let start = DRIVES.find("targets = [").expect("targets");
    let end = start + DRIVES[start..].find("\n]\n").expect("their end") + 3;
    errors(&[(&[(&DRIVES[start..end], ""), ("[device.drive]", "«[device.drive]")], "this drive has no targets", "")]);
}

#[test]
fn devices() {
    let second = "[[device]]\nname = \"more\"\nstation = \"slide\"\nnode = 4\ndrive = { axis = «\"x\", units_per_mm = 1, \
                  window = 1, velocity = 1, acceleration = 1, targets = [{ output = \"o\", to = 7, at = \"i\" }] }\n\n\
                  [[device]]\nname = \"slide io\"";
    errors(&[
        (&[("node = 3\n", "node = 3\ninputs = [«\"extra\"]\n")], "a drive has no `inputs`", "a device of their own"),
        (
            &[("station = \"slide\"\nnode = 3", "console = true\nnode = 3"), ("[device.drive]", "«[device.drive]")],
            "a drive of the console",
            "of a station",
        ),
        (
            &[
                ("[[device]]\nname = \"slide io\"", second),
                ("axis = «\"x\"", "axis = \"x\""),
                ("axis = \"x\"\nunits", "axis = «\"x\"\nunits"),
            ],
            "a second drive of axis `x`",
            "",
        ),
        (
            &[("duration_s = 0.5\nwatchdog_s = 2.5", "duration_s = 0.4\nwatchdog_s = «0.5")],
            "the watchdog of `back` is 0.5 s, but the drive takes 0.525 s",
            "faster",
        ),
    ]);
}
