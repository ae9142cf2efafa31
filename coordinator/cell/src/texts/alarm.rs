//! Alarms of a cell: what failed, how the stations stand, and what to answer.

use std::fmt::Write;

use linewright_line::{StationId, Tick};

use crate::exception::{RecoveryDecision, RecoveryPolicy, SecuredState, SensorMismatch};
use crate::firing::{OngoingActivity, OrderProgress};
use crate::ids::{ModeId, PartId, ResourceId};
use crate::record::{ActivityFailure, Failure};
use crate::state::PlayerState;

/// The answer that a resource is as the model has it.
pub(crate) const UP: &str = "up";
/// The answer that the part which a resource should have was removed.
pub(crate) const GONE: &str = "gone";

/// An alarm of an activity that failed: the text of its rule, and the facts.
pub(crate) fn alarm(state: &PlayerState, firing: &OngoingActivity, cause: ActivityFailure, now: Tick) -> String {
    let handling = state.table().handling();
    let tell = handling.rule(firing.mode, cause).map(|rule| filled(&rule.tell, state, firing.mode, firing.part));
    let tell = tell.unwrap_or_else(|| {
        let of = part(firing.part).map(|part| format!(" with {part}")).unwrap_or_default();
        format!("{}{of} failed. Answer where the part is.", state.table().called(firing.mode))
    });
    format!("{tell} ({})", facts(state, firing, cause, now))
}

/// What is known: `load M1: m1: time limit exceeded, after 26 s; robot: at rest, m1: at rest`.
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
        let standing = match (state.exceptions().stands(firing.id, order.key), order.state) {
            _ if is_stopped => StationStanding::EmergencyStop,
            (_, OrderProgress::Ended) => StationStanding::Done,
            (Some(SecuredState::AtRest), _) => StationStanding::AtRest,
            (Some(SecuredState::Held), _) => StationStanding::Held,
            (Some(SecuredState::Unknown), _) => StationStanding::Unknown,
            (None, OrderProgress::Failed(Failure::Forgotten)) => StationStanding::StoreReset,
            (None, OrderProgress::Failed(_) | OrderProgress::Written | OrderProgress::Running) => {
                StationStanding::NotBegun
            }
        };
        // Writing to a string does not fail.
        let _ = write!(text, "{joint} {}: {}", handling.station_name(order.station), standing.text());
        joint = ",";
    }
    let others = state.exceptions().stopped().filter(|id| firing.orders.iter().all(|order| order.station != *id));
    for station in others {
        let standing = StationStanding::EmergencyStop.text();
        let _ = write!(text, "{joint} {}: {standing}", handling.station_name(station));
        joint = ",";
    }
    text
}

/// How a station of a failed activity stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StationStanding {
    /// In an emergency stop of its own.
    EmergencyStop,
    /// Its order is done.
    Done,
    /// At a rest.
    AtRest,
    /// Between two rests.
    Held,
    /// Not reported at rest in time.
    Unknown,
    /// Its order store was reset.
    StoreReset,
    /// Its order was not begun.
    NotBegun,
}

impl StationStanding {
    /// The text, behind the station's name.
    pub const fn text(self) -> &'static str {
        match self {
            StationStanding::EmergencyStop => "in emergency stop",
            StationStanding::Done => "order done",
            StationStanding::AtRest => "at rest",
            StationStanding::Held => "stopped between two rests",
            StationStanding::Unknown => "rest not confirmed",
            StationStanding::StoreReset => "restarted with an empty order store",
            StationStanding::NotBegun => "order not begun",
        }
    }
}

/// Why an activity failed, with the names of the description.
fn cause_of(state: &PlayerState, firing: &OngoingActivity, cause: ActivityFailure) -> String {
    let handling = state.table().handling();
    let (station, resource) = match cause {
        ActivityFailure::TimedOut => (None, "?"),
        ActivityFailure::ByHand { resource } => (None, handling.resource_name(resource)),
        ActivityFailure::Order { key, .. } => {
            (firing.orders.iter().find(|order| order.key == key).map(|order| order.station), "?")
        }
    };
    let station = station.map_or_else(|| "a station".to_owned(), |station| handling.station_name(station));
    cause.text_of(&station, resource)
}

/// An answer that sensors contradict.
pub(crate) fn differs(
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
    format!("Answer \"{}\" contradicts the sensors: {}. {again}", ruling.word, found.join("; "))
}

/// A station that moved after the answer.
pub(crate) fn moved(
    state: &PlayerState,
    firing: &OngoingActivity,
    cause: ActivityFailure,
    ruling: &RecoveryDecision,
    station: StationId,
    now: Tick,
) -> String {
    let name = state.table().handling().station_name(station);
    format!("{name} moved after the answer \"{}\". {}", ruling.word, alarm(state, firing, cause, now))
}

/// The carrier holds the part.
pub(crate) fn carried(state: &PlayerState, mode: ModeId, of: Option<PartId>) -> String {
    let text = "{carrier} holds part {part}. Move it to {to} or back to {from}, then answer which.";
    filled(text, state, mode, of)
}

/// A sensor that contradicts the model.
pub(crate) fn mismatch(handling: &RecoveryPolicy, found: &SensorMismatch, missing: Option<PartId>) -> String {
    let or = missing.map(|part| format!("; if {part} was removed, answer \"{GONE}\"")).unwrap_or_default();
    format!("{}. Correct it, then answer \"{UP}\"{or}.", difference(handling, found))
}

fn difference(handling: &RecoveryPolicy, found: &SensorMismatch) -> String {
    let name = handling.resource_name(found.resource);
    match (found.model, found.plant) {
        (true, _) => format!("{name}: part expected, sensor off"),
        (false, _) => format!("{name}: no part expected, sensor on"),
    }
}

fn part(of: Option<PartId>) -> Option<String> {
    of.map(|part| part.to_string())
}

/// A text with the names in braces replaced.
fn filled(text: &str, state: &PlayerState, mode: ModeId, of: Option<PartId>) -> String {
    let handling = state.table().handling();
    let handled = handling.mode(mode);
    let name =
        |id: Option<ResourceId>| id.map_or_else(|| "outside".to_owned(), |id| handling.resource_name(id).to_owned());
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
