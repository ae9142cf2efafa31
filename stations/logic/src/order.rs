//! Report of a station on its orders, and its record of them: shapes only. Their handling is in `slot.rs`.
//!
//! Orders themselves, and replies to them, are those of `linewright-orders`.

use linewright_line::{RestId, TaskId};

pub use linewright_orders::{
    EPOCH_AHEAD_MAX, LeaveWay, OrderKey, RESULTS_MAX, TaskCommand, TaskFailure, TaskOrder, TaskOutcome, TaskRefusal,
    TaskReply,
};

/// Report of a station on its orders: everything, each time.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TaskOrderReport {
    /// A number it drew when its memory began: as long as it is the same, it has every order it was sent.
    pub memory: u64,
    /// The newest epoch of an order it received; 0 if there was none.
    pub epoch: u64,
    /// The order it is doing, or going back from.
    pub slot: Option<SlotReport>,
    /// Outcomes of the orders before, as far as it keeps them, the newest last.
    pub results: Vec<(OrderKey, TaskOutcome)>,
    /// The orders it has refused for good, as far as it keeps them, the newest last.
    pub refused: Vec<(OrderKey, TaskRefusal)>,
    /// The rest it stands at; none while it moves and between rests.
    pub rest: Option<RestId>,
    /// An operation of the task that waits for inputs or other stations has started, and is not taken back; or it is not known where
    /// the station stands.
    pub is_in_handshake: bool,
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

/// Record of a station of its orders.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OrderMemory {
    /// See [`TaskOrderReport::memory`].
    pub memory: u64,
    /// The newest epoch of an order it received.
    pub epoch: u64,
    /// The newest order of that epoch that it has taken on or refused for good; 0 for none.
    pub last: u64,
    /// The order it is doing, unless it is known how it has ended.
    pub slot: Option<OrderKey>,
    /// Its replies to those before, the newest last.
    pub results: Vec<(OrderKey, TaskReply)>,
    /// The last order that it was ordered to leave, once it had ended or was given up: a repetition does not move it.
    pub secured: Option<OrderKey>,
    /// Parameters of the last order, as outputs of this task, until the station is at a rest.
    pub parameters: Option<(TaskId, u128)>,
}
