//! Input and output of the player: whole states of stations, replies to single orders, and orders.
//!
//! Shapes only. A station keeps one order at a time in a slot and the results of some it has had, keeps them over its own
//! restarts, and answers an order it already has with its state instead of doing it again; [`super::player`] builds on
//! that. Nothing here has to arrive: a lost message costs one period.

use std::collections::BTreeMap;

use linewright_line::{RestId, StationId, Tick};
use linewright_orders::{LeaveWay, TaskOrder};
pub use linewright_orders::{TaskOutcome, TaskReply};

use super::exception::{AlarmAnswerRefusal, Presence, ResourceRequest, StationUnavailable};
use super::ids::{AlarmId, ModeId, OrderKey, PartId, ProductionId, ResourceId};
use super::production::{ProductionOrderRequest, ProductionRefusal, RequestProblem};
use super::question::BadAnswer;
use super::record::{Record, TaskRefusal};

/// Input of the player.
#[derive(Clone, Copy, Debug)]
pub enum PlayerInput<'a> {
    /// A station's newest whole state.
    Station(StationId, &'a TaskReport),
    /// A station's answer to one order.
    Reply(StationId, OrderKey, TaskReply),
    /// A station's answer to the order to leave an order.
    Secured(StationId, OrderKey, LeaveWay, TaskReply),
    /// Whether activities may start: the line is in auto, and enabled. They may not until this is received.
    Starts(bool),
    /// The stations that are in manual by themselves, and no others, each with the epoch since which it is: none gets an order.
    InManual(&'a BTreeMap<StationId, u64>),
    /// A command about production orders, whose requester waits for a reply.
    Production(RequestId, ProductionCommand<'a>),
    /// A person's answer to an alarm.
    Answer { alarm: AlarmId, word: &'a str },
    /// An alarm given by hand of a resource: its activities are stopped.
    Alarm {
        resource: ResourceId,
        /// Text of the operator; may be empty.
        text: &'a str,
    },
    /// An operator's request that a resource is not to be counted on, or is again. It finishes its activities.
    Resource {
        resource: ResourceId,
        /// Again.
        up: bool,
    },
    /// A person resets a station that is in emergency stop by itself.
    Reset(StationId),
}

impl PlayerInput<'_> {
    /// Whether a person waits for its reply. What it has changed is on disk before that.
    pub fn is_request(&self) -> bool {
        match self {
            PlayerInput::Production(..)
            | PlayerInput::Answer { .. }
            | PlayerInput::Alarm { .. }
            | PlayerInput::Resource { .. }
            | PlayerInput::Reset(_) => true,
            PlayerInput::Station(..)
            | PlayerInput::Reply(..)
            | PlayerInput::Secured(..)
            | PlayerInput::Starts(_)
            | PlayerInput::InManual(_) => false,
        }
    }
}

/// Identifies the requester of a reply; chosen by the caller.
pub type RequestId = u64;

/// Operators' commands about production orders.
#[derive(Clone, Copy, Debug)]
pub enum ProductionCommand<'a> {
    /// Make orders of these requests, all of them or none. A repeated request changes nothing.
    Submit(&'a [ProductionOrderRequest]),
    /// Nothing more of the order of that name is to enter.
    Cancel(&'a str),
    /// The order of that name, of which nothing has entered, is to be as if it had never been.
    Withdraw(&'a str),
}

/// Reason why something was not changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ProductionCommandError {
    /// All errors of the requests.
    Request(Vec<RequestProblem>),
    /// The order cannot be changed so.
    Order(ProductionRefusal),
    /// Another life of the coordinator has begun.
    Superseded,
}

/// Report of a station, sent again and again.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TaskReport {
    /// A number that it drew when its memory began. As long as it is the same, the station has every order it was sent.
    pub memory: u64,
    /// The newest epoch of an order it received; 0 if there was none.
    pub epoch: u64,
    /// The order it is doing, or going back from.
    pub slot: Option<OrderKey>,
    /// Outcomes of the orders it had before, as far as it keeps them.
    pub results: Vec<(OrderKey, TaskOutcome)>,
    /// It stands between two rests, and does not go on from there by itself.
    pub is_held: bool,
    /// The rest at which it stands; none while it moves, between rests, or where it is not known.
    pub rest: Option<RestId>,
    /// An operation of its task that waits for inputs or other stations has started, and is not taken back; or it is not known where
    /// it stands, also if it reports a rest. Another station may rely on where this one stands.
    pub is_in_handshake: bool,
    /// Why it could not do anything now; none if it could.
    pub unable: Option<StationUnavailable>,
    /// Whether there is a part where its sensor looks.
    pub presence: Presence,
    /// Of the inputs that its operations wait for, those that are known to be off, by their bits.
    pub off: u128,
    /// Fault text of the station, with operation and input; empty if it has no fault.
    pub fault: String,
}

impl TaskReport {
    /// The station's answer to the order to leave an order: whether it is still at it.
    pub fn secured(&self, key: OrderKey) -> TaskReply {
        match self.results.iter().find(|(of, _)| *of == key) {
            // An order that had ended before may be gone back from.
            _ if self.slot == Some(key) => TaskReply::Running,
            Some(&(_, outcome)) => TaskReply::Ended(outcome),
            // It was too old for it, and is left all the same.
            None => TaskReply::Refused(TaskRefusal::Old),
        }
    }
}

/// Output of a step: first write the records down, then send, then reply.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PlayerOutbox {
    /// To be on disk, in this order, before anything is sent.
    pub records: Vec<Record>,
    /// To be sent. Each may be lost or doubled.
    pub sends: Vec<CellMessage>,
    /// Replies to requesters, when the records are on disk: the orders that were made or changed.
    pub replies: Vec<(RequestId, Result<Vec<ProductionId>, ProductionCommandError>)>,
    /// Events for operators.
    pub events: Vec<CellEvent>,
    /// People wait for a reply to requests of the step, also where it is not in `replies`.
    pub is_requested: bool,
}

impl PlayerOutbox {
    /// Whether something follows from the records at once: they are to be on disk before it.
    pub fn needs_disk(&self) -> bool {
        !self.sends.is_empty() || !self.replies.is_empty() || self.is_requested
    }
}

/// Message to a station.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CellMessage {
    /// Do this.
    Order(OrderMessage),
    /// Leave an order. A station that has done it already has; one that has not received it is not to do it.
    Secure {
        /// Station to be secured.
        station: StationId,
        key: OrderKey,
        way: LeaveWay,
    },
}

/// An order as its station gets it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OrderMessage {
    pub station: StationId,
    /// The part it is about.
    pub part: Option<PartId>,
    /// Its limit is counted from now.
    pub order: TaskOrder,
}

/// Progress of an order towards its station in this life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sending {
    /// Not sent yet.
    Unsent,
    Sent {
        /// Transmissions so far.
        tries: u32,
        at: Tick,
    },
}

/// Event for operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellEvent {
    /// A dispatcher's answer could not be followed, and first come, first served has answered instead.
    BadAnswer {
        /// The number of the question.
        question: u64,
        /// Reason why the dispatch decision is not valid.
        why: BadAnswer,
    },
    /// A station has received orders of a later life of the coordinator. This one starts and sends nothing more.
    Superseded {
        /// Station that reports the newer epoch.
        by: StationId,
        /// Epoch of that life.
        epoch: u64,
    },
    /// An operator's request is refused.
    Objected {
        /// The request.
        to: ResourceRequest,
        /// Reason why the request was not applied.
        why: AlarmAnswerRefusal,
    },
    /// So much has happened by itself or was started at one moment that it goes on in the next step. If this comes again
    /// and again, the net has a circle that takes no time.
    Busy {
        /// Mode that happened last.
        mode: ModeId,
    },
}
