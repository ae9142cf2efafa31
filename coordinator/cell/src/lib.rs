//! The coordination of a flexible cell: a coloured net whose transitions are activities, played with parts and stations.
//!
//! # Map
//! - [`CellTable`], compiled from the net's long form and a [`PlayPlan`] with the meaning of transitions and tokens.
//! - [`PlayerState`]: marking, parts, what is in progress; it changes by [`Record`]s alone, in [`PlayerState::apply`].
//! - [`CellSnapshot`]: what a state is made of, to be written down in the place of all records that led to it.
//! - [`Enabling`]: which modes have their tokens, after each firing by looking at what it touched.
//! - [`Question`], [`DispatchDecision`], [`Dispatcher`]: the question before every start; [`Fifo`] answers where there
//!   is no other dispatcher.
//! - [`dispatch`]: the dispatcher with rules, under which no part waits for ever, with its reasons.
//! - [`production`]: what is to be made, and which part counts to which order.
//! - [`ahead`]: the dispatcher that compares decisions by forward simulation.
//! - [`schedule`]: when everything is to start, followed and revised.
//! - [`tracking`]: what has happened, for reports.
//! - [`texts`]: what operators read.
//! - [`exception`]: what becomes of what has failed, and what is down; [`AnswerVerdict`]: of an answer that is not given yet.
//! - [`Coordination`]: the token player, with the argument why a crash loses nothing and repeats nothing.
//! - [`compile`]: from a cell's description to its table; the only module that reads one.
//!
//! Nothing here depends on ROS or files.

pub mod ahead;
mod apply;
pub mod compile;
mod digest;
pub mod dispatch;
mod enabling;
pub mod exception;
mod fifo;
mod firing;
mod ids;
mod marking;
mod orders;
mod plan;
mod player;
mod positions;
pub mod production;
mod protocol;
mod question;
mod reason;
mod record;
mod rehearsal;
pub mod schedule;
mod serial;
mod situation;
mod snapshot;
mod state;
mod table;
pub mod texts;
pub mod tracking;

pub use enabling::Enabling;
pub use exception::{Presence, RecoveryPolicy, StationUnavailable};
pub use fifo::Fifo;
pub use firing::{ActivityPhase, OngoingActivity, OngoingOrder, OrderProgress};
pub use ids::{AlarmId, CellId, FiringId, ModeId, OrderKey, PartId, ProductionId, ResourceId, TokenDemand};
pub use marking::CellMarking;
pub use orders::{
    CellEvent, CellMessage, OrderMessage, PlayerInput, PlayerOutbox, ProductionCommand, ProductionCommandError,
    RequestId, Sending, TaskOutcome, TaskReply, TaskReport,
};
pub use plan::{
    ActivityTiming, CellKind, PartPick, PlayPlan, PlayedActivity, PlayedOrderTemplate, Product, StorePositions,
    TaskParameterValue,
};
pub use player::{Coordination, OldEpoch};
pub use protocol::ProtocolRules;
pub use question::{
    BadAnswer, Candidate, ConflictGroup, DispatchDecision, Dispatcher, HeldCandidate, Question, Start, check,
};
pub use reason::{DecidingRule, Gain, HoldReason, LostDecision, ProgressComparison};
pub use record::{ActivityFailure, ActivityStep, OrderFailure, Record, RecordKind, TaskRefusal};
pub use rehearsal::AnswerVerdict;
pub use snapshot::CellSnapshot;
pub use state::{Part, PartPlace, PlayerState, ReplayError};
pub use table::{CellTable, PlanError};
