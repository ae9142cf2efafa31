//! Reasons why a station does not take an order on.

use serde::{Deserialize, Serialize};

/// Reason why a station does not take an order on. The number of each is its code in messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[repr(u16)]
pub enum TaskRefusal {
    /// It has another one.
    Busy = 1,
    /// It is not in auto, or not enabled, or master stop has been given.
    Mode = 2,
    /// Its memory is not the one the order was meant for. Its whole state has the one that counts.
    OtherMemory = 3,
    /// It has received an order of a later life of the coordinator.
    OldEpoch = 4,
    /// It has had it, or a later one, and no longer has its outcome.
    Old = 5,
    /// The time in which it was to end is over.
    Late = 6,
    /// It does not stand where the task begins.
    NotThere = 7,
    /// Its devices are not there.
    Devices = 8,
    /// It has no such task, or not these parameters.
    Unknown = 9,
    /// An operation was stopped before its end.
    Incomplete = 10,
    /// It is left out until an operator has attended to it.
    Isolated = 11,
}

impl TaskRefusal {
    /// Every refusal, in the order of their codes.
    pub const ALL: [TaskRefusal; 11] = [
        TaskRefusal::Busy,
        TaskRefusal::Mode,
        TaskRefusal::OtherMemory,
        TaskRefusal::OldEpoch,
        TaskRefusal::Old,
        TaskRefusal::Late,
        TaskRefusal::NotThere,
        TaskRefusal::Devices,
        TaskRefusal::Unknown,
        TaskRefusal::Incomplete,
        TaskRefusal::Isolated,
    ];

    /// Its code.
    pub const fn code(self) -> u16 {
        self as u16
    }

    /// The refusal with this code; none for a reason of a later version.
    pub fn from_code(code: u16) -> Option<Self> {
        Self::ALL.into_iter().find(|refusal| refusal.code() == code)
    }

    /// Whether to repeat the order: the obstacle ends by itself, or by a decision about the whole line.
    pub const fn is_passing(self) -> bool {
        match self {
            TaskRefusal::Busy | TaskRefusal::Mode | TaskRefusal::OtherMemory => true,
            TaskRefusal::OldEpoch
            | TaskRefusal::Old
            | TaskRefusal::Late
            | TaskRefusal::NotThere
            | TaskRefusal::Devices
            | TaskRefusal::Unknown
            | TaskRefusal::Incomplete
            | TaskRefusal::Isolated => false,
        }
    }

    /// Text of the refusal with the reason, for the operator; it may follow `task order`.
    pub const fn text(self) -> &'static str {
        match self {
            TaskRefusal::Busy => "rejected: another task order is in progress",
            TaskRefusal::Mode => "rejected: station not in auto, or master stop given",
            TaskRefusal::OtherMemory => "rejected: the station has lost its memory of orders since",
            TaskRefusal::OldEpoch => "rejected: a coordinator that was started later gives its orders",
            TaskRefusal::Old => "rejected: order already received",
            TaskRefusal::Late => "rejected: time limit exceeded before the start",
            TaskRefusal::NotThere => "rejected: station not at the rest where the task begins",
            TaskRefusal::Devices => "rejected: I/O devices not operational",
            TaskRefusal::Unknown => "rejected: task or parameters not in the description",
            TaskRefusal::Incomplete => "rejected: an operation is incomplete; complete or undo it in manual",
            TaskRefusal::Isolated => "rejected: station isolated; clear its fault, then return it to service",
        }
    }
}
