//! Do the motions of a station fit together? Each must start where the last one on its axis ended, all the way round.
//!
//! This needs no plant: positions in a description are exact, and a gap is a slip of the pen or a forgotten operation.

use std::ops::Range;

use linewright_text::{Problem, Report};

use super::operations::same_place;
use crate::parse::draft::{DraftLine, DraftStation};
use crate::{AxisId, OpId};

/// An axis on its way round the cycle, or through a task.
pub(super) struct Position {
    pub at: f64,
    /// The operation that left it there, with the place of its motion.
    pub left_by: Option<(String, Range<usize>)>,
}

/// Reports a home operation after which the axes are not at home, where they are after another one: nothing is wrong then but where the
/// cycle begins. The draft goes on without it, since recovery paths, arrows and conflicts would contradict it each for itself.
pub(in crate::parse) fn wrong_homes(draft: &mut DraftLine<'_>, report: &mut Report) {
    for station in draft.stations.iter_mut().filter(|station| !station.is_task_driven()) {
        if let Some(problem) = wrong_home(station) {
            report.add(problem);
            station.home = None;
        }
    }
}

fn wrong_home(station: &DraftStation<'_>) -> Option<Problem> {
    let home = station.home.as_ref().filter(|_| are_known(station))?;
    if gaps(station, home.value).is_empty() {
        return None;
    }
    let other = (0..station.operations.len()).map(OpId::at).find(|&op| gaps(station, op).is_empty())?;
    let name = |op: OpId| station.operation(op).name;
    let message = format!(
        "after `{}` the axes are not where `axes` has them at home; after `{}` they are",
        name(home.value),
        name(other)
    );
    Some(
        Problem::error(home.at.clone(), message)
            .hint(format!("`home = \"{}\"`, or give the positions in `axes` at which the cycle begins", name(other))),
    )
}

/// One unknown motion leaves every later position of an unknown axis in doubt.
fn are_known(station: &DraftStation<'_>) -> bool {
    station.operations.iter().all(|op| op.motion.is_some())
}

pub(super) fn motions_chain(station: &DraftStation<'_>, report: &mut Report) {
    let Some(home) = station.home.as_ref().filter(|_| are_known(station)) else { return };
    gaps(station, home.value).into_iter().for_each(|problem| report.add(problem));
}

/// Where motions do not follow each other on their axes, in a cycle that ends with `home`.
fn gaps(station: &DraftStation<'_>, home: OpId) -> Vec<Problem> {
    let mut problems = Vec::new();
    let mut axes: Vec<Position> = station.axes.iter().map(|axis| Position { at: axis.home, left_by: None }).collect();
    for op in station.round_after(home) {
        let operation = station.operation(op);
        let Some(motion) = &operation.motion else { continue };
        let position = &mut axes[motion.value.axis.index()];
        if !same_place(position.at, motion.value.from) {
            let axis = &station.axes[motion.value.axis.index()].name;
            let from = operation.raw.moves.as_ref().and_then(|m| m.from.as_ref()).map_or(&motion.at, |f| &f.at);
            problems.push(gap(operation.name, motion.value.from, from, axis, position, "at home"));
        }
        *position = Position { at: motion.value.to, left_by: Some((operation.name.to_owned(), motion.at.clone())) };
    }
    for (index, position) in axes.iter().enumerate() {
        let (axis, raw) = (&station.axes[index], &station.raw.axes[index].0);
        let Some((name, at)) = &position.left_by else { continue };
        if !same_place(position.at, axis.home) {
            let message =
                format!("`{name}` leaves `{}` at {}, but at home it stands at {}", axis.name, position.at, axis.home);
            problems.push(
                Problem::error(at.clone(), message)
                    .also(&raw.at, "its home position")
                    .hint("a cycle ends where it began"),
            );
        }
    }
    problems
}

/// A motion that starts where its axis is not; `before` is when, if nothing has moved it yet.
pub(super) fn gap(name: &str, from: f64, at: &Range<usize>, axis: &str, position: &Position, before: &str) -> Problem {
    let problem = |message| Problem::error(at.clone(), message).hint("a motion starts where the one before it ended");
    match &position.left_by {
        None => problem(format!("`{name}` starts at {from}, but {before} `{axis}` stands at {}", position.at)),
        Some((before, place)) => {
            problem(format!("`{name}` starts at {from}, but `{before}` leaves `{axis}` at {}", position.at))
                .also(place, "left here")
        }
    }
}

pub(super) fn axes_are_moved(station: &DraftStation<'_>, report: &mut Report) {
    if !are_known(station) {
        return;
    }
    for (index, (name, _)) in station.raw.axes.iter().enumerate() {
        let axis = AxisId::at(index);
        if !station.operations.iter().any(|op| op.motion.as_ref().is_some_and(|m| m.value.axis == axis)) {
            report.add(
                Problem::warning(name.at.clone(), format!("no operation moves axis `{}`", name.value))
                    .hint("remove it, or let an operation move it"),
            );
        }
    }
}
