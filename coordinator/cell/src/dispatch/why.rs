//! Reason why a part does not go on: its next modes, the tokens they lack, and the holders of those; and how a resource is, and
//! what keeps it from work. The texts are in `texts`.
//!
//! The holder of a token is given only where it follows from the net: the activity in progress that will give it back, or
//! the modes that would if they happened, with the parts that wait for them.

use std::time::Duration;

use linewright_line::{StationId, Tick};

use super::super::exception::AlarmSubject;
use super::super::firing::{ActivityPhase, OngoingActivity};
use super::super::ids::{CellId, FiringId, ModeId, PartId, ResourceId};
use super::super::plan::{ActivityTiming, CellKind};
use super::super::player::Coordination;
use super::super::state::{PartPlace, PlayerState};
use super::super::table::CellTable;
use super::Reasons;
use super::ways::ShortestRoutes;
use crate::texts::decision::tenths;
use crate::texts::resource::other_rest;
use crate::texts::wait::{failed, remaining, unready};
use crate::texts::{self, CellWait, TokenOwner, called, reason};

/// At most so many are named where many would do.
const NAMED_MAX: usize = 3;

/// Reason why a part is where it is, in sentences; the first names its place.
pub fn why_not(
    ways: &ShortestRoutes,
    reasons: &Reasons,
    coordination: &Coordination,
    now: Tick,
    part: PartId,
) -> Vec<String> {
    let state = coordination.state();
    let table = state.table();
    let Some(found) = state.part(part) else { return vec![CellWait::NotInCell(part).text()] };
    let name = texts::part(state, part);
    let cell = match found.place {
        PartPlace::In(firing) => {
            let activity = state.firing(firing).map(|firing| progress(state, firing, now)).unwrap_or_default();
            return vec![CellWait::UnderWay { part: &name, activity: &activity }.text()];
        }
        PartPlace::On { cell, arrival: _ } => cell,
    };
    let (place, seconds) = (place(table, cell), seconds(now.since(found.since)));
    let mut lines = vec![CellWait::Resting { part: &name, place: &place, seconds }.text()];
    let options: Vec<_> = table.consumers(cell).iter().copied().filter(|&m| table.part_in(m) == Some(cell)).collect();
    if options.is_empty() {
        lines.push(CellWait::NoWay.text());
    }
    for mode in options {
        let (activity, why) = (called(table, mode, None), option(ways, reasons, coordination, now, part, mode));
        lines.push(CellWait::Activity { activity: &activity, why: &why }.text());
    }
    lines
}

fn seconds(span: Duration) -> f64 {
    tenths(span.as_secs_f64())
}

/// Place of a cell of the net, in an operator's terms where there are some.
fn place(table: &CellTable, cell: CellId) -> String {
    let handling = table.handling();
    match handling.resources.iter().find(|resource| resource.has.contains(&cell)) {
        Some(resource) => format!("in {}", resource.name),
        None => format!("on `{}`", table.cell_name(cell)),
    }
}

fn option(
    ways: &ShortestRoutes,
    reasons: &Reasons,
    coordination: &Coordination,
    now: Tick,
    part: PartId,
    mode: ModeId,
) -> String {
    let state = coordination.state();
    let table = state.table();
    if let Some(first) = state.takeable(mode).next().filter(|_| !state.takeable(mode).any(|able| able == part)) {
        return CellWait::First(&texts::part(state, first)).text();
    }
    let lacked = table.takes(mode).iter().filter(|&&(cell, weight)| state.marking().count(cell) < u64::from(weight));
    let lacked: Vec<String> = lacked.map(|&(cell, _)| owner(ways, state, now, cell)).collect();
    let last = reasons.of(mode);
    if let Some(resource) = state.needs_down(mode) {
        return left_out(coordination, now, resource);
    }
    if !lacked.is_empty() {
        let held = last.map(|(at, why)| (seconds(now.since(at)), reason(table, why)));
        let held = held.as_ref().map(|(ago, why)| (*ago, why.as_str()));
        return CellWait::Tokens { owners: &lacked.join("; "), held }.text();
    }
    if state.room(mode) == 0 {
        return CellWait::InProgress.text();
    }
    if let Some(why) = coordination.unready(now, mode) {
        return unready(table, why);
    }
    if let Some(found) = coordination.other_rest(mode) {
        return other_rest(state, &found).trim_end_matches('.').to_owned();
    }
    if let Some(resource) = coordination.uncompared(mode) {
        return CellWait::Uncompared { resource: table.handling().resource_name(resource) }.text();
    }
    match state.held().iter().find(|(held, _)| *held == mode) {
        Some((_, why)) => reason(table, why),
        None => CellWait::Ready.text(),
    }
}

/// How a resource is, in sentences: whether it is counted on, what keeps its station from an order, what it takes part in, and
/// the alarms about it.
pub fn why_resource(coordination: &Coordination, now: Tick, resource: ResourceId) -> Vec<String> {
    let state = coordination.state();
    let handling = state.table().handling();
    let mut lines = vec![format!("{}.", left_out(coordination, now, resource))];
    let station = handling.resource(resource).and_then(|of| of.station);
    let trouble = station.and_then(|station| coordination.objection(now, station));
    let is_down = state.exceptions().is_down(resource).is_some();
    let waits = |station| state.exceptions().open().any(|(id, _)| has_order(state, id, station));
    if !is_down && station.is_some_and(waits) {
        lines.push(CellWait::Failed.text());
    }
    lines.extend(trouble.map(|why| format!("{}.", unready(state.table(), why))));
    let its: Vec<_> = state.firings().filter(|firing| state.concerns(firing, resource)).collect();
    lines.extend(
        its.iter().take(NAMED_MAX).map(|firing| CellWait::TakesPart { activity: &progress(state, firing, now) }.text()),
    );
    let is_its = |about: AlarmSubject| match about {
        AlarmSubject::Resource(of) => of == resource,
        AlarmSubject::Firing(id) => its.iter().any(|firing| firing.id == id),
    };
    let asks = state.exceptions().alarms().filter(|alarm| is_its(alarm.about));
    let asks: Vec<String> =
        asks.map(|alarm| format!("{}: {}", alarm.id, coordination.alarm_text(now, alarm))).collect();
    if is_down && trouble.is_none() && asks.is_empty() {
        lines.push(CellWait::ToCountOn { resource: handling.resource_name(resource) }.text());
    }
    lines.extend(asks);
    lines
}

/// Whether a station has an order of an activity.
fn has_order(state: &PlayerState, firing: FiringId, station: StationId) -> bool {
    state.firing(firing).is_some_and(|firing| firing.orders.iter().any(|order| order.station == station))
}

/// Holder of the token that a cell lacks.
fn owner(ways: &ShortestRoutes, state: &PlayerState, now: Tick, cell: CellId) -> String {
    let table = state.table();
    let name = table.cell_name(cell);
    let gives = |firing: &&OngoingActivity| table.gives(firing.mode).iter().any(|(to, _)| *to == cell);
    let held: Vec<_> =
        state.firings().filter(gives).take(NAMED_MAX).map(|firing| progress(state, firing, now)).collect();
    if !held.is_empty() {
        return TokenOwner::InUse { name, by: &held }.text();
    }
    let waits = ways.producers(cell).iter().filter_map(|&mode| Some((mode, resting(state, mode)?)));
    let waits: Vec<_> =
        waits.take(NAMED_MAX).map(|(mode, part)| format!("{} of {part}", called(table, mode, None))).collect();
    match (waits.is_empty(), ways.producers(cell).is_empty()) {
        (false, _) => TokenOwner::Returned { name, by: &waits }.text(),
        (true, false) => TokenOwner::NotYet { name }.text(),
        (true, true) => TokenOwner::Never { name }.text(),
    }
}

/// Reason why a resource is not counted on.
fn left_out(coordination: &Coordination, now: Tick, resource: ResourceId) -> String {
    let state = coordination.state();
    let name = state.table().handling().resource_name(resource);
    let Some(down) = state.exceptions().is_down(resource) else {
        return CellWait::InService { resource: name }.text();
    };
    let seconds = seconds(now.since(down.since));
    let why = coordination.left_out_because(now, resource).unwrap_or_default();
    CellWait::OutOfService { resource: name, seconds, why: &why }.text()
}

/// The part that waits for a mode, if it is where that takes it from.
fn resting(state: &PlayerState, mode: ModeId) -> Option<PartId> {
    let cell: CellId = state.table().part_in(mode)?;
    match state.table().kind(cell) {
        CellKind::Tokens => None,
        CellKind::Parts(_) => state.marking().parts(cell).next(),
    }
}

fn progress(state: &PlayerState, firing: &OngoingActivity, now: Tick) -> String {
    let mode: ModeId = firing.mode;
    let what = called(state.table(), mode, firing.part);
    match (firing.phase, state.table().activity(mode).kind) {
        (ActivityPhase::Failed(_), _) => {
            failed(&what, state.exceptions().trouble(firing.id).map(|trouble| &trouble.stage))
        }
        (ActivityPhase::Running, ActivityTiming::Immediate) => what,
        (ActivityPhase::Running, ActivityTiming::Decided { time, limit: _ }) => {
            remaining(&what, seconds((firing.began + time).since(now)))
        }
    }
}
