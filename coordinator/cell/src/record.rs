//! Records of a cell: one for each step of it.
//!
//! Records are the truth: a state is what [`super::PlayerState::apply`] makes of them, in life and after a restart alike. The
//! caller has to have them on disk, in order, before it sends anything that follows from them (see [`super::player`]). A
//! record is about what has happened, never about attempts: that an order was *sent* is none, since written before it might
//! be untrue, and written after it might be missing.

use linewright_line::{StationId, Tick};
use linewright_orders::TaskFailure;
pub use linewright_orders::TaskRefusal;
use serde::{Deserialize, Serialize};

use super::exception::{ExceptionStep, RecoveryDecision};
use super::ids::{FiringId, ModeId, OrderKey, PartId, ResourceId};
use super::production::ProductionChange;
use super::reason::HoldReason;
use super::serial;

/// Event, and its time.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// When; never earlier than the record before.
    #[serde(with = "serial::micros")]
    pub at: Tick,
    /// The event.
    pub fact: RecordKind,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum RecordKind {
    /// A life of the coordinator begins.
    Epoch {
        /// Greater than any before.
        epoch: u64,
    },
    /// A station is received with a memory that began at another time than before, or for the first time.
    Memory {
        /// Station with that memory.
        #[serde(with = "serial::station")]
        station: StationId,
        /// A number that it drew when its memory began.
        memory: u64,
    },
    /// A question was answered. The starts decided follow as [`RecordKind::Started`].
    Decided {
        /// The number of the question, from 1.
        question: u64,
        started: Vec<(ModeId, Option<PartId>)>,
        /// Modes held, and reasons.
        held: Vec<(ModeId, HoldReason)>,
    },
    /// An activity has started: its tokens are taken, its orders exist.
    Started {
        firing: FiringId,
        mode: ModeId,
        /// Its part; a new one if the mode lets parts enter.
        part: Option<PartId>,
        /// The keys of its orders, as its activity lists them.
        orders: Vec<OrderKey>,
    },
    /// A station has taken an order on.
    Acknowledged { key: OrderKey },
    /// A station has done its order.
    OrderEnded { key: OrderKey },
    /// An order will not be done, as far as is known.
    OrderFailed { key: OrderKey, failure: OrderFailure },
    /// An activity will not end by itself. It keeps its tokens and its part until there is an answer.
    Raised { firing: FiringId, cause: ActivityFailure },
    /// An activity has ended: its tokens are given.
    Ended { firing: FiringId },
    /// An instantaneous mode has happened: tokens are taken and given.
    Fired {
        mode: ModeId,
        /// Its part; a new one if the mode lets parts enter.
        part: Option<PartId>,
    },
    /// The production orders have changed.
    Production {
        /// Change of the production orders.
        change: ProductionChange,
    },
    /// A step on the way from a failure to where it goes on from.
    Exception(ExceptionStep),
}

/// Step of an activity, or of an instantaneous mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActivityStep<'a> {
    Started {
        firing: FiringId,
        mode: ModeId,
        part: Option<PartId>,
        orders: &'a [OrderKey],
    },
    /// It will not end by itself.
    Raised {
        firing: FiringId,
        cause: &'a ActivityFailure,
    },
    Ended {
        firing: FiringId,
    },
    /// It had failed, and is put right.
    Closed {
        firing: FiringId,
        ruling: &'a RecoveryDecision,
    },
    /// An instantaneous mode has happened.
    Fired {
        mode: ModeId,
        part: Option<PartId>,
    },
}

impl RecordKind {
    /// The step of an activity in it; none if it is about something else.
    pub fn activity_step(&self) -> Option<ActivityStep<'_>> {
        match self {
            &RecordKind::Started { firing, mode, part, ref orders } => {
                Some(ActivityStep::Started { firing, mode, part, orders })
            }
            RecordKind::Raised { firing, cause } => Some(ActivityStep::Raised { firing: *firing, cause }),
            &RecordKind::Ended { firing } => Some(ActivityStep::Ended { firing }),
            &RecordKind::Fired { mode, part } => Some(ActivityStep::Fired { mode, part }),
            RecordKind::Exception(ExceptionStep::Closed { firing, ruling, .. }) => {
                Some(ActivityStep::Closed { firing: *firing, ruling })
            }
            RecordKind::Exception(_)
            | RecordKind::Epoch { .. }
            | RecordKind::Memory { .. }
            | RecordKind::Decided { .. }
            | RecordKind::Acknowledged { .. }
            | RecordKind::OrderEnded { .. }
            | RecordKind::OrderFailed { .. }
            | RecordKind::Production { .. } => None,
        }
    }
}

/// Reason why an order was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum OrderFailure {
    /// The station has ended it with this code (seed 001, L131-185: an activity that ends abnormally has an error code).
    Code(u16),
    /// The station does not take it on, and will not later.
    Refused(TaskRefusal),
    /// No end was received within its limit.
    TimedOut,
    /// The station has lost its memory; whether the order was done can only be seen at the station.
    Forgotten,
    /// The station was not received for too long.
    Lost,
    /// The station reports that its devices are not there.
    DevicesLost,
}

/// Reason why an activity does not end by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum ActivityFailure {
    /// One of its orders has failed.
    Order {
        /// The first of them.
        key: OrderKey,
        failure: OrderFailure,
    },
    /// It takes longer than it may altogether.
    TimedOut,
    /// An operator has given alarm of one of its resources.
    ByHand { resource: ResourceId },
}

impl OrderFailure {
    /// From the outcome by the station. A time-out by the station's clock equals one by the coordinator's.
    pub fn of(ended: TaskFailure) -> Self {
        match ended {
            TaskFailure::TimedOut => OrderFailure::TimedOut,
            TaskFailure::Waiting(_)
            | TaskFailure::Fault
            | TaskFailure::Interrupted
            | TaskFailure::Restarted
            | TaskFailure::Cancelled
            | TaskFailure::Held
            | TaskFailure::Stopped
            | TaskFailure::Other(_) => OrderFailure::Code(ended.code()),
        }
    }

    /// Its time was over, whether the station's clock or the coordinator's was first.
    pub fn is_expiry(self) -> bool {
        match self {
            OrderFailure::TimedOut => true,
            OrderFailure::Code(code) => matches!(TaskFailure::from_code(code), TaskFailure::Waiting(_)),
            OrderFailure::Refused(_) | OrderFailure::Forgotten | OrderFailure::Lost | OrderFailure::DevicesLost => {
                false
            }
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
