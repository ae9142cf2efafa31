//! What people are told of exceptions.

use std::fmt::Write;

use linewright_line::{StationId, Tick};

use super::super::firing::{OngoingActivity, OrderProgress};
use super::super::ids::{ModeId, PartId};
use super::super::record::{ActivityFailure, OrderFailure};
use super::super::state::PlayerState;
use super::fact::{RecoveryDecision, SecuredState, SensorMismatch};
use super::policy::RecoveryPolicy;

/// What is answered when a resource is as the model has it.
pub(super) const UP: &str = "up";
/// What is answered when the part that a resource should have is no more.
pub(super) const GONE: &str = "gone";

/// An alarm of an activity that has failed: what its rule has to tell, and what is known.
pub(super) fn alarm(state: &PlayerState, firing: &OngoingActivity, cause: ActivityFailure, now: Tick) -> String {
    let handling = state.table().handling();
    let tell = handling.rule(firing.mode, cause).map(|rule| filled(&rule.tell, state, firing.mode, firing.part));
    let tell = tell.unwrap_or_else(|| {
        let of = part(firing.part).map(|part| format!(" with {part}")).unwrap_or_default();
        format!("{}{of} has failed. Say where the part is.", state.table().called(firing.mode))
    });
    format!("{tell} ({})", facts(state, firing, cause, now))
}

/// What is known: `load M1: m1 has not ended in time, after 26 s; robot is at rest, m1 is at rest`.
fn facts(state: &PlayerState, firing: &OngoingActivity, cause: ActivityFailure, now: Tick) -> String {
    let handling = state.table().handling();
    let failed_after = state.exceptions().trouble(firing.id).map_or(now, |trouble| trouble.since).since(firing.began);
    let mut text = format!(
        "{}: {}, after {} s",
        state.table().called(firing.mode),
        cause_of(state, firing, cause),
        failed_after.as_millis() as f64 / 1e3
    );
    let mut joint = ";";
    for order in &firing.orders {
        let is_stopped = state.exceptions().is_stopped(order.station);
        let how = match (state.exceptions().stands(firing.id, order.key), order.state) {
            _ if is_stopped => "is in emergency stop",
            (_, OrderProgress::Ended) => "has done its part",
            (Some(SecuredState::AtRest), _) => "is at rest",
            (Some(SecuredState::Held), _) => "stands between rests",
            (Some(SecuredState::Unknown), _) => "was not heard to have come to rest",
            (None, OrderProgress::Failed(OrderFailure::Forgotten)) => "has come up without its memory",
            (None, OrderProgress::Failed(_) | OrderProgress::Written | OrderProgress::Running) => "has not begun",
        };
        // Writing to a string does not fail.
        let _ = write!(text, "{joint} {} {how}", handling.station_name(order.station));
        joint = ",";
    }
    let others = state.exceptions().stopped().filter(|id| firing.orders.iter().all(|order| order.station != *id));
    for station in others {
        let _ = write!(text, "{joint} {} is in emergency stop", handling.station_name(station));
        joint = ",";
    }
    text
}

/// Why an activity has failed, in words.
fn cause_of(state: &PlayerState, firing: &OngoingActivity, cause: ActivityFailure) -> String {
    let handling = state.table().handling();
    match cause {
        ActivityFailure::TimedOut => "it takes longer than it may".to_owned(),
        ActivityFailure::ByHand { resource } => format!("alarm was given of {}", handling.resource_name(resource)),
        ActivityFailure::Order { key, failure } => {
            let station = firing.orders.iter().find(|order| order.key == key).map(|order| order.station);
            let station = station.map_or_else(|| "a station".to_owned(), |station| handling.station_name(station));
            match failure {
                OrderFailure::Code(code) if failure.is_expiry() => {
                    format!("{station} has not ended in time, what it waited for did not come (code {code})")
                }
                OrderFailure::Code(code) => format!("{station} has ended with code {code}"),
                OrderFailure::Refused(refusal) => format!("{station} has refused ({refusal:?})"),
                OrderFailure::TimedOut => format!("{station} has not ended in time"),
                OrderFailure::Forgotten => format!("{station} does not remember it"),
                OrderFailure::Lost => format!("{station} is not heard any more"),
                OrderFailure::DevicesLost => format!("{station} has lost its devices"),
            }
        }
    }
}

/// An answer that sensors contradict.
pub(super) fn differs(
    state: &PlayerState,
    firing: &OngoingActivity,
    cause: ActivityFailure,
    ruling: &RecoveryDecision,
    found: &[SensorMismatch],
    now: Tick,
) -> String {
    let handling = state.table().handling();
    let found: Vec<String> = found.iter().map(|found| difference(handling, found)).collect();
    let again = alarm(state, firing, cause, now);
    format!("\"{}\" cannot be: {}. {again}", ruling.word, found.join("; "))
}

/// A station has moved since it was answered.
pub(super) fn moved(
    state: &PlayerState,
    firing: &OngoingActivity,
    cause: ActivityFailure,
    ruling: &RecoveryDecision,
    station: StationId,
    now: Tick,
) -> String {
    let name = state.table().handling().station_name(station);
    format!("{name} has moved since \"{}\" was answered. {}", ruling.word, alarm(state, firing, cause, now))
}

/// The carrier has the part.
pub(super) fn carried(state: &PlayerState, mode: ModeId, of: Option<PartId>) -> String {
    let text = "{carrier} has part {part}. Bring it to {to}, or back to {from}, and say which.";
    filled(text, state, mode, of)
}

/// A sensor that says otherwise than the model.
pub(super) fn mismatch(handling: &RecoveryPolicy, found: &SensorMismatch, missing: Option<PartId>) -> String {
    let or = missing.map(|part| format!("; if {part} is no more, say \"{GONE}\"")).unwrap_or_default();
    format!("{}. Put that right, and say \"{UP}\"{or}.", difference(handling, found))
}

fn difference(handling: &RecoveryPolicy, found: &SensorMismatch) -> String {
    let name = handling.resource_name(found.resource);
    match (found.model, found.plant) {
        (true, _) => format!("{name} should have a part, and its sensor says that there is none"),
        (false, _) => format!("{name} should have no part, and its sensor says that there is one"),
    }
}

fn part(of: Option<PartId>) -> Option<String> {
    of.map(|part| part.to_string())
}

/// A text with the names in braces replaced by what is meant.
fn filled(text: &str, state: &PlayerState, mode: ModeId, of: Option<PartId>) -> String {
    let handling = state.table().handling();
    let handled = handling.mode(mode);
    let name = |id: Option<super::super::ids::ResourceId>| {
        id.map_or_else(|| "outside".to_owned(), |id| handling.resource_name(id).to_owned())
    };
    let (mut filled, mut rest) = (String::with_capacity(text.len()), text);
    while let Some((before, behind)) = rest.split_once('{') {
        let Some((word, after)) = behind.split_once('}') else { break };
        filled.push_str(before);
        match word {
            "part" => filled.push_str(&of.map_or_else(|| "?".to_owned(), |PartId(number)| number.to_string())),
            "type" => filled.push_str(&handled.part_type),
            "activity" => filled.push_str(state.table().called(mode)),
            "carrier" => filled.push_str(&name(handled.carrier)),
            "from" => filled.push_str(&name(handled.from)),
            "to" => filled.push_str(&name(handled.to)),
            "slot" => {
                let of = of.and_then(|part| state.part(part));
                let slot = of.and_then(|part| part.position.or(part.target));
                filled.push_str(&slot.map_or_else(|| "?".to_owned(), |slot| slot.to_string()));
            }
            other => {
                // A description with such a name is refused.
                let _ = write!(filled, "{{{other}}}");
            }
        }
        rest = after;
    }
    filled + rest
}
