//! Why a part does not go on: what it could do next, and for each of these what it lacks and who has that; and why a resource
//! is left out.
//!
//! Who has a token is said only where the net says it: the activity in progress that will give it back, or the modes that
//! would if they happened, with the parts that wait for them.

use std::time::Duration;

use linewright_line::Tick;

use super::super::exception::{AlarmSubject, ExceptionStage, OutOfServiceReason};
use super::super::firing::{ActivityPhase, OngoingActivity};
use super::super::ids::{CellId, FiringId, ModeId, PartId, ResourceId};
use super::super::plan::{ActivityTiming, CellKind};
use super::super::state::{PartPlace, PlayerState};
use super::super::table::CellTable;
use super::ways::ShortestRoutes;
use super::words::{Reasons, called, reason};

/// At most so many are named where many would do.
const NAMED_MAX: usize = 3;

/// Why a part is where it is, in sentences; the first says where that is.
pub fn why_not(ways: &ShortestRoutes, reasons: &Reasons, state: &PlayerState, now: Tick, part: PartId) -> Vec<String> {
    let table = state.table();
    let Some(found) = state.part(part) else { return vec![format!("{part} is not in the cell.")] };
    let cell = match found.place {
        PartPlace::In(firing) => {
            let of = state.firing(firing).map(|firing| progress(state, firing, now));
            return vec![format!("{part} is under way: {}.", of.unwrap_or_default())];
        }
        PartPlace::On { cell, arrival: _ } => cell,
    };
    let mut lines = vec![format!("{part} has been {} for {} s.", place(table, cell), seconds(now.since(found.since)))];
    let options: Vec<_> = table.consumers(cell).iter().copied().filter(|&m| table.part_in(m) == Some(cell)).collect();
    if options.is_empty() {
        lines.push("Nothing takes it on from there.".to_owned());
    }
    for mode in options {
        lines.push(format!("{}: {}.", called(table, mode, None), option(ways, reasons, state, now, part, mode)));
    }
    lines
}

/// In tenths: nobody waits for less.
fn seconds(span: Duration) -> f64 {
    (span.as_secs_f64() * 10.0).round() / 10.0
}

/// Where a cell of the net is, as people say it where that is known.
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
    state: &PlayerState,
    now: Tick,
    part: PartId,
    mode: ModeId,
) -> String {
    let table = state.table();
    if let Some(first) = state.takeable(mode).next().filter(|_| !state.takeable(mode).any(|able| able == part)) {
        return format!("{first} has to be taken first");
    }
    let lacked = table.takes(mode).iter().filter(|&&(cell, weight)| state.marking().count(cell) < u64::from(weight));
    let lacked: Vec<String> = lacked.map(|&(cell, _)| owner(ways, state, now, cell)).collect();
    let last = reasons.of(mode);
    if let Some(resource) = state.needs_down(mode) {
        return left_out(state, now, resource);
    }
    if !lacked.is_empty() {
        let before = last.map(|(at, why)| format!("; at {at} it was held: {}", reason(table, why)));
        return lacked.join("; ") + &before.unwrap_or_default();
    }
    if state.room(mode) == 0 {
        return "it is in progress as often as it may be".to_owned();
    }
    match state.held().iter().find(|(held, _)| *held == mode) {
        Some((_, why)) => reason(table, why),
        None => {
            "it has what it takes, and is started when the cell may start things and its stations are heard".to_owned()
        }
    }
}

/// Why a resource is not counted on, if it is not, and the alarm that asks about it, in sentences.
pub fn why_out(state: &PlayerState, now: Tick, resource: ResourceId) -> Vec<String> {
    let mut lines = vec![format!("{}.", left_out(state, now, resource))];
    let asks = state.exceptions().alarms().find(|alarm| alarm.about == AlarmSubject::Resource(resource));
    lines.extend(asks.map(|alarm| format!("{}: {}", alarm.id, alarm.text)));
    lines
}

/// Where what a cell lacks is.
fn owner(ways: &ShortestRoutes, state: &PlayerState, now: Tick, cell: CellId) -> String {
    let table = state.table();
    let name = table.cell_name(cell);
    let gives = |firing: &&OngoingActivity| table.gives(firing.mode).iter().any(|(to, _)| *to == cell);
    let held: Vec<_> =
        state.firings().filter(gives).take(NAMED_MAX).map(|firing| progress(state, firing, now)).collect();
    if !held.is_empty() {
        return format!("`{name}` is with {}", held.join(", and with "));
    }
    let waits = ways.producers(cell).iter().filter_map(|&mode| Some((mode, resting(state, mode)?)));
    let waits: Vec<_> =
        waits.take(NAMED_MAX).map(|(mode, part)| format!("{} of {part}", called(table, mode, None))).collect();
    match (waits.is_empty(), ways.producers(cell).is_empty()) {
        (false, _) => format!("`{name}` comes back by {}, which has not started", waits.join(", or ")),
        (true, false) => format!("there is no `{name}` yet"),
        (true, true) => format!("there is no `{name}`, and nothing gives it"),
    }
}

/// Why a resource is not counted on.
fn left_out(state: &PlayerState, now: Tick, resource: ResourceId) -> String {
    let name = state.table().handling().resource_name(resource);
    let Some(down) = state.exceptions().is_down(resource) else { return format!("{name} is counted on") };
    let since = seconds(now.since(down.since));
    let why = match &down.why {
        OutOfServiceReason::ByHand { text } if text.is_empty() => "somebody has left it out".to_owned(),
        OutOfServiceReason::Alarm { text } if text.is_empty() => "somebody has given alarm".to_owned(),
        OutOfServiceReason::ByHand { text } | OutOfServiceReason::Alarm { text } => {
            format!("somebody has given alarm: {text}")
        }
        OutOfServiceReason::Rule(firing) => format!("the rule for {firing} leaves it out"),
        OutOfServiceReason::Station(firing) => format!("its station could not work after {firing}"),
        OutOfServiceReason::EmergencyStop(firing) => format!("its station went into emergency stop after {firing}"),
        OutOfServiceReason::Mismatch => "its sensor says otherwise than the model".to_owned(),
    };
    format!("{name} has been left out for {since} s: {why}")
}

/// What a failed activity waits for.
fn waits(state: &PlayerState, firing: FiringId) -> String {
    match state.exceptions().trouble(firing).map(|trouble| &trouble.stage) {
        Some(ExceptionStage::Securing) => "waits for its stations to come to rest".to_owned(),
        Some(ExceptionStage::Waiting(alarm)) => format!("waits for an answer to {alarm}"),
        Some(ExceptionStage::Restoring { .. }) => "waits for sensors to agree with what was answered".to_owned(),
        None => "waits for somebody to look".to_owned(),
    }
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
        (ActivityPhase::Failed(_), _) => format!("{what}, which has failed and {}", waits(state, firing.id)),
        (ActivityPhase::Running, ActivityTiming::Immediate) => what,
        (ActivityPhase::Running, ActivityTiming::Decided { time, limit: _ }) => {
            let left = seconds((firing.began + time).since(now));
            if left > 0.0 { format!("{what}, {left} s left") } else { format!("{what}, longer than it should be") }
        }
    }
}
