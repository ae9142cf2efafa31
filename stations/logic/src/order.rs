//! What a station says of its orders, and what it keeps of them: shapes only. What they do is in `slot.rs`.
//!
//! Orders themselves, and replies to them, are those of `linewright-orders`.

use linewright_line::{RestId, TaskId};

pub use linewright_orders::{
    EPOCH_AHEAD_MAX, OrderKey, RESULTS_MAX, TaskCommand, TaskFailure, TaskOrder, TaskOutcome, TaskRefusal, TaskReply,
};

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
    pub results: Vec<(OrderKey, TaskOutcome)>,
    /// The orders it has refused for good, those it still knows, the newest last.
    pub refused: Vec<(OrderKey, TaskRefusal)>,
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
    pub results: Vec<(OrderKey, TaskReply)>,
    /// The order that it was told to leave last, once it had ended or was given up: told again, it does not move.
    pub secured: Option<OrderKey>,
}
