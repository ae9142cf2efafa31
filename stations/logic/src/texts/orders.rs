//! Task orders: why one was rejected, and why one was not done.

use crate::order::{Failure, Refusal};

impl Failure {
    /// The reason; it follows `task … failed:`.
    pub fn text(self) -> String {
        match self {
            Failure::Waiting(code) => format!("awaited input not on in time (code {code})"),
            Failure::TimedOut => "time limit exceeded".to_owned(),
            Failure::Fault => "station fault".to_owned(),
            Failure::Interrupted => "mode changed during the task".to_owned(),
            Failure::Restarted => "station controller restarted during the task".to_owned(),
            Failure::Cancelled => "undone on request".to_owned(),
            Failure::Held => "undone on request as far as possible; lead it to a rest in manual".to_owned(),
            Failure::Stopped => "stopped on request between two rests; lead it to a rest in manual".to_owned(),
        }
    }
}

impl Refusal {
    /// That the order was rejected, and the reason; it may follow `task order`.
    pub const fn text(self) -> &'static str {
        match self {
            Refusal::Busy => "rejected: another task order is in progress",
            Refusal::Mode => "rejected: station not in auto, or master stop given",
            Refusal::OtherMemory => "rejected: addressed to an order store that was reset",
            Refusal::OldEpoch => "rejected: a newer coordinator epoch is active",
            Refusal::Old => "rejected: order already received",
            Refusal::Late => "rejected: time limit exceeded before the start",
            Refusal::NotThere => "rejected: station not at the rest where the task begins",
            Refusal::Devices => "rejected: I/O devices not operational",
            Refusal::Unknown => "rejected: task or parameters not in the description",
            Refusal::Incomplete => "rejected: an operation is incomplete; complete or undo it in manual",
        }
    }
}
