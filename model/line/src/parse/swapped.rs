//! A motion whose `from` and `to` are swapped: one error where it is written.
//!
//! Switches, outputs and the motions around it contradict such a motion, and each would be reported as a contradiction of its own. So
//! the draft goes on with the motion that is meant. That is known where motions of its axis do not follow each other, and do with
//! this one the other way round, and with no other.

use linewright_text::{Problem, Report};

use super::draft::{DraftLine, DraftStation};
use super::rules::same_place;
use crate::{AxisId, Motion};

/// Motions that follow each other, and where their axes stand before and after them.
struct Stretch {
    operations: Vec<usize>,
    begins: Vec<f64>,
    ends: Vec<f64>,
}

/// Reports such motions, and turns them round.
pub(super) fn turn_round(draft: &mut DraftLine<'_>, report: &mut Report) {
    for station in &mut draft.stations {
        // One unknown motion leaves every later position of an unknown axis in doubt.
        if station.operations.iter().any(|operation| operation.motion.is_none()) {
            continue;
        }
        for stretch in stretches(station) {
            for axis in (0..station.axes.len()).map(AxisId::at) {
                if let Some(swapped) = swapped(station, &stretch, axis) {
                    turn(station, swapped, report);
                }
            }
        }
    }
}

fn stretches(station: &DraftStation<'_>) -> Vec<Stretch> {
    let home: Vec<f64> = station.axes.iter().map(|axis| axis.home).collect();
    if !station.is_task_driven() {
        let Some(round) = station.round_from_home() else { return Vec::new() };
        let operations = round.into_iter().map(crate::OpId::index).collect();
        return vec![Stretch { operations, begins: home.clone(), ends: home }];
    }
    let stretch = |task: &super::draft::DraftTask<'_>| {
        let rest = |of: &Option<linewright_text::Located<crate::RestId>>| {
            of.as_ref().and_then(|rest| station.rests.get(rest.value.index()).cloned())
        };
        Some(Stretch { operations: task.ops.clone().collect(), begins: rest(&task.from)?, ends: rest(&task.to)? })
    };
    station.tasks.iter().filter_map(stretch).collect()
}

/// The one operation with which the motions of an axis follow each other when it is turned round.
fn swapped(station: &DraftStation<'_>, stretch: &Stretch, axis: AxisId) -> Option<usize> {
    let (begin, end) = (*stretch.begins.get(axis.index())?, *stretch.ends.get(axis.index())?);
    let motion = |op: usize| station.operations[op].motion.as_ref().map(|motion| motion.value);
    let mine: Vec<(usize, Motion)> = stretch
        .operations
        .iter()
        .filter_map(|&op| Some((op, motion(op).filter(|motion| motion.axis == axis)?)))
        .collect();
    let follow = |turned: Option<usize>| {
        let mut at = begin;
        mine.iter().all(|&(op, Motion { from, to, .. })| {
            let (from, to) = if turned == Some(op) { (to, from) } else { (from, to) };
            same_place(std::mem::replace(&mut at, to), from)
        }) && same_place(at, end)
    };
    if follow(None) {
        return None;
    }
    let mut found = mine.iter().map(|(op, _)| *op).filter(|op| follow(Some(*op)));
    found.next().filter(|_| found.next().is_none())
}

fn turn(station: &mut DraftStation<'_>, op: usize, report: &mut Report) {
    let operation = &mut station.operations[op];
    let Some(motion) = &mut operation.motion else { return };
    let Motion { axis, from, to } = motion.value;
    let axis_name = &station.axes[axis.index()].name;
    let message = format!(
        "`{}` moves `{axis_name}` from {from} to {to}, where the motions around it lead from {to} to {from}",
        operation.name
    );
    report.add(
        Problem::error(motion.at.clone(), message)
            .label("the other way round")
            .hint(format!("write `from = {to}, to = {from}`")),
    );
    motion.value = Motion { axis, from: to, to: from };
}
