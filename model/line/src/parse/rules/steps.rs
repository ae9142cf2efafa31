//! Operations side by side (seed 002, Appendix): how `with` makes steps, and which steps are allowed.

use linewright_text::{Problem, Report};

use crate::parse::draft::DraftStation;
use crate::parse::names::StationNames;
use crate::parse::raw::{ModuleKind, RawStation};
use crate::{BRANCHES_MAX, OpId};

/// Divides a station's operations into steps: an operation joins the step before it if its `with` names one of it.
pub(in crate::parse) fn steps(raw: &RawStation, names: &StationNames<'_>, report: &mut Report) -> Vec<Vec<OpId>> {
    let mut steps: Vec<Vec<OpId>> = Vec::new();
    for (index, operation) in raw.operations.iter().enumerate() {
        let id = OpId::at(index);
        let joined = operation.with.as_ref().is_some_and(|with| {
            let Some(other) = names.operations.find(with, "operation", report) else { return false };
            match steps.last() {
                Some(step) if step.contains(&OpId::at(other)) && step.len() < BRANCHES_MAX => true,
                Some(step) if step.contains(&OpId::at(other)) => {
                    report.add(
                        Problem::error(with.at.clone(), format!("more than {BRANCHES_MAX} operations side by side"))
                            .label("one too many"),
                    );
                    false
                }
                _ => {
                    report.add(
                        Problem::error(with.at.clone(), format!("`{}` is not listed directly before", with.value))
                            .hint("operations that run side by side follow each other in the list"),
                    );
                    false
                }
            }
        });
        match steps.last_mut() {
            Some(step) if joined => step.push(id),
            _ => steps.push(vec![id]),
        }
    }
    steps
}

/// Place in the text where an operation runs beside others.
fn with_place(station: &DraftStation<'_>, op: OpId) -> std::ops::Range<usize> {
    let operation = station.operation(op);
    operation.raw.with.as_ref().map_or_else(|| operation.place(), |with| with.at.clone())
}

pub(super) fn groups_are_allowed(station: &DraftStation<'_>, report: &mut Report) {
    for (index, step) in station.steps.iter().enumerate().filter(|(_, step)| step.len() > 1) {
        let at = || with_place(station, step[1]);
        if index == 0 {
            report
                .add(Problem::error(at(), "the first operation listed runs by itself").hint(
                    "its start is what begins a new cycle; list the group later, or put one operation before it",
                ));
        }
        if let Some(home) = &station.home
            && step.contains(&home.value)
        {
            report.add(
                Problem::error(
                    at(),
                    format!("the home operation `{}` runs by itself", station.operation(home.value).name),
                )
                .also(&home.at, "home")
                .hint("the station is at home when one operation is complete"),
            );
        }
        for &op in step {
            let operation = station.operation(op);
            if operation.kind() == Some(ModuleKind::Irreversible) {
                report.add(
                    Problem::error(
                        operation.place(),
                        format!("irreversible operation `{}` runs side by side", operation.name),
                    )
                    .also(&at(), "in this group")
                    .hint("only reversible operations can be recovered independently of their neighbours"),
                );
            }
        }
    }
}

pub(super) fn groups_move_different_axes(station: &DraftStation<'_>, report: &mut Report) {
    for step in &station.steps {
        for (nth, &op) in step.iter().enumerate() {
            let Some(motion) = &station.operation(op).motion else { continue };
            let same = step[..nth]
                .iter()
                .map(|&earlier| station.operation(earlier))
                .find(|earlier| earlier.motion.as_ref().is_some_and(|m| m.value.axis == motion.value.axis));
            if let Some(earlier) = same {
                let axis = &station.axes[motion.value.axis.index()].name;
                let message = format!(
                    "`{}` and `{}` run side by side, and both move `{axis}`",
                    earlier.name,
                    station.operation(op).name
                );
                report.add(
                    Problem::error(motion.at.clone(), message)
                        .also(&earlier.place(), "the other one")
                        .hint("operations side by side need an axis each"),
                );
            }
        }
    }
}
