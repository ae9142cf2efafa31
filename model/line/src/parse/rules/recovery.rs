//! Recovery paths of irreversible operations (seed 002 §5.2.1 step 4).
//!
//! A path is run after a fault: the listed operations are taken back in order, then the home operation follows. So
//! each of them must be one that can be taken back and has been done since the station left home, and together they
//! must bring every axis home.

use linewright_text::{Problem, Report};

use super::operations::same_place;
use super::tasks::earlier_in_task;
use crate::OpId;
use crate::parse::draft::{DraftOperation, DraftStation};
use crate::parse::raw::ModuleKind;

fn irreversible<'s>(station: &'s DraftStation<'s>) -> impl Iterator<Item = (OpId, &'s DraftOperation<'s>)> {
    station
        .op_ids()
        .map(OpId::at)
        .map(|op| (op, station.operation(op)))
        .filter(|(_, operation)| operation.kind() == Some(ModuleKind::Irreversible))
}

pub(super) fn paths_are_reversible_and_earlier(station: &DraftStation<'_>, report: &mut Report) {
    for (op, operation) in irreversible(station) {
        let mut seen: Vec<OpId> = Vec::new();
        for step in &operation.path {
            let other = station.operation(step.value);
            let problem = |message: String| Problem::error(step.at.clone(), message);
            let is_home = end_of_path(station, op) == Some(step.value);
            if step.value == op {
                report.add(
                    problem(format!("the recovery path of `{}` names the operation itself", operation.name))
                        .hint("name the reversible operations before it that lead home"),
                );
            } else if is_home {
                // An empty path is a problem as well.
                let hint = if operation.path.len() == 1 {
                    "put another operation here, one that is taken back; this one always follows at the end of the path"
                } else {
                    "leave it out: it always follows at the end of the path"
                };
                report.add(
                    problem(format!(
                        "the recovery path of `{}` names {}",
                        operation.name,
                        if station.is_task_driven() { "the last operation of its task" } else { "the home operation" }
                    ))
                    .hint(hint),
                );
            } else if other.kind() == Some(ModuleKind::Irreversible) {
                report.add(
                    problem(format!("`{}` is irreversible and cannot be taken back", other.name))
                        .hint("a recovery path consists of reversible operations"),
                );
            } else if seen.contains(&step.value) {
                report.add(problem(format!("`{}` is twice on one recovery path", other.name)).label("again"));
            } else if station.steps.get(station.step_of(step.value)).is_some_and(|step| step.len() > 1) {
                report.add(
                    problem(format!("`{}` runs side by side with others", other.name))
                        .hint("a recovery path moves one operation at a time; take a group back in manual instead"),
                );
            } else if station.is_task_driven() {
                if !earlier_in_task(station, op).is_some_and(|earlier| earlier.contains(&step.value.index())) {
                    report.add(
                        problem(format!("`{}` does not come before `{}` in its task", other.name, operation.name))
                            .label("not done when the fault happens")
                            .hint("a recovery path takes back what the same task has done before"),
                    );
                }
            } else if let (Some(this), Some(that)) =
                (station.steps_since_home(op), station.steps_since_home(step.value))
                && that >= this
            {
                report.add(
                    problem(format!("`{}` does not come before `{}`", other.name, operation.name))
                        .label("not done yet when the fault happens")
                        .hint("a recovery path takes back what has been done since the station left home"),
                );
            }
            seen.push(step.value);
        }
    }
}

/// The operation at the end of a recovery path: that at the end of the task, or the home operation.
fn end_of_path(station: &DraftStation<'_>, op: OpId) -> Option<OpId> {
    if !station.is_task_driven() {
        return station.home.as_ref().map(|home| home.value);
    }
    let task = &station.tasks[station.operation(op).task.as_ref()?.value.index()];
    task.ops.contains(&op.index()).then(|| OpId::at(task.ops.end - 1))
}

/// Positions of the axes at the end of a recovery path.
fn positions_at_end(station: &DraftStation<'_>, op: OpId) -> Option<Vec<f64>> {
    if !station.is_task_driven() {
        return Some(station.axes.iter().map(|axis| axis.home).collect());
    }
    let task = &station.tasks[station.operation(op).task.as_ref()?.value.index()];
    station.rests.get(task.to.as_ref()?.value.index()).cloned()
}

/// Operations since the station left home, or began the task, and the operation itself.
fn done_before(station: &DraftStation<'_>, op: OpId) -> Vec<OpId> {
    if station.is_task_driven() {
        let earlier = earlier_in_task(station, op).map_or(0..0, |earlier| earlier.start..earlier.end + 1);
        return earlier.map(OpId::at).collect();
    }
    let until = station.steps_since_home(op);
    station.op_ids().map(OpId::at).filter(|&other| station.steps_since_home(other) <= until).collect()
}

pub(super) fn paths_lead_home(station: &DraftStation<'_>, report: &mut Report) {
    if station.operations.iter().any(|op| op.motion.is_none()) {
        return;
    }
    for (op, operation) in irreversible(station) {
        let Some(path) = &operation.raw.recovery_path else { continue };
        // An unknown name has been reported, and an empty path too.
        if path.value.is_empty() || operation.path.len() != path.value.len() {
            continue;
        }
        let (Some(home), Some(positions)) = (end_of_path(station, op), positions_at_end(station, op)) else { continue };
        let moved: Vec<usize> = done_before(station, op)
            .into_iter()
            .filter_map(|other| station.operation(other).motion.as_ref())
            .map(|motion| motion.value.axis.index())
            .collect();
        for (index, axis) in station.axes.iter().enumerate() {
            let is_on_axis =
                |other: &DraftOperation<'_>| other.motion.as_ref().is_some_and(|m| m.value.axis.index() == index);
            if !moved.contains(&index) {
                continue;
            }
            let taken_back = operation.path.iter().map(|step| station.operation(step.value)).rfind(|o| is_on_axis(o));
            let home_operation = Some(station.operation(home)).filter(|o| is_on_axis(o));
            let end = match (home_operation, taken_back) {
                (Some(last), _) => last.motion.as_ref().map(|m| m.value.to),
                (None, Some(last)) => last.motion.as_ref().map(|m| m.value.from),
                (None, None) => None,
            };
            let wanted = positions[index];
            let at_its_end = if station.is_task_driven() { "where the task ends" } else { "at home" };
            if end.is_some_and(|end| same_place(end, wanted)) {
                continue;
            }
            let where_it_is = end.map_or("where the fault found it".to_owned(), |end| format!("at {end}"));
            report.add(
                Problem::error(
                    path.at.clone(),
                    format!("the recovery path of `{}` leaves `{}` {where_it_is}", operation.name, axis.name),
                )
                .label("does not lead home")
                .hint(format!("{at_its_end} `{}` stands at {wanted}: add the operation to take back", axis.name)),
            );
        }
    }
}
