//! Task-driven stations: do the tasks, their operations and the rests between them fit together?
//!
//! The rests and tasks form a graph. Each task must lead to the rest it names, and from every rest there must be a way to
//! every other: a station that is somewhere else than home must be able to come home by tasks alone.

use std::time::Duration;

use linewright_text::{Problem, Report};

use super::motion::{Position, gap};
use super::operations::same_place;
use crate::parse::draft::{DraftLine, DraftStation, DraftTask};
use crate::parse::raw::ModuleKind;
use crate::{OpId, RestId, TaskId};

/// Applies the rules for a task-driven station.
pub(super) fn check(station: &DraftStation<'_>, report: &mut Report) {
    tasks_take_the_place_of_home(station, report);
    operations_belong_to_tasks(station, report);
    operations_run_one_by_one(station, report);
    home_is_where_the_axes_say(station, report);
    rests_are_joined(station, report);
    irreversible_operations_come_back(station, report);
    for task in &station.tasks {
        task_has_operations(task, report);
        results_are_waited_for(station, task, report);
        motions_lead_from_rest_to_rest(station, task, report);
        limit_outlasts_the_motions(station, task, report);
        parameters_have_outputs(task, report);
    }
    for operation in &station.operations {
        if let (Some(code), None) = (&operation.raw.waits_code, &operation.raw.waits) {
            report.add(
                Problem::error(code.at.clone(), format!("`{}` waits for nothing", operation.name)).hint(
                    "`waits_code` is for when the time runs out while an operation waits: say for what in `waits`",
                ),
            );
        }
    }
}

/// Keys for a task-driven station alone, in one that is none.
pub(super) fn nothing_of_tasks(station: &DraftStation<'_>, report: &mut Report) {
    let hint = "only a task-driven station has it: one with `[[station.task]]`";
    if let Some(rest) = station.raw.rests.first() {
        report.add(Problem::error(rest.at.clone(), "a rest of a station without tasks").hint(hint));
    }
    if let Some(source) = &station.raw.order_source {
        report.add(Problem::error(source.at.clone(), "`orders` in a station without tasks").hint(hint));
    }
    for operation in &station.operations {
        let raw = operation.raw;
        let keys = [
            ("task", raw.task.as_ref().map(|name| &name.at)),
            ("waits", raw.waits.as_ref().map(|waits| &waits.at)),
            ("waits_code", raw.waits_code.as_ref().map(|code| &code.at)),
            ("result", raw.result.as_ref().map(|result| &result.at)),
        ];
        for (key, at) in keys {
            if let Some(at) = at {
                report.add(Problem::error(at.clone(), format!("`{key}` in a station without tasks")).hint(hint));
            }
        }
    }
}

/// No arrows: a task-driven station waits for its orders.
pub(super) fn task_driven_stations_are_not_joined(draft: &DraftLine<'_>, report: &mut Report) {
    let task_driven = |station: crate::StationId| draft.stations[station.index()].is_task_driven();
    for arrow in &draft.arrows {
        let ends = [&arrow.from, &arrow.to].into_iter().flatten();
        if let Some(end) = ends.into_iter().find(|end| task_driven(end.value.0)) {
            report.add(
                Problem::error(end.at.clone(), "an arrow of a task-driven station")
                    .hint("it does a task when it is ordered to: what must come before, the coordinator sees to"),
            );
        }
    }
}

/// Two tasks are kept apart by orders, two stretches by arrows; nothing keeps one of each apart.
pub(super) fn tasks_are_in_conflict_with_tasks(draft: &DraftLine<'_>, report: &mut Report) {
    let task_driven = |station: crate::StationId| draft.stations[station.index()].is_task_driven();
    for conflict in &draft.conflicts {
        let (Some(a), Some(b)) = (&conflict.a, &conflict.b) else { continue };
        let (task, stretch) = match (task_driven(a.value.station), task_driven(b.value.station)) {
            (true, false) => (a, b),
            (false, true) => (b, a),
            (true, true) | (false, false) => continue,
        };
        report.add(
            Problem::error(conflict.at.clone(), "a conflict of a task with a stretch of a cycle")
                .also(&task.at, "done when it is ordered")
                .also(&stretch.at, "done when the arrows hold")
                .hint("no order and no arrow keeps the two apart: name two tasks, or two stretches"),
        );
    }
}

fn tasks_take_the_place_of_home(station: &DraftStation<'_>, report: &mut Report) {
    if let Some(home) = &station.raw.home {
        report.add(
            Problem::error(home.at.clone(), format!("station `{}` has tasks, and so no `home`", station.name))
                .hint("its home is the first rest listed"),
        );
    }
}

fn home_is_where_the_axes_say(station: &DraftStation<'_>, report: &mut Report) {
    let (Some(home), Some(at)) = (station.raw.rests.first(), station.rests.first()) else { return };
    for (axis, _) in station.axes.iter().zip(at).filter(|(axis, at)| !same_place(axis.home, **at)) {
        let written = home.positions.iter().find(|(name, _)| name.value == axis.name);
        let place = written.map_or_else(|| home.at.clone(), |(name, _)| name.at.clone());
        report.add(
            Problem::error(place, format!("at home `{}` stands at {}, as `axes` says", axis.name, axis.home))
                .hint("the first rest listed is home: leave `at` out there, or change `axes`"),
        );
    }
}

fn operations_belong_to_tasks(station: &DraftStation<'_>, report: &mut Report) {
    for (nth, operation) in station.operations.iter().enumerate() {
        if operation.raw.task.is_none() {
            report.add(
                Problem::error(operation.place(), format!("`{}` belongs to no task", operation.name))
                    .hint("say `task = \"…\"`: this station does nothing but tasks"),
            );
        }
        let Some(of) = &operation.task else { continue };
        let task = &station.tasks[of.value.index()];
        if !task.ops.contains(&nth) {
            report.add(
                Problem::error(of.at.clone(), format!("`{}` stands apart from the rest of its task", operation.name))
                    .also(&task.place(), "this task")
                    .hint("operations of a task stand together, in the order they are done"),
            );
        }
    }
}

fn operations_run_one_by_one(station: &DraftStation<'_>, report: &mut Report) {
    for with in station.operations.iter().filter_map(|operation| operation.raw.with.as_ref()) {
        report.add(
            Problem::error(with.at.clone(), "operations side by side in a task-driven station")
                .hint("the operations of a task run one by one; divide the station, or leave `with` out"),
        );
    }
}

/// A task is done with its last motion: nothing waits for what that has brought about.
fn results_are_waited_for(station: &DraftStation<'_>, task: &DraftTask<'_>, report: &mut Report) {
    let last = station.operations[task.ops.clone()].last();
    if let Some((last, result)) = last.and_then(|last| Some((last, last.raw.result.as_ref()?))) {
        report.add(
            Problem::error(result.at.clone(), format!("`{}` is the last operation of task `{}`", last.name, task.name))
                .label("nothing waits for it")
                .hint("in auto the next operation of a task waits for `result`, and here none follows; give it to an earlier operation"),
        );
    }
}

fn task_has_operations(task: &DraftTask<'_>, report: &mut Report) {
    if task.ops.is_empty() {
        report.add(
            Problem::error(task.place(), format!("task `{}` has no operation", task.name))
                .hint("an operation says which task it belongs to: `task = \"…\"`"),
        );
    }
}

/// Every rest can be reached from the first one, and left for it.
fn rests_are_joined(station: &DraftStation<'_>, report: &mut Report) {
    let ends = |task: &DraftTask<'_>| Some((task.from.as_ref()?.value, task.to.as_ref()?.value));
    let Some(roads) = station.tasks.iter().map(ends).collect::<Option<Vec<_>>>() else { return };
    let back: Vec<(RestId, RestId)> = roads.iter().map(|&(from, to)| (to, from)).collect();
    let (reached, leaving) = (from_home(&roads), from_home(&back));
    let ends_somewhere = roads.iter().any(|&(_, to)| to == RestId(0));
    for (id, rest) in station.raw.rests.iter().enumerate().map(|(nth, rest)| (RestId::at(nth), rest)) {
        let Some(name) = &rest.name else { continue };
        if id == RestId(0) && !ends_somewhere {
            report.add(
                Problem::error(name.at.clone(), format!("no task ends at `{}`", name.value))
                    .hint("it is the station's home, being the first rest listed: some task must lead there"),
            );
        } else if !reached.contains(&id) {
            report.add(
                Problem::error(name.at.clone(), format!("no tasks lead from home to `{}`", name.value))
                    .hint("home is the first rest listed; add a task, or remove the rest"),
            );
        } else if !leaving.contains(&id) {
            report.add(
                Problem::error(name.at.clone(), format!("no tasks lead from `{}` back home", name.value))
                    .hint("home is the first rest listed; a station must be able to come home by tasks"),
            );
        }
    }
}

/// The rests that roads lead to from the first one, itself among them.
fn from_home(roads: &[(RestId, RestId)]) -> Vec<RestId> {
    let mut reached = vec![RestId(0)];
    let mut next = 0;
    while let Some(&here) = reached.get(next) {
        next += 1;
        for &(_, to) in roads.iter().filter(|(from, _)| *from == here) {
            if !reached.contains(&to) {
                reached.push(to);
            }
        }
    }
    reached
}

/// A recovery path leads to where the task ends. Where that is another rest than where it began, the part would count as
/// worked on though it was not.
fn irreversible_operations_come_back(station: &DraftStation<'_>, report: &mut Report) {
    for operation in station.operations.iter().filter(|operation| operation.kind() == Some(ModuleKind::Irreversible)) {
        let Some(task) = operation.task.as_ref().map(|task: &linewright_text::Located<TaskId>| task.value) else {
            continue;
        };
        let task = &station.tasks[task.index()];
        if let (Some(from), Some(to)) = (&task.from, &task.to)
            && from.value != to.value
        {
            report.add(
                Problem::error(
                    operation.place(),
                    format!("irreversible operation `{}` in a task that ends elsewhere than it begins", operation.name),
                )
                .also(&from.at, "begins here")
                .also(&to.at, "ends here")
                .hint("give it a task of its own that comes back to the rest where it began"),
            );
        }
    }
}

fn motions_lead_from_rest_to_rest(station: &DraftStation<'_>, task: &DraftTask<'_>, report: &mut Report) {
    let (Some(from), Some(to)) = (&task.from, &task.to) else { return };
    let operations = &station.operations[task.ops.clone()];
    // One unknown motion leaves every later position of an unknown axis in doubt.
    if operations.iter().any(|operation| operation.motion.is_none()) || operations.is_empty() {
        return;
    }
    let [begins, ends] = [from, to].map(|rest| &station.rests[rest.value.index()]);
    let mut axes: Vec<Position> = begins.iter().map(|&at| Position { at, left_by: None }).collect();
    for operation in operations {
        let Some(motion) = &operation.motion else { continue };
        let position = &mut axes[motion.value.axis.index()];
        if !same_place(position.at, motion.value.from) {
            let axis = &station.axes[motion.value.axis.index()].name;
            let at = operation.raw.moves.as_ref().and_then(|m| m.from.as_ref()).map_or(&motion.at, |from| &from.at);
            report.add(gap(operation.name, motion.value.from, at, axis, position, "where the task begins"));
        }
        *position = Position { at: motion.value.to, left_by: Some((operation.name.to_owned(), motion.at.clone())) };
    }
    for ((position, wanted), axis) in axes.iter().zip(ends).zip(&station.axes) {
        if same_place(position.at, *wanted) {
            continue;
        }
        let name = &station.raw.rests[to.value.index()].name;
        let rest = name.as_ref().map_or("?", |name| name.value.as_str());
        let message = format!(
            "task `{}` leaves `{}` at {}, but in `{rest}` it stands at {wanted}",
            task.name, axis.name, position.at
        );
        let problem =
            Problem::error(to.at.clone(), message).hint("a task leads from one rest to another, on every axis");
        report.add(match &position.left_by {
            Some((_, at)) => problem.also(at, "left here"),
            None => problem.also(&from.at, "it stands like this from the beginning"),
        });
    }
}

fn limit_outlasts_the_motions(station: &DraftStation<'_>, task: &DraftTask<'_>, report: &mut Report) {
    let Some(limit) = &task.raw.limit else { return };
    let durations = station.operations[task.ops.clone()].iter().map(|op| op.raw.duration.as_ref().map(|d| d.value));
    let Some(takes) = durations.sum::<Option<Duration>>() else { return };
    if limit.value <= takes {
        let message = format!(
            "the limit of task `{}` is {} s, but its motions take {} s",
            task.name,
            limit.value.as_secs_f64(),
            takes.as_secs_f64()
        );
        report.add(
            Problem::error(limit.at.clone(), message)
                .label("too short")
                .hint("a task also waits for others, and may have to stop and go on: twice as long is usual"),
        );
    }
}

fn parameters_have_outputs(task: &DraftTask<'_>, report: &mut Report) {
    for (name, bits) in &task.raw.parameters {
        if bits.value.is_empty() {
            report.add(
                Problem::error(bits.at.clone(), format!("parameter `{}` has no outputs", name.value))
                    .hint("name the outputs that carry it, the lowest bit first"),
            );
        }
        for (nth, bit) in bits.value.iter().enumerate() {
            if let Some(earlier) = bits.value[..nth].iter().find(|earlier| earlier.value == bit.value) {
                report.add(
                    Problem::error(bit.at.clone(), format!("`{}` is two bits of one parameter", bit.value))
                        .also(&earlier.at, "the other one"),
                );
            }
        }
    }
}

/// The operations a recovery path from `op` may name: those of its task before it.
pub(super) fn earlier_in_task(station: &DraftStation<'_>, op: OpId) -> Option<std::ops::Range<usize>> {
    let task = station.operation(op).task.as_ref()?.value;
    let ops = &station.tasks[task.index()].ops;
    ops.contains(&op.index()).then(|| ops.start..op.index())
}
