//! Orders to stations, beside the line that describes them: is there such a task, and are its numbers given and small
//! enough for the outputs that carry them? Without a line nothing is checked here.

use std::time::Duration;

use linewright_line::{Parameter, Task};
use linewright_text::{Located, Problem, Report, TextRange, suggestion};

use super::durations::{charted, time_left_out};
use super::orders::{expected, times};
use crate::ParameterSource;
use crate::parse::draft::{DraftActivity, DraftCell, DraftOrder};

/// Applies the rules to each order.
pub(super) fn orders_fit_their_tasks(draft: &DraftCell<'_>, report: &mut Report) {
    for activity in &draft.activities {
        for order in &activity.orders {
            if let Some(task) = task_of(draft, activity, order, report) {
                times_fit_the_motions(draft, activity, order, task, report);
                parameters_are_the_tasks(order, task, report);
                numbers_fit(draft, activity, order, task, report);
            }
        }
    }
    stations_have_something_to_do(draft, report);
    stores_are_as_large(draft, report);
}

/// The task an order is for, or a problem with those there are.
fn task_of<'d>(
    draft: &DraftCell<'d>,
    activity: &DraftActivity<'_>,
    order: &DraftOrder<'_>,
    report: &mut Report,
) -> Option<&'d Task> {
    let line = draft.line?;
    let (station, task) = (order.raw.station.as_ref()?, order.raw.task.as_ref()?);
    let of = line.station(line.station_named(&station.value)?);
    if !of.is_task_driven() {
        report.add(
            Problem::error(station.at.clone(), format!("station `{}` is not task-driven", station.value))
                .hint("give it tasks in the line's description, instead of `home`"),
        );
        return None;
    }
    let found = of.task_named(&task.value).map(|id| of.task(id));
    if found.is_none() {
        let message = format!("station `{}` has no task `{}`", station.value, task.value);
        report.add(match expected(draft, activity, &task.value) {
            Some((resource, right)) => Problem::error(station.at.clone(), message).hint(format!(
                "`{right}`, the station of `{}`, has it and no order here: `station = \"{right}\"`",
                resource.name
            )),
            None => Problem::error(task.at.clone(), message)
                .maybe_hint(suggestion(&task.value, of.tasks.iter().map(|task| task.name.as_str()))),
        });
    }
    found
}

/// The limit of an order, `max_s` or a multiple of the nominal time, is longer than the motions of its task: otherwise every order
/// fails. A task fails itself when its own limit is over.
fn times_fit_the_motions(
    draft: &DraftCell<'_>,
    activity: &DraftActivity<'_>,
    order: &DraftOrder<'_>,
    task: &Task,
    report: &mut Report,
) {
    let Some(takes) = charted(draft, order).map(|of| of.takes()) else { return };
    let safety = draft.raw.cell.as_ref().map_or(1.0, |cell| cell.safety);
    let left_out = time_left_out(draft, activity).map(|time| time.longest);
    let limits: Vec<(Located<Duration>, &str, f64)> = match &order.raw.limit {
        // One that is not even longer than the nominal time is an error already.
        Some(limit)
            if times(draft, activity).map(|time| time.value).chain(left_out).any(|time| limit.value <= time) =>
        {
            Vec::new()
        }
        Some(limit) => vec![(limit.clone(), "max_s", 1.0)],
        None => times(draft, activity).map(|time| (time, "time_s", safety)).collect(),
    };
    let (name, motions) = (&task.name, takes.as_secs_f64());
    for (limit, key, factor) in limits.into_iter().filter(|(limit, _, factor)| limit.value.mul_f64(*factor) <= takes) {
        let seconds = limit.value.as_secs_f64();
        let message = format!("`{key}` is {seconds} s, but the motions of task `{name}` take {motions} s");
        let hint = match key {
            "max_s" => "every order would fail; twice as long as the motions is usual".to_owned(),
            _ => format!(
                "an order may take {factor} times this (`safety`), and every one would fail: at least {motions} is usual"
            ),
        };
        report.add(Problem::warning(limit.at, message).label("too short").hint(hint));
    }
    for time in times(draft, activity).filter(|time| time.value > task.limit) {
        let (seconds, limit) = (time.value.as_secs_f64(), task.limit.as_secs_f64());
        report.add(
            Problem::warning(time.at, format!("`time_s` is {seconds} s, but task `{name}` has `limit_s = {limit}`"))
                .label("too long")
                .hint("the task fails when its `limit_s` is over: a longer one in the line's description, or a shorter time"),
        );
    }
    if let Some(time) = left_out.filter(|time| *time > task.limit) {
        let (seconds, limit) = (time.as_secs_f64(), task.limit.as_secs_f64());
        let message = format!(
            "`{}` takes {seconds} s by the operations of its tasks, but task `{name}` has `limit_s = {limit}`",
            activity.name
        );
        report.add(Problem::warning(order.raw.at.clone(), message).label("too long").hint(
            "the task fails when its `limit_s` is over: a longer one in the line's description, or shorter operations",
        ));
    }
}

fn parameters_are_the_tasks(order: &DraftOrder<'_>, task: &Task, report: &mut Report) {
    for (name, _) in &order.raw.parameters {
        if !task.parameters.iter().any(|known| known.name == name.value) {
            let names = task.parameters.iter().map(|known| known.name.as_str());
            report.add(
                Problem::error(name.at.clone(), format!("task `{}` has no parameter `{}`", task.name, name.value))
                    .maybe_hint(suggestion(&name.value, names)),
            );
        }
    }
    for missing in &task.parameters {
        if !order.raw.parameters.iter().any(|(name, _)| name.value == missing.name) {
            report.add(
                Problem::error(
                    order.raw.at.clone(),
                    format!("task `{}` needs its parameter `{}`", task.name, missing.name),
                )
                .hint("a station takes on no order without all its numbers"),
            );
        }
    }
}

fn numbers_fit(
    draft: &DraftCell<'_>,
    activity: &DraftActivity<'_>,
    order: &DraftOrder<'_>,
    task: &Task,
    report: &mut Report,
) {
    for (name, source) in &order.parameters {
        let Some(parameter) = task.parameters.iter().find(|known| known.name == *name) else { continue };
        let written = order.raw.parameters.iter().find(|(known, _)| known.value == *name);
        let at = written.map_or_else(|| order.raw.at.clone(), |(_, value)| value.at.clone());
        match *source {
            ParameterSource::Number(number) => fits(parameter, i64::from(number), &at, None, report),
            ParameterSource::Position(store) => {
                let capacity = draft.resource(store).capacity.map_or(0, i64::from);
                fits(parameter, capacity, &at, Some(&draft.resource(store).place()), report);
            }
            ParameterSource::Program => {
                for (program, place) in programs(draft, activity) {
                    fits(parameter, program, &place, Some(&at), report);
                }
            }
        }
    }
}

/// The programs of the steps that an activity is for.
fn programs(draft: &DraftCell<'_>, activity: &DraftActivity<'_>) -> Vec<(i64, TextRange)> {
    let of = activity.uses.first().and_then(|part| part.value.of);
    let on = draft.steps().flat_map(|step| step.on.iter().zip(&step.raw.on));
    let mine = on.filter(|(on, _)| **on == of && of.is_some());
    mine.filter_map(|(_, raw)| raw.program.as_ref().map(|program| (program.value, program.at.clone()))).collect()
}

fn fits(parameter: &Parameter, number: i64, at: &TextRange, also: Option<&TextRange>, report: &mut Report) {
    if (0..=i64::from(parameter.most())).contains(&number) {
        return;
    }
    let problem = Problem::error(at.clone(), format!("`{}` cannot be {number}", parameter.name));
    let bits = parameter.bits.len();
    let problem = problem.hint(format!("it stands on {bits} outputs: 0 to {}", parameter.most()));
    report.add(match also {
        Some(also) => problem.also(also, "for this"),
        None => problem,
    });
}

/// A task-driven station that never gets one was left out by mistake, or is not needed.
fn stations_have_something_to_do(draft: &DraftCell<'_>, report: &mut Report) {
    let Some(line) = draft.line else { return };
    let orders = || draft.activities.iter().flat_map(|activity| &activity.orders);
    let is_told = |name: &str| orders().any(|order| order.raw.station.as_ref().is_some_and(|s| s.value == name));
    for station in line.stations.iter().filter(|station| station.is_task_driven() && !is_told(&station.name)) {
        report.add(
            Problem::warning(0..0, format!("nothing is ordered of station `{}`", station.name))
                .hint("an `[[action]]` or a `[[sync]]` orders its tasks"),
        );
    }
}

/// Where the line gives the number of positions of a store, the cell has no more. Of a buffer in which parts move up by
/// themselves a holder of its name is the place where they are put in or taken out.
fn stores_are_as_large(draft: &DraftCell<'_>, report: &mut Report) {
    let Some(line) = draft.line else { return };
    for store in draft.resources.iter().filter(|r| r.prototype.is_some_and(crate::Prototype::has_positions)) {
        let holder = line.handling.holder_named(store.name).map(|id| line.handling.holder(id));
        let (Some(holder), Some(capacity)) = (holder, store.capacity) else { continue };
        if u32::from(holder.places) < capacity {
            let at = store.raw.capacity.as_ref().map_or_else(|| store.place(), |capacity| capacity.at.clone());
            report.add(
                Problem::error(at, format!("`{}` has room for {capacity} parts", store.name))
                    .hint(format!("its holder in the line's description has {} places", holder.places)),
            );
        }
    }
}
