//! Orders between a coordinator and its stations: task orders, and every reply. Shapes only.
//!
//! A key is never used twice by the coordinator, and a station does no key twice: given again one that it has, it replies
//! with its state. It keeps the last [`RESULTS_MAX`] and the newest key it took on; so an older one is recognised at least
//! as had before.
//!
//! The handling of an order by a station is in `stations/logic`, that of the part in `coordinator/cell`.

mod failure;
mod refusal;

pub use failure::TaskFailure;
pub use refusal::TaskRefusal;

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};

/// A coordinator's life is numbered by the time of day at its start, in seconds, or by one more than the life before. An
/// order from further ahead of the one that was followed, 34 years, is no coordinator's.
pub const EPOCH_AHEAD_MAX: u64 = 1 << 30;

/// Number of orders that a station keeps.
pub const RESULTS_MAX: usize = 16;

/// Identity of an order. The id alone is never used twice; the epoch is the coordinator's life in which it was given, so
/// that a station can refuse new orders of an earlier life.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrderKey {
    /// The coordinator's life, from 1.
    pub epoch: u64,
    /// The order, from 1, rising over all epochs.
    pub id: u64,
}

impl fmt::Display for OrderKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "order {}.{}", self.epoch, self.id)
    }
}

/// An order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskOrder {
    /// Key of the order, unchanged each time it is sent.
    pub key: OrderKey,
    /// The memory it is meant for: a number that the station drew when its memory began. A station with another one
    /// refuses it.
    pub memory: u64,
    /// Task, by name.
    pub task: Arc<str>,
    /// Its parameters, by name: all of them.
    pub parameters: Vec<(Arc<str>, i32)>,
    /// Time left until it must have ended, from its arrival: clocks are not compared across machines. An order that
    /// arrives when this is over is not begun.
    pub limit: Duration,
}

/// Order to a station.
#[derive(Clone, Copy, Debug)]
pub enum TaskCommand<'a> {
    Run(&'a TaskOrder),
    /// To leave an order.
    Leave(OrderKey, LeaveWay),
}

/// How an order is left. One that has not begun ends without a motion, whichever it is. Each is more than the one before: after it a
/// copy of that changes nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LeaveWay {
    /// The motion under way ends, then the station stands. It may be ordered back afterwards.
    Hold,
    /// The motion under way ends, then the task is taken back to the rest where it began, as far as that goes by itself.
    Back,
    /// The station stands at once. Only a person leads on from there.
    Stop,
}

impl LeaveWay {
    /// Number in messages.
    pub const fn number(self) -> u8 {
        match self {
            LeaveWay::Hold => 0,
            LeaveWay::Back => 1,
            LeaveWay::Stop => 2,
        }
    }

    /// The way with this number. One that is not known stops: that moves nothing.
    pub const fn from_number(number: u8) -> Self {
        match number {
            0 => LeaveWay::Hold,
            1 => LeaveWay::Back,
            2..=u8::MAX => LeaveWay::Stop,
        }
    }
}

/// Reply of a station to one order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskReply {
    /// It is doing it, or on its way back from it.
    Running,
    /// It has had it.
    Ended(TaskOutcome),
    /// It does not take it on.
    Refused(TaskRefusal),
}

/// Outcome of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskOutcome {
    /// As it should: the activity-end of seed 001 (L131-185).
    Done,
    /// The task ended by a failure.
    Failed(TaskFailure),
}
