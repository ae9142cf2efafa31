//! The motions that a fault of a motion is about: it is one of the output that moves them.

use linewright_line::{Grip, Line, Operation, OperationModule, OutputId, StationId};
use miette::miette;

use super::{FailArgs, quoted};
use crate::can::injected::InjectedFault;
use crate::load;

/// The motion that is meant, by name.
pub fn named(args: &FailArgs) -> Option<String> {
    args.operation.as_deref().map(|name| called(name, args.recovery))
}

fn called(operation: &str, is_recovery: bool) -> String {
    if is_recovery { format!("recovery of {operation}") } else { operation.to_owned() }
}

/// The other motions of the same output, which have the fault as well; none where there are none.
pub fn others(line: &Line, args: &FailArgs) -> miette::Result<Option<String>> {
    let (id, output) = motion(line, args)?;
    let station = line.station(id);
    let by_output = |operation: &Operation| {
        let back = match &operation.module {
            OperationModule::Reversible { recovery, .. } => Some((recovery.actuator, true)),
            OperationModule::Irreversible { .. } => None,
        };
        let motions = std::iter::once((operation.normal.actuator, false)).chain(back);
        let its = motions.filter(|(actuator, _)| *actuator == output);
        its.map(|(_, is_recovery)| called(&operation.name, is_recovery)).collect::<Vec<_>>()
    };
    let meant = named(args);
    let all = station.operations.iter().flat_map(by_output);
    let others: Vec<String> = all.filter(|motion| Some(motion) != meant.as_ref()).collect();
    let output = &station.outputs[output.index()];
    let begin = match args.what {
        InjectedFault::Clear => format!("It has ended for every motion by output {output}"),
        _ => format!("Every motion by output {output} has it, each time until `clear`"),
    };
    Ok((!others.is_empty()).then(|| format!("{begin}: {} too.", quoted(others.iter().map(String::as_str)))))
}

/// Whether a motion of the output that moves it has a fault signal.
pub fn has_fault_signal(line: &Line, args: &FailArgs) -> miette::Result<bool> {
    let (id, output) = motion(line, args)?;
    Ok(line.station(id).operations.iter().any(|operation| signals_fault(operation, Some(output))))
}

/// Whether a motion of an operation, by this output if one is given, has a fault signal.
pub(super) fn signals_fault(operation: &Operation, output: Option<OutputId>) -> bool {
    let back = match &operation.module {
        OperationModule::Reversible { recovery, .. } => Some(*recovery),
        OperationModule::Irreversible { .. } => None,
    };
    let mut signals = std::iter::once(operation.normal).chain(back);
    signals.any(|signals| output.is_none_or(|output| output == signals.actuator) && signals.fault.is_some())
}

/// Whether a motion of the output that moves it ends where a gripper is closed.
pub fn closes_a_gripper(line: &Line, args: &FailArgs) -> miette::Result<bool> {
    let (id, output) = motion(line, args)?;
    Ok(line.station(id).operations.iter().any(|operation| closes(line, id, operation, Some(output))))
}

/// Whether the normal or recovery motion of an operation, by this output if one is given, ends where a gripper is closed.
pub(super) fn closes(line: &Line, station: StationId, operation: &Operation, output: Option<OutputId>) -> bool {
    /// Nearer than every switch can tell.
    const SAME_PLACE: f64 = 1e-6;
    let motion = &operation.motion;
    let back = match &operation.module {
        OperationModule::Reversible { recovery, .. } => Some((recovery.actuator, motion.from)),
        OperationModule::Irreversible { .. } => None,
    };
    let ends = std::iter::once((operation.normal.actuator, motion.to)).chain(back);
    ends.filter(|(actuator, _)| output.is_none_or(|output| output == *actuator)).any(|(_, end)| {
        line.handling.holders.iter().any(|holder| {
            let Grip::Hand(stand) = holder.grip else { return false };
            (stand.station, stand.axis) == (station, motion.axis) && (stand.at - end).abs() < SAME_PLACE
        })
    })
}

/// The station of a motion, and its output.
pub fn motion(line: &Line, args: &FailArgs) -> miette::Result<(StationId, OutputId)> {
    let id = load::station(line, &args.station)?;
    let station = line.station(id);
    let name = args.operation.as_deref().unwrap_or_default();
    let op = station.operation_named(name).ok_or_else(|| {
        let known = || station.operations.iter().map(|o| o.name.as_str());
        let error = miette!("{} has no operation `{name}`; it has {}", args.station, quoted(known()));
        load::or_meant(error, name, known())
    })?;
    let operation = &station.operations[op.index()];
    match (&operation.module, args.recovery) {
        (_, false) => Ok((id, operation.normal.actuator)),
        (OperationModule::Reversible { recovery, .. }, true) => Ok((id, recovery.actuator)),
        (OperationModule::Irreversible { .. }, true) => Err(miette!(
            help = "without --recovery its one motion has the fault",
            "`{name}` of {} is irreversible: it has no recovery motion",
            args.station
        )),
    }
}

#[cfg(test)]
mod tests {
    use linewright_plant::MotionFault;

    use super::super::tests::{C1, args};
    use super::*;

    #[test]
    fn the_other_motions_of_an_output_are_named_that_have_its_fault() {
        let text = linewright_line::TransferLine::default().text();
        let transfer = linewright_line::parse("line.toml", &text).expect("it parses").line;
        let cell = linewright_line::parse("line.toml", C1).expect("it parses").line;
        let of = |line: &Line, station: &str, operation: &str, recovery, what| {
            let args = FailArgs { operation: Some(operation.to_owned()), recovery, ..args(station, what) };
            (named(&args).expect("one"), others(line, &args).expect("it is known"))
        };
        let stick = InjectedFault::Motion(MotionFault::Stick);
        let (meant, others) = of(&transfer, "clamp_1", "advance clamp", false, stick);
        assert_eq!(meant, "advance clamp");
        assert_eq!(
            others.as_deref(),
            Some("Every motion by output close has it, each time until `clear`: `recovery of return clamp` too.")
        );
        let (meant, others) = of(&transfer, "clamp_1", "advance clamp", true, stick);
        assert_eq!(meant, "recovery of advance clamp");
        assert_eq!(
            others.as_deref(),
            Some("Every motion by output open has it, each time until `clear`: `return clamp` too.")
        );
        // Motions back as well: the gripper that is closed by one output grasps, and takes its letting go back.
        let (meant, others) = of(&cell, "robot", "grasp for m1", false, stick);
        let others = others.expect("each machine has one");
        assert_eq!(meant, "grasp for m1");
        let begin = "Every motion by output close has it, each time until `clear`: ";
        assert!(others.starts_with(begin) && others.ends_with(" too."), "{others}");
        for other in ["`grasp for m2`", "`grasp for m3`", "`recovery of let go at m1`"] {
            assert!(others.contains(other) && !others.contains("`grasp for m1`"), "{other}: {others}");
        }
        let (_, cleared) = of(&cell, "robot", "grasp for m1", false, InjectedFault::Clear);
        assert!(cleared.is_some_and(|text| text.starts_with("It has ended for every motion by output close: ")));
    }
}
