//! What is written down of a cell: one record for each step of it.
//!
//! Records are the truth: a state is what [`super::State::apply`] makes of them, in life and after a restart alike. The
//! caller has to have them on disk, in order, before it tells anybody anything that follows from them (see
//! [`super::player`]). A record says what has happened, never what was tried: that an order was *sent* is none, since
//! written before it might be untrue, and written after it might be missing.

use linewright_line::{StationId, Tick};
use serde::{Deserialize, Serialize};

use super::exception::ExceptionStep;
use super::ids::{FiringId, ModeId, OrderKey, PartId, ResourceId};
use super::production::ProductionChange;
use super::question::HoldReason;
use super::serial;

/// What has happened, and when.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// When; never earlier than the record before.
    #[serde(with = "serial::micros")]
    pub at: Tick,
    /// What changed.
    pub fact: RecordKind,
}

/// What has happened.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum RecordKind {
    /// A life of the coordinator begins.
    Epoch {
        /// Greater than any before.
        epoch: u64,
    },
    /// A station is heard that remembers what it was told since a certain beginning, or another beginning than before.
    Memory {
        /// Station whose order store was reset.
        #[serde(with = "serial::station")]
        station: StationId,
        /// A number that it drew when its memory began.
        memory: u64,
    },
    /// A question was answered. What was decided to start follows as [`RecordKind::Started`].
    Decided {
        /// The number of the question, from 1.
        question: u64,
        started: Vec<(ModeId, Option<PartId>)>,
        /// What is not, and why.
        held: Vec<(ModeId, HoldReason)>,
    },
    /// An activity has started: its tokens are taken, its orders exist.
    Started {
        /// The next number.
        firing: FiringId,
        /// Net mode that started.
        mode: ModeId,
        /// With which part; a new one if the mode lets parts enter.
        part: Option<PartId>,
        /// The keys of its orders, as its activity lists them.
        orders: Vec<OrderKey>,
    },
    /// A station has taken an order on.
    Acknowledged {
        /// Task order.
        key: OrderKey,
    },
    /// A station has done what it was told.
    OrderEnded {
        /// Task order.
        key: OrderKey,
    },
    /// An order will not be done, as far as is known.
    OrderFailed {
        /// Task order.
        key: OrderKey,
        /// Failure of the task order.
        failure: Failure,
    },
    /// An activity will not end by itself. It keeps its tokens and its part until somebody says what is true.
    Raised {
        /// Activity in progress.
        firing: FiringId,
        cause: ActivityFailure,
    },
    /// An activity has ended: its tokens are given.
    Ended {
        /// Activity in progress.
        firing: FiringId,
    },
    /// What takes no time has happened: tokens are taken and given.
    Fired {
        /// Net mode that fired.
        mode: ModeId,
        /// With which part; a new one if the mode lets parts enter.
        part: Option<PartId>,
    },
    /// Somebody has changed what is on order.
    Production {
        /// Change of the production orders.
        change: ProductionChange,
    },
    /// A step on the way from a failure to where it goes on from.
    Exception(ExceptionStep),
}

/// Why an order was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Failure {
    /// The station has ended it with this code (seed 001, L131-185: an activity that ends abnormally has an error code).
    Code(u16),
    /// The station does not take it on, and will not later.
    Refused(Refusal),
    /// No end was heard within its limit.
    TimedOut,
    /// The station has lost its memory. Whether it was done, nobody knows but who looks.
    Forgotten,
    /// The station was not heard for too long.
    Lost,
    /// The station says that its devices are not there.
    DevicesLost,
}

/// Why a station does not take an order on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Refusal {
    /// It has another one.
    Busy,
    /// It is not in auto, or not enabled.
    Mode,
    /// Its memory is not the one the order was meant for. Its whole state will say so, and be believed.
    OtherMemory,
    /// It knows a later life of the coordinator.
    OldEpoch,
    /// It has had it, and no longer knows how it ended.
    Old,
    /// The time in which it was to start is over.
    Late,
    /// It does not stand where the task begins.
    NotThere,
    /// Its devices are not there.
    Devices,
    /// It has no such task, or not such a parameter.
    Unknown,
    /// An operation was stopped before its end.
    Incomplete,
    /// It is left out until somebody has looked after it.
    Isolated,
}

impl Refusal {
    /// Whether to ask again: what is in the way ends by itself, or by a decision about the whole line.
    pub fn is_passing(self) -> bool {
        match self {
            Refusal::Busy | Refusal::Mode | Refusal::OtherMemory => true,
            Refusal::OldEpoch
            | Refusal::Old
            | Refusal::Late
            | Refusal::NotThere
            | Refusal::Devices
            | Refusal::Unknown
            | Refusal::Incomplete
            | Refusal::Isolated => false,
        }
    }
}

/// Why an activity does not end by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum ActivityFailure {
    /// One of its orders has failed.
    Order {
        /// The first of them.
        key: OrderKey,
        /// Failure of the task order.
        failure: Failure,
    },
    /// It takes longer than it may altogether.
    TimedOut,
    /// Somebody has given alarm of one of its resources.
    ByHand { resource: ResourceId },
}

/// Up to here codes say what a station waited for until its time was over; above, they are the station's own.
const WAITED_MAX: u16 = 999;
/// The station's own for an order whose time was over while it waited for nothing.
const OUT_OF_TIME: u16 = 1000;

impl Failure {
    /// What a code of a station says. Its clock means the same as the coordinator's.
    pub fn of_code(code: u16) -> Self {
        if code == OUT_OF_TIME { Failure::TimedOut } else { Failure::Code(code) }
    }

    /// Its time was over, whether the station's clock or the coordinator's was first.
    pub fn is_expiry(self) -> bool {
        match self {
            Failure::TimedOut => true,
            Failure::Code(code) => (1..=WAITED_MAX).contains(&code),
            Failure::Refused(_) | Failure::Forgotten | Failure::Lost | Failure::DevicesLost => false,
        }
    }
}

impl ActivityFailure {
    /// Some time was over.
    pub fn is_expiry(self) -> bool {
        match self {
            ActivityFailure::TimedOut => true,
            ActivityFailure::Order { key: _, failure } => failure.is_expiry(),
            ActivityFailure::ByHand { .. } => false,
        }
    }
}
