//! Refusals of `fail`: what is not so, where, and the operations, inputs or options that would do.

use linewright_line::{Line, Operation, Owner, StationId};
use linewright_plant::MotionFault;
use miette::miette;

use super::motions::{closes, motion, signals_fault};
use super::{FailArgs, quoted};
use crate::can::injected::InjectedFault;
use crate::load;

/// Error: what has the fault is not named.
pub fn needs(line: &Line, owner: Owner, args: &FailArgs) -> miette::Report {
    let what = args.what.name();
    let (of, inputs, station) = match owner {
        Owner::Console => ("the console", &line.console.inputs, None),
        Owner::Station(id) => (args.station.as_str(), &line.station(id).inputs, Some(id)),
    };
    let fault = match args.what {
        InjectedFault::Motion(fault) => fault,
        InjectedFault::Input(_) | InjectedFault::Device(_) | InjectedFault::Clear => {
            let help = match inputs.is_empty() {
                true => format!("{of} has no inputs"),
                false => format!("the inputs of {of}: {}", quoted(inputs.iter().map(String::as_str))),
            };
            return miette!(help = help, "{what} needs --input, with the name of an input of {of}");
        }
    };
    let Some(id) = station else {
        return miette!(
            help = "a button or contact of it has `stuck-on` or `stuck-off`, with --input",
            "{what} is a fault of a motion, and the console has none: give the station that moves"
        );
    };
    let fitting: Vec<&str> =
        line.station(id).operations.iter().filter(|of| fits(line, id, of, fault)).map(name).collect();
    let help = match fitting.is_empty() {
        true => has_none(line, id, fault),
        false => format!("operations of {of} that can {what}: {}", quoted(fitting.into_iter())),
    };
    miette!(help = help, "{what} needs --operation, with the name of an operation of {of}")
}

/// Error: a fault of a gripper for a motion that closes none. What is lost while it is carried is held by the gripper that was closed before.
pub fn no_gripper(line: &Line, args: &FailArgs, fault: MotionFault) -> miette::Report {
    let operation = args.operation.as_deref().unwrap_or_default();
    let help = match motion(line, args).ok().and_then(|(id, _)| gripped_by(line, id, operation)) {
        Some(closing) => format!(
            "give the operation before it that closes the gripper: --operation {}. {}",
            crate::out::shell_word(closing),
            effect(fault)
        ),
        None => load::station(line, &args.station).map_or_else(|_| String::new(), |id| has_none(line, id, fault)),
    };
    miette!(help = help, "`{operation}` of {} closes no gripper: it cannot {}", args.station, fault.name())
}

/// Error: a motion that has no fault signal cannot break.
pub fn no_fault_signal(line: &Line, args: &FailArgs) -> miette::Report {
    let operation = args.operation.as_deref().unwrap_or_default();
    let others = load::station(line, &args.station).map_or_else(
        |_| Vec::new(),
        |id| line.station(id).operations.iter().filter(|of| signals_fault(of, None)).map(name).collect(),
    );
    let others = match others.is_empty() {
        true => String::new(),
        false => format!("; with a fault signal: {}", quoted(others.into_iter())),
    };
    miette!(
        help = format!("`stick`: it does not move, and its watchdog ends it{others}"),
        "`{operation}` of {} has no fault signal that could come on: it cannot break",
        args.station
    )
}

/// Error: an option that names what cannot have the fault.
pub fn wrong_option(args: &FailArgs) -> miette::Report {
    let (given, is_not) = match &args.operation {
        Some(_) => ("--operation", "a motion"),
        None => ("--input", "an input"),
    };
    let (is, help) = match args.what {
        InjectedFault::Motion(_) => ("a motion", "name the operation with --operation in place of --input"),
        InjectedFault::Input(_) => ("an input", "name the input with --input in place of --operation"),
        InjectedFault::Device(_) => {
            ("a whole device", "leave the option out; --device names another device than the station's first")
        }
        InjectedFault::Clear => ("anything", "leave the option out"),
    };
    miette!(help = help, "{} is a fault of {is}, not of {is_not}: {given} does not go with it", args.what.name())
}

/// What a fault of a gripper does, and for how long.
fn effect(fault: MotionFault) -> &'static str {
    match fault {
        MotionFault::Drop => {
            "The part falls once it is off its place: on the way, each time this gripper closes so, until `clear` with the same --operation"
        }
        MotionFault::Miss | MotionFault::Stick | MotionFault::Slip | MotionFault::Break | MotionFault::SlipBack => {
            "It lasts until `clear` with the same --operation"
        }
    }
}

/// The operations elsewhere that can have a fault which no operation of this station can.
fn has_none(line: &Line, station: StationId, fault: MotionFault) -> String {
    let others = line.station_ids().flat_map(|id| {
        let operations = line.station(id).operations.iter().filter(move |of| fits(line, id, of, fault));
        operations.map(move |of| format!("`{}` of {}", of.name, line.station(id).name))
    });
    let others: Vec<String> = others.collect();
    let needed = match fault {
        MotionFault::Miss | MotionFault::Drop => "gripper, a holder of `kind = \"hand\"`",
        MotionFault::Break => "motion with a fault signal (`fault`); `stick` is for every motion",
        MotionFault::Stick | MotionFault::Slip | MotionFault::SlipBack => "operation",
    };
    match others.is_empty() {
        true => format!("no station of the description has a {needed}"),
        false => format!(
            "{} has none; operations that can {}: {}",
            line.station(station).name,
            fault.name(),
            others.join(", ")
        ),
    }
}

/// Whether the normal motion of an operation can have a fault.
fn fits(line: &Line, station: StationId, operation: &Operation, fault: MotionFault) -> bool {
    match fault {
        MotionFault::Miss | MotionFault::Drop => closes(line, station, operation, Some(operation.normal.actuator)),
        // What a drive breaks by is its own.
        MotionFault::Break => {
            signals_fault(operation, Some(operation.normal.actuator)) || is_driven(line, station, operation)
        }
        MotionFault::Slip | MotionFault::SlipBack => !is_driven(line, station, operation),
        MotionFault::Stick => true,
    }
}

fn is_driven(line: &Line, station: StationId, operation: &Operation) -> bool {
    let mut drives = line.devices_of(Owner::Station(station)).filter_map(|device| device.drive());
    drives.any(|drive| drive.motions().any(|output| output == operation.normal.actuator))
}

/// The last operation before this one in its station, round the cycle or within its task, whose normal motion closes a gripper.
fn gripped_by<'l>(line: &'l Line, station: StationId, operation: &str) -> Option<&'l str> {
    let of = line.station(station);
    let at = of.operations.iter().position(|of| of.name == operation)?;
    let task = of.task_ids().map(|task| of.operations_of(task).map(|op| op.index()).collect::<Vec<_>>());
    let order = task.into_iter().find(|ops| ops.contains(&at)).unwrap_or_else(|| (0..of.operations.len()).collect());
    let nth = order.iter().position(|op| *op == at)?;
    let earlier = order[..nth].iter().rev();
    let operations: Vec<&Operation> = match of.is_task_driven() {
        true => earlier.map(|op| &of.operations[*op]).collect(),
        false => earlier.chain(order[nth..].iter().rev()).map(|op| &of.operations[*op]).collect(),
    };
    let closing = |of: &&&Operation| closes(line, station, of, Some(of.normal.actuator));
    operations.iter().find(closing).map(|of| of.name.as_str())
}

fn name(operation: &Operation) -> &str {
    &operation.name
}

#[cfg(test)]
mod tests {
    use linewright_plant::InputFault;

    use super::super::orders;
    use super::super::tests::{C1, args};
    use super::*;
    use crate::can::injected::DeviceTrouble;

    fn help(error: &miette::Report) -> String {
        error.help().map(|help| help.to_string()).unwrap_or_default()
    }

    fn cell() -> Line {
        linewright_line::parse("line.toml", C1).expect("it parses").line
    }

    fn shipped() -> Line {
        let shipped = linewright_line::TransferLine::default().text();
        linewright_line::parse("line.toml", &shipped).expect("it parses").line
    }

    /// It would end with 0 and do nothing.
    #[test]
    fn a_motion_that_closes_no_gripper_does_not_miss_and_drops_nothing() {
        let (cell, shipped) = (cell(), shipped());
        let fails = |line: &Line, station: &str, operation: &str, fault| {
            let what = InjectedFault::Motion(fault);
            orders(line, &FailArgs { operation: Some(operation.to_owned()), ..args(station, what) }).map(drop)
        };
        for fault in [MotionFault::Miss, MotionFault::Drop] {
            fails(&cell, "robot", "grasp for m1", fault).expect("it closes the gripper");
            let why = fails(&cell, "robot", "carry to m1", fault).expect_err("nothing closes");
            assert!(why.to_string().contains("closes no gripper: it cannot"), "{why}");
            // What loses the part is the grip before it, and no other one.
            assert!(help(&why).contains("--operation \"grasp for m1\"") && !help(&why).contains("m2"), "{why:?}");
            assert!(help(&why).contains("until `clear`"), "{why:?}");
            let why = fails(&shipped, "clamp_1", "advance clamp", fault).expect_err("there are no parts");
            assert!(help(&why).contains("has a gripper"), "{why:?}");
        }
    }

    #[test]
    fn a_fault_without_an_operation_names_those_that_can_have_it() {
        let (cell, shipped) = (cell(), shipped());
        let bare = |line: &Line, station: &str, fault| {
            orders(line, &args(station, InjectedFault::Motion(fault))).expect_err("of which motion")
        };
        let drop = bare(&cell, "robot", MotionFault::Drop);
        assert_eq!(drop.to_string(), "drop needs --operation, with the name of an operation of robot");
        for other in ["carry to m1", "let go at m1"] {
            assert!(help(&drop).contains("`grasp for m1`") && !help(&drop).contains(other), "{drop:?}");
        }
        let elsewhere = bare(&cell, "m1", MotionFault::Drop);
        assert!(help(&elsewhere).starts_with("m1 has none; operations that can drop: "), "{elsewhere:?}");
        assert!(help(&elsewhere).contains("`grasp for m1` of robot"), "{elsewhere:?}");
        assert!(help(&bare(&shipped, "clamp_1", MotionFault::Stick)).contains("`advance clamp`"));
        let console = bare(&shipped, "console", MotionFault::Stick);
        assert!(
            console.to_string().contains("the console has none") && help(&console).contains("--input"),
            "{console:?}"
        );
    }

    #[test]
    fn an_option_that_does_not_go_with_a_fault_is_refused_with_the_one_that_does() {
        let line = shipped();
        let stuck = InjectedFault::Input(InputFault::StuckOff);
        let of = |what, operation: Option<&str>, input: Option<&str>| {
            let (operation, input) = (operation.map(str::to_owned), input.map(str::to_owned));
            orders(&line, &FailArgs { operation, input, ..args("clamp_1", what) }).expect_err("it does not go with it")
        };
        let stuck_motion = of(stuck, Some("advance clamp"), None);
        assert_eq!(
            stuck_motion.to_string(),
            "stuck-off is a fault of an input, not of a motion: --operation does not go with it"
        );
        assert!(help(&stuck_motion).contains("with --input"), "{stuck_motion:?}");
        let input_sticks = of(InjectedFault::Motion(MotionFault::Stick), None, Some("LS_open"));
        assert!(help(&input_sticks).contains("with --operation"), "{input_sticks:?}");
        let silent = of(InjectedFault::Device(DeviceTrouble::Silent), None, Some("LS_open"));
        assert!(help(&silent).contains("leave the option out"), "{silent:?}");
    }
}
