//! Resolution of the names of a scenario, and its consistency.

use std::collections::{BTreeMap, BTreeSet};

use linewright_cell::{Activity, ActivityId, ActivityKind, Cell, ResourceId, Role, fits};
use linewright_coordinator_cell::production::{NAME_MAX, ProductionOrderRequest};
use linewright_line::Tick;
use linewright_plant::MotionFault;
use linewright_text::{Located, LocatedName, Problem, Report, TextRange, suggestion};

use super::raw::{RawArrivals, RawBreakdown, RawCellScenario, RawScenarioOrder, RawScenarioStep, RawTime};
use super::{BreakdownPattern, CellScenario, OrderArrivals, ScriptedFault, StationFault, moment};
use crate::scenario::faults::FaultOf;

pub(super) fn resolve(cell: &Cell, raw: &RawCellScenario, report: &mut Report) -> CellScenario {
    let seconds = |value: &Option<Located<f64>>| value.as_ref().map(|value| moment(value.value).since(Tick::ZERO));
    let warm_up = seconds(&raw.warm_up).unwrap_or_default();
    let duration = seconds(&raw.duration);
    if let (Some(warm), Some(duration)) = (&raw.warm_up, duration)
        && warm_up >= duration
    {
        let problem = Problem::error(warm.at.clone(), "nothing is left after `warm_up_s`");
        report.add(problem.hint(format!("less than `duration_s`, {} s", duration.as_secs_f64())));
    }
    let mut names = OrderNames::default();
    let orders = orders(cell, &raw.orders, &mut names, report);
    let arrivals = raw.arrivals.iter().filter_map(|of| arrivals(cell, of, raw, &mut names, report)).collect();
    CellScenario {
        title: raw.title.as_ref().map(|title| title.value.clone()),
        duration,
        warm_up,
        replications: raw.replications.as_ref().map(|count| count.value as usize),
        precision: raw.precision.as_ref().map(|percent| percent.value / 100.0),
        confidence: raw.confidence / 100.0,
        orders,
        arrivals,
        times: times(cell, &raw.times, report),
        breakdowns: breakdowns(cell, &raw.breakdowns, report),
        faults: faults(cell, &raw.steps, report),
    }
}

/// The names of orders that are known from the beginning, and the beginnings of those that come.
#[derive(Default)]
struct OrderNames {
    taken: BTreeMap<String, TextRange>,
}

impl OrderNames {
    fn take(&mut self, name: &str, at: &TextRange, what: &str, report: &mut Report) {
        if let Some(first) = self.taken.insert(name.to_owned(), at.clone()) {
            let problem = Problem::error(at.clone(), format!("two {what} are called `{name}`"));
            report.add(problem.label("again").also(&first, "first here").hint("give them names with `name`"));
        }
    }
}

/// The name of a part type that there is.
fn part(cell: &Cell, name: Option<&LocatedName>, report: &mut Report) -> Option<String> {
    let name = name?;
    if cell.part_type_named(&name.value).is_none() {
        let known = cell.part_types.iter().map(|of| of.name.as_str());
        let problem = Problem::error(name.at.clone(), format!("unknown part type `{}`", name.value));
        report.add(problem.maybe_hint(suggestion(&name.value, known)));
        return None;
    }
    Some(name.value.clone())
}

fn is_name(name: &LocatedName, report: &mut Report) -> bool {
    let letters = name.value.chars().count();
    // Behind the name of arrivals stands a number.
    let fits = letters > 0 && letters + 12 <= NAME_MAX && !name.value.chars().any(char::is_control);
    if !fits {
        let problem = Problem::error(name.at.clone(), "no usable name for orders");
        report.add(problem.hint(format!("one line of 1 to {} letters", NAME_MAX - 12)));
    }
    fits
}

fn orders(
    cell: &Cell,
    raw: &[RawScenarioOrder],
    names: &mut OrderNames,
    report: &mut Report,
) -> Vec<ProductionOrderRequest> {
    let mut orders: Vec<ProductionOrderRequest> = Vec::new();
    for (index, raw) in raw.iter().enumerate() {
        let product = part(cell, raw.part.as_ref(), report);
        let name = match &raw.name {
            Some(name) if !is_name(name, report) => continue,
            Some(name) => name.value.clone(),
            None => format!("order {}", index + 1),
        };
        names.take(&name, raw.name.as_ref().map_or(&raw.at, |name| &name.at), "orders", report);
        if let (Some(due), Some(release)) = (&raw.due, &raw.release)
            && due.value < release.value
        {
            let problem = Problem::error(due.at.clone(), format!("`{name}` is due before it is released"));
            report.add(problem.also(&release.at, "released here").hint("`due_s` counts from the beginning as well"));
        }
        let mut after = Vec::new();
        for before in raw.after.iter().flat_map(|names| &names.value) {
            // Only what stands before it: so nothing waits in a circle.
            if orders.iter().any(|order| order.name == before.value) {
                after.push(before.value.clone());
            } else {
                let known = orders.iter().map(|order| order.name.as_str());
                let problem = Problem::error(before.at.clone(), format!("no order `{}` before this one", before.value));
                report.add(problem.maybe_hint(suggestion(&before.value, known)));
            }
        }
        orders.push(ProductionOrderRequest {
            key: index as u128 + 1,
            name,
            product: product.unwrap_or_default(),
            quantity: u32::try_from(raw.quantity).unwrap_or(u32::MAX),
            release: raw.release.as_ref().map(|at| moment(at.value)),
            due: raw.due.as_ref().map(|at| moment(at.value)),
            priority: i32::try_from(raw.priority).unwrap_or_default(),
            after,
        });
    }
    orders
}

fn arrivals(
    cell: &Cell,
    raw: &RawArrivals,
    all: &RawCellScenario,
    names: &mut OrderNames,
    report: &mut Report,
) -> Option<OrderArrivals> {
    let product = part(cell, raw.part.as_ref(), report);
    let name = raw.name.as_ref().or(raw.part.as_ref())?;
    if !is_name(name, report) {
        return None;
    }
    names.take(&name.value, &name.at, "arrivals", report);
    if raw.until.is_none() && raw.count.is_none() && all.duration.is_none() {
        let problem = Problem::error(raw.at.clone(), format!("arrivals of `{}` never end", name.value));
        report.add(problem.hint("say `count`, `until_s`, or `duration_s` of the scenario"));
    }
    Some(OrderArrivals {
        name: name.value.clone(),
        product: product?,
        quantity: u32::try_from(raw.quantity).unwrap_or(u32::MAX),
        every: raw.every.as_ref()?.value,
        first: raw.first.as_ref().map(|at| moment(at.value)),
        until: raw.until.as_ref().map_or(Tick::NEVER, |at| moment(at.value)),
        count: raw.count.as_ref().map_or(u64::MAX, |count| count.value.unsigned_abs()),
        due_after: raw.due_after.as_ref().map(|after| after.value),
        priority: i32::try_from(raw.priority).unwrap_or_default(),
    })
}

/// The first table that fits an activity counts for it.
fn times(cell: &Cell, raw: &[RawTime], report: &mut Report) -> Vec<(ActivityId, super::Distribution)> {
    let mut found: BTreeMap<ActivityId, super::Distribution> = BTreeMap::new();
    for raw in raw {
        for pattern in raw.of.iter().flat_map(|names| &names.value) {
            let meant = || cell.activity_ids().filter(|&id| fits(&pattern.value, &cell.activity(id).name));
            if meant().next().is_none() {
                let known = cell.activities.iter().map(|activity| activity.name.as_str());
                let message = format!("`{}` fits no synchronisation and no action", pattern.value);
                report.add(Problem::error(pattern.at.clone(), message).maybe_hint(suggestion(&pattern.value, known)));
                continue;
            }
            let by_clock = |id: &ActivityId| cell.activity(*id).orders.is_empty();
            if meant().all(|id| by_clock(&id)) {
                let name = meant().next().map_or("", |id| cell.activity(id).name.as_str());
                let message = format!("no station works in `{name}`: it ends by the clock");
                let hint = format!("give it `orders`, in `[[sync]]` or in an `[[action]]` of \"{name}\"");
                report.add(Problem::error(pattern.at.clone(), message).hint(hint));
            }
            if let Some(factor) = &raw.factor {
                meant().filter(|id| !by_clock(id)).for_each(|id| _ = found.entry(id).or_insert(factor.value));
            }
        }
    }
    found.into_iter().collect()
}

fn breakdowns(cell: &Cell, raw: &[RawBreakdown], report: &mut Report) -> Vec<BreakdownPattern> {
    let mut seen = BTreeSet::new();
    let mut patterns = Vec::new();
    for raw in raw {
        let Some(resource) = raw.resource.as_ref().and_then(|name| breakable(cell, name, report)) else { continue };
        let name = raw.name.as_ref().map_or("", |name| name.value.as_str());
        if !seen.insert((resource, name)) {
            let of = &cell.resource(resource).name;
            let problem = Problem::error(raw.at.clone(), format!("`{of}` breaks down twice in the same way"));
            report.add(problem.hint("give each breakdown of one resource a `name`"));
        }
        let (Some(between), Some(repair)) = (&raw.between, &raw.repair) else { continue };
        patterns.push(BreakdownPattern {
            resource,
            name: name.to_owned(),
            between: between.value,
            repair: repair.value,
            clock: raw.clock,
        });
    }
    patterns
}

/// A resource that can stand: it has a station, which does its orders.
fn breakable(cell: &Cell, name: &LocatedName, report: &mut Report) -> Option<ResourceId> {
    let Some(id) = cell.resource_ids().find(|&id| cell.resource(id).name == name.value) else {
        let known = cell.resources.iter().map(|resource| resource.name.as_str());
        let problem = Problem::error(name.at.clone(), format!("unknown resource `{}`", name.value));
        report.add(problem.maybe_hint(suggestion(&name.value, known)));
        return None;
    };
    let Some(station) = cell.resource(id).controller else {
        let message = format!("`{}` has no station that could fail", name.value);
        report.add(Problem::error(name.at.clone(), message).hint("give the resource a `station`"));
        return None;
    };
    let does = |activity: &Activity| {
        let is_its = |role| activity.used(role).is_some_and(|part| part.of == Some(id));
        let works = activity.kind == ActivityKind::Process && is_its(Role::Worker);
        (works || is_its(Role::Carrier)) && !activity.is_logical()
    };
    let unordered = |activity: &&Activity| activity.orders.iter().all(|order| order.controller != station);
    if let Some(activity) = cell.activities.iter().filter(|activity| does(activity)).find(unordered) {
        let (activity, station) = (&activity.name, &cell.controllers[station.index()]);
        let message = format!("`{activity}` would go on while `{}` stands: `{station}` has no order in it", name.value);
        let hint = format!("give `{activity}` an order to `{station}` in the description of the cell");
        report.add(Problem::error(name.at.clone(), message).hint(hint));
        return None;
    }
    Some(id)
}

fn faults(cell: &Cell, raw: &[RawScenarioStep], report: &mut Report) -> Vec<ScriptedFault> {
    let (mut now, mut found) = (Tick::ZERO, Vec::new());
    for raw in raw {
        now = now.max(raw.at_s.as_ref().map_or(now, |at| moment(at.value)));
        now = now + raw.after.as_ref().map_or(std::time::Duration::ZERO, |after| moment(after.value).since(Tick::ZERO));
        match raw.faults.as_slice() {
            [] => {
                let problem = Problem::error(raw.at.clone(), "a step that does nothing");
                report.add(problem.hint("`break`, `stick` or `clear` a resource"));
            }
            [one] => found.extend(fault(cell, one, now, report)),
            [_, (_, second), ..] => {
                let problem = Problem::error(second.at.clone(), "a step does one thing");
                report.add(
                    problem.hint("give the second one a step of its own; steps follow each other without a pause"),
                );
            }
        }
    }
    found
}

fn fault(cell: &Cell, (fault, name): &FaultOf, at: Tick, report: &mut Report) -> Option<ScriptedFault> {
    let fault = match fault {
        Some(MotionFault::Break) => StationFault::Break,
        Some(MotionFault::Stick) => StationFault::Stick,
        None => StationFault::Clear,
        Some(fault @ (MotionFault::Slip | MotionFault::SlipBack | MotionFault::Miss | MotionFault::Drop)) => {
            let message =
                format!("`{}` is a fault of a mechanism, and stations of a cell are simulated whole", fault.name());
            report.add(Problem::error(name.at.clone(), message).hint("`break`, `stick` or `clear`"));
            return None;
        }
    };
    Some(ScriptedFault { at, resource: breakable(cell, name, report)?, fault })
}
