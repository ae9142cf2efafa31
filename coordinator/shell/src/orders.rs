//! Orders between the token player and stations: the types of the one as those of the other.
//!
//! Neither crate knows the other. In a plant messages stand between the two; where both are in one process, as in a simulation
//! and under a checker, these functions do.

use linewright_coordinator_cell::{Heard, OrderKey, OrderMessage, Outcome, Refusal, Reply};
use linewright_station_logic::{self as station, OrderReport, TaskCommand, TaskOrder};

/// A station's report of its orders, as the token player reads it.
pub fn heard(report: &OrderReport) -> Heard {
    Heard {
        memory: report.memory,
        epoch: report.epoch,
        slot: report.slot.map(|slot| known(slot.key)),
        results: report.results.iter().map(|&(of, outcome)| (known(of), ended(outcome))).collect(),
        is_held: report.slot.is_none() && report.rest.is_none(),
        ..Heard::default()
    }
}

/// A station's answer to an order, as the token player reads it.
pub fn reply(reply: station::Reply) -> Reply {
    match reply {
        station::Reply::Running => Reply::Running,
        station::Reply::Ended(outcome) => Reply::Ended(ended(outcome)),
        station::Reply::Refused(reason) => Reply::Refused(refusal(reason)),
    }
}

/// Why a station refuses an order, as the token player reads it.
pub fn refusal(refusal: station::Refusal) -> Refusal {
    match refusal {
        station::Refusal::Busy => Refusal::Busy,
        station::Refusal::Mode => Refusal::Mode,
        station::Refusal::OtherMemory => Refusal::OtherMemory,
        station::Refusal::OldEpoch => Refusal::OldEpoch,
        station::Refusal::Old => Refusal::Old,
        station::Refusal::Late => Refusal::Late,
        station::Refusal::NotThere => Refusal::NotThere,
        station::Refusal::Devices => Refusal::Devices,
        station::Refusal::Unknown => Refusal::Unknown,
        station::Refusal::Incomplete => Refusal::Incomplete,
    }
}

/// The token player's order, as the station reads it.
pub fn order(message: &OrderMessage) -> TaskOrder {
    TaskOrder {
        key: key(message.key),
        memory: message.memory,
        task: message.task.to_string(),
        parameters: message.parameters.iter().map(|(name, value)| (name.to_string(), *value)).collect(),
        limit: message.limit,
    }
}

/// To leave an order, or to stop at once, as the station reads it.
pub fn leave(of: OrderKey, stop: bool) -> TaskCommand<'static> {
    if stop { TaskCommand::Stop(key(of)) } else { TaskCommand::Secure(key(of)) }
}

/// The key of an order, as the station knows it.
pub fn key(key: OrderKey) -> station::OrderKey {
    station::OrderKey { epoch: key.epoch, id: key.id }
}

/// The key of an order, as the token player knows it.
pub fn known(key: station::OrderKey) -> OrderKey {
    OrderKey { epoch: key.epoch, id: key.id }
}

/// The outcome of an order, as the token player reads it.
pub fn ended(outcome: station::Outcome) -> Outcome {
    match outcome {
        station::Outcome::Done => Outcome::Done,
        station::Outcome::Failed(failure) => Outcome::Failed(failure.code()),
    }
}
