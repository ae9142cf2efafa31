//! What a station is told to do, what it says to that, and what it keeps of it: shapes only. What they do is in `slot.rs`.
//!
//! A key is never used again by who gives orders, and a station does no key twice: told again of one it knows, it answers
//! with what it has. It remembers the last [`RESULTS_MAX`] and the newest key it took on; so of an older one it knows at
//! least that it has had it.
//!
//! Who gives orders, and what becomes of the part, nothing here knows.

use std::time::Duration;

use linewright_line::{RestId, TaskId};

/// A coordinator's life is numbered by the time of day at its start, in seconds, or by one more than the life before. An
/// order from further ahead of the one that was followed, 34 years, is nobody's.
pub const EPOCH_AHEAD_MAX: u64 = 1 << 30;

/// A station remembers so many orders.
pub const RESULTS_MAX: usize = 16;

/// What an order is known by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct OrderKey {
    /// The coordinator's life, from 1.
    pub epoch: u64,
    /// The order, from 1, rising within an epoch at least.
    pub id: u64,
}

/// An order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskOrder {
    /// The same each time it is sent.
    pub key: OrderKey,
    /// The memory it is meant for: [`TaskOrderReport::memory`].
    pub memory: u64,
    /// Which task, by name.
    pub task: String,
    /// Its parameters, by name: all of them.
    pub parameters: Vec<(String, i32)>,
    /// How long there is left until it must have ended, from when it is heard. Heard when this is over, it is not begun.
    pub limit: Duration,
}

/// What a station is told to do.
#[derive(Clone, Copy, Debug)]
pub enum TaskCommand<'a> {
    Run(&'a TaskOrder),
    /// To leave an order be, and to go back to the rest where the task began, as far as it can by itself.
    Secure(OrderKey),
    /// To leave an order be, and to stand still at once, wherever that is.
    Stop(OrderKey),
}

/// What it says to that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reply {
    /// It is doing it, or on its way back from it.
    Running,
    /// It has had it.
    Ended(Outcome),
    /// It does not take it on.
    Refused(Refusal),
}

/// How an order has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// As it should: the activity-end of seed 001 (L131-185).
    Done,
    /// Otherwise.
    Failed(Failure),
}

/// Why an order has not ended as it should. Each has a code (seed 001, L131-185: the error code of an abnormal end).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// Its time was over while an operation waited for its inputs, and the description gives this code for that.
    Waiting(u16),
    /// Its time was over.
    TimedOut,
    /// An operation was stopped by a fault.
    Fault,
    /// The mode was changed to one in which people or nobody move the station.
    Interrupted,
    /// The station's controller was restarted.
    Restarted,
    /// It was told to leave it, and is back where the task began.
    Cancelled,
    /// It was told to leave it, and stands where it could not go on by itself.
    Held,
    /// It was told to stop, and stands where it was then.
    Stopped,
}

/// Why a station does not take an order on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// It has another one.
    Busy,
    /// It is not in auto, or master stop has been given.
    Mode,
    /// Its memory is not the one the order was meant for.
    OtherMemory,
    /// It knows a later life of the coordinator.
    OldEpoch,
    /// It has had it, or a later one, and no longer knows how it ended.
    Old,
    /// The time in which it was to end is over.
    Late,
    /// It does not stand where the task begins.
    NotThere,
    /// Its devices are not there.
    Devices,
    /// It has no such task, or not these parameters.
    Unknown,
    /// An operation was stopped before its end.
    Incomplete,
}

/// What a station says of its orders: everything, each time.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TaskOrderReport {
    /// A number it drew when its memory began: as long as it is the same, it knows every order it has had.
    pub memory: u64,
    /// The newest epoch in which it was told anything; 0 if it never was.
    pub epoch: u64,
    /// The order it is doing, or going back from.
    pub slot: Option<SlotReport>,
    /// How the orders before have ended, those it still knows, the newest last.
    pub results: Vec<(OrderKey, Outcome)>,
    /// The orders it has refused for good, those it still knows, the newest last.
    pub refused: Vec<(OrderKey, Refusal)>,
    /// The rest it stands at; none while it moves and between rests.
    pub rest: Option<RestId>,
}

/// The order a station is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlotReport {
    /// Key of the task order.
    pub key: OrderKey,
    pub task: TaskId,
    /// It is on its way back.
    pub is_securing: bool,
}

/// What a station keeps of its orders.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OrderMemory {
    /// See [`TaskOrderReport::memory`].
    pub memory: u64,
    /// The newest epoch it was told anything in.
    pub epoch: u64,
    /// The newest order of that epoch that it has taken on or refused for good; 0 for none.
    pub last: u64,
    /// The order it is doing, unless it is known how it has ended.
    pub slot: Option<OrderKey>,
    /// What it says to those before, the newest last.
    pub results: Vec<(OrderKey, Reply)>,
    /// The order that it was told to leave last, once it had ended or was given up: told again, it does not move.
    pub secured: Option<OrderKey>,
}

impl Failure {
    /// Its code: up to 999 those of the description, from 1000 these.
    pub const fn code(self) -> u16 {
        match self {
            Failure::Waiting(code) => code,
            Failure::TimedOut => 1000,
            Failure::Fault => 1001,
            Failure::Interrupted => 1002,
            Failure::Restarted => 1003,
            Failure::Cancelled => 1004,
            Failure::Held => 1005,
            Failure::Stopped => 1006,
        }
    }

    /// The failure with this code.
    pub const fn from_code(code: u16) -> Option<Self> {
        Some(match code {
            1..=linewright_line::CODE_MAX => Failure::Waiting(code),
            1000 => Failure::TimedOut,
            1001 => Failure::Fault,
            1002 => Failure::Interrupted,
            1003 => Failure::Restarted,
            1004 => Failure::Cancelled,
            1005 => Failure::Held,
            1006 => Failure::Stopped,
            _ => return None,
        })
    }
}

impl Refusal {
    /// Whether to ask again: what is in the way ends by itself, or by a decision about the whole line.
    pub const fn is_passing(self) -> bool {
        match self {
            Refusal::Busy | Refusal::Mode | Refusal::OtherMemory => true,
            Refusal::OldEpoch
            | Refusal::Old
            | Refusal::Late
            | Refusal::NotThere
            | Refusal::Devices
            | Refusal::Unknown
            | Refusal::Incomplete => false,
        }
    }
}
