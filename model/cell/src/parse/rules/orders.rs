//! Orders to stations.

use std::collections::HashMap;
use std::time::Duration;

use linewright_line::{Line, StationId, TaskId};
use linewright_text::{Located, Problem, Report, suggestion};

use super::durations::time_left_out;
use super::resources::station_exists;
use crate::parse::draft::{DraftActivity, DraftCell, DraftOrder, DraftResource};
use crate::parse::raw::RawOn;
use crate::{ActivityKind, ParameterSource, Prototype, ResourceId};

pub(super) fn stations_exist(draft: &DraftCell<'_>, report: &mut Report) {
    let orders = draft.activities.iter().flat_map(|activity| &activity.orders);
    for station in orders.filter_map(|order| order.raw.station.as_ref()) {
        if let Some(line) = draft.line {
            station_exists(line, station, report);
        } else {
            let names = draft.resources.iter().filter_map(|r| Some(r.raw.station.as_ref()?.value.as_str()));
            if !names.clone().any(|name| name == station.value) {
                report.add(
                    Problem::warning(station.at.clone(), format!("station `{}` is no resource's", station.value))
                        .maybe_hint(suggestion(&station.value, names)),
                );
            }
        }
    }
}

pub(super) fn each_station_gets_one(activity: &DraftActivity<'_>, report: &mut Report) {
    let mut told = HashMap::new();
    for order in &activity.orders {
        let (Some(id), Some(station)) = (order.controller, &order.raw.station) else { continue };
        if let Some(earlier) = told.insert(id, &station.at) {
            report.add(
                Problem::error(station.at.clone(), format!("`{}` gives `{}` two orders", activity.name, station.value))
                    .also(earlier, "the first")
                    .hint("a station does one task at a time; make one task of them"),
            );
        }
    }
}

/// An order without a limit could be waited for until the end of days.
pub(super) fn limits_are_known_and_exceed_times(
    draft: &DraftCell<'_>,
    activity: &DraftActivity<'_>,
    report: &mut Report,
) {
    let charted = time_left_out(draft, activity).map(|time| time.longest);
    // Of equal ones the first that is written.
    let written =
        times(draft, activity).reduce(|longest, time| if time.value > longest.value { time } else { longest });
    let longest = written.as_ref().map(|time| time.value).into_iter().chain(charted).max();
    for order in &activity.orders {
        match (&order.raw.limit, longest) {
            (Some(limit), Some(time)) if limit.value <= time => {
                let problem = Problem::error(limit.at.clone(), format!("`max_s` is {} s", limit.value.as_secs_f64()))
                    .label("too short")
                    .hint(format!("`{}` takes {} s itself", activity.name, time.as_secs_f64()));
                report.add(match written.as_ref().filter(|written| written.value == time) {
                    Some(written) => problem.also(&written.at, "its time"),
                    None => problem,
                });
            }
            (None, None) if activity.kind != ActivityKind::Process => report.add(
                Problem::error(order.raw.at.clone(), "lateness of this order cannot be determined")
                    .hint(format!("give it `max_s`, or `{}` a `time_s`", activity.name)),
            ),
            (Some(_), _) | (None, _) => {}
        }
    }
}

/// The station and task of an order; none where the line has no such station or task, which is another rule's error.
pub(super) fn ordered(line: &Line, order: &DraftOrder<'_>) -> Option<(StationId, TaskId)> {
    let station = line.station_named(&order.raw.station.as_ref()?.value)?;
    Some((station, line.station(station).task_named(&order.raw.task.as_ref()?.value)?))
}

/// An order of a station of another resource than those that take part in the activity: the order, and that resource.
fn misdirected<'o, 'a>(
    draft: &'o DraftCell<'a>,
    activity: &'o DraftActivity<'a>,
) -> impl Iterator<Item = (&'o DraftOrder<'a>, &'o DraftResource<'a>)> {
    activity.orders.iter().filter_map(|order| {
        let mut owners = draft.resources.iter().enumerate().filter(|(_, of)| of.controller == order.controller);
        let (id, owner) = owners.next().filter(|_| order.controller.is_some())?;
        let is_used = activity.uses.iter().any(|part| part.value.of == Some(ResourceId::at(id)));
        (!is_used && activity.is_whole).then_some((order, owner))
    })
}

/// The resources that take part in an activity, and whose stations have no order in it.
fn without_order<'o, 'a>(
    draft: &'o DraftCell<'a>,
    activity: &'o DraftActivity<'a>,
) -> impl Iterator<Item = (&'o DraftResource<'a>, &'o str)> {
    let used = activity.uses.iter().filter_map(|part| Some(draft.resource(part.value.of?)));
    let is_ordered = |of: &DraftResource<'_>| activity.orders.iter().any(|order| order.controller == of.controller);
    used.filter(move |of| of.controller.is_some() && !is_ordered(of))
        .filter_map(|of| Some((of, of.raw.station.as_ref()?.value.as_str())))
}

/// What an activity orders is done by the stations of its resources. Another one is an error where the right one is left without an order,
/// and has a task of that name.
pub(super) fn orders_are_for_stations_of_the_activity(
    draft: &DraftCell<'_>,
    activity: &DraftActivity<'_>,
    report: &mut Report,
) {
    let Some(line) = draft.line else { return };
    for (order, owner) in misdirected(draft, activity) {
        let (Some(station), Some(task)) = (&order.raw.station, &order.raw.task) else { continue };
        if ordered(line, order).is_none() {
            continue;
        }
        let message = format!(
            "`{}` orders `{}` of `{}`, the station of `{}`, which takes no part in it",
            activity.name, task.value, station.value, owner.name
        );
        report.add(match expected(draft, activity, &task.value) {
            Some((of, right)) => Problem::error(station.at.clone(), message).label("another station").hint(format!(
                "`{right}`, the station of `{}`, has such a task and no order here: `station = \"{right}\"`",
                of.name
            )),
            None => Problem::warning(station.at.clone(), message).label("another station").hint(format!(
                "order it of a station of the resources in `actions`, or name what `{}` does there",
                owner.name
            )),
        });
    }
}

/// The resource of the activity whose station has this task, and no order yet.
pub(super) fn expected<'o>(
    draft: &'o DraftCell<'_>,
    activity: &'o DraftActivity<'_>,
    task: &str,
) -> Option<(&'o DraftResource<'o>, &'o str)> {
    let line = draft.line?;
    let mut left = without_order(draft, activity);
    left.find(|(_, name)| line.station_named(name).is_some_and(|id| line.station(id).task_named(task).is_some()))
}

/// The nominal times of an activity: of a process, those of the steps that it is for.
pub(super) fn times<'d>(
    draft: &'d DraftCell<'_>,
    activity: &'d DraftActivity<'_>,
) -> impl Iterator<Item = Located<Duration>> + 'd {
    works(draft, activity).filter_map(|raw| raw.time.clone()).chain(activity.time.clone())
}

/// What the steps that a process is for say of its resource; nothing of another activity.
pub(super) fn works<'d>(
    draft: &'d DraftCell<'_>,
    activity: &'d DraftActivity<'_>,
) -> impl Iterator<Item = &'d RawOn> + 'd {
    let of = activity.uses.first().and_then(|part| part.value.of);
    let pairs = draft.steps().flat_map(|step| step.on.iter().zip(&step.raw.on));
    pairs
        .filter(move |(on, _)| activity.kind == ActivityKind::Process && **on == of && of.is_some())
        .map(|(_, raw)| raw)
}

pub(super) fn parameters_are_there(draft: &DraftCell<'_>, activity: &DraftActivity<'_>, report: &mut Report) {
    for order in &activity.orders {
        for (name, source) in &order.parameters {
            let at = || {
                let found = order.raw.parameters.iter().find(|(known, _)| known.value == *name);
                found.map_or_else(|| order.raw.at.clone(), |(_, value)| value.at.clone())
            };
            match *source {
                ParameterSource::Number(_) => {}
                ParameterSource::Position(store) => {
                    let takes_part = activity.uses.iter().any(|part| part.value.of == Some(store));
                    let is_store = draft.resource(store).prototype.is_none_or(Prototype::has_positions);
                    if activity.is_whole && !(takes_part && is_store) {
                        let name = draft.resource(store).name;
                        report.add(
                            Problem::error(at(), format!("`{name}` has no position in `{}`", activity.name))
                                .hint("a part has a position in a `random-access-store` or `lifo-buffer` that it comes from or goes to"),
                        );
                    }
                }
                ParameterSource::Program => program_is_given(draft, activity, &at(), report),
            }
        }
    }
}

fn program_is_given(
    draft: &DraftCell<'_>,
    activity: &DraftActivity<'_>,
    at: &linewright_text::TextRange,
    report: &mut Report,
) {
    if activity.kind != ActivityKind::Process {
        report.add(
            Problem::error(at.clone(), format!("`{}` is no step of a plan", activity.name))
                .hint("`step.program` is known where a machine works"),
        );
        return;
    }
    let of = activity.uses.first().and_then(|part| part.value.of);
    for step in draft.steps() {
        let here = step.on.iter().zip(&step.raw.on).filter(|(on, raw)| **on == of && !raw.has_program);
        for (_, raw) in here {
            report.add(
                Problem::error(raw.at.clone(), format!("step `{}` gives no program", step.name))
                    .also(at, "the order needs one")
                    .hint("add `program = …`"),
            );
        }
    }
}
