//! The ROS 2 part common to the station's and the coordinator's node.
//!
//! The client library covers DDS; the rest of what a ROS 2 user expects is here: command line and environment
//! ([`RosArgs`]), names and remaps ([`names`]), a participant that stays on this machine by default ([`Participant`]),
//! one named quality of service per kind of topic ([`qos`]), publishers that never wait ([`Publisher`]) and
//! subscriptions that survive anything sent to them ([`Subscription`]).
//!
//! Lines and modes do not occur in this crate. Nothing that concerns a controller is decided here: a message arrives
//! with its source, or it does not arrive.

mod action;
mod args;
mod bytes;
mod caller;
mod claim;
mod confine;
mod environment;
mod identity;
mod journal;
mod lifecycle;
pub mod log;
mod logging;
mod lossy;
pub mod names;
mod pace;
mod parameters;
mod participant;
mod publisher;
pub mod qos;
mod recorder;
mod relay;
mod rosout;
mod service;
mod subscription;
mod threads;
mod watchdog;

pub use action::{
    ActionCaller, ActionOffer, ActionOwner, GoalAsked, GoalEnd, GoalError, GoalHandle, GoalOutcome, GoalRequest,
    serve_action,
};
pub use args::{ArgsError, LogLevel, RosArgs};
pub use caller::{CallError, Caller, Mapping};
pub use claim::{Claim, ClaimError, RunName, bus_managed_by, clock, lines_managing};
pub use environment::{EnvironmentError, Range};
pub use identity::{boot_id, fresh_boot_id, fresh_key, stamp};
pub use journal::{Journal, JournalError};
pub use lifecycle::{ChangeRequest, Lifecycle};
pub use logging::{LoggingError, flush_stderr, init as init_logging, level_at_start, set_log_level, stderr_line};
pub use pace::{ClientDelays, MessagePace, forward_present, forward_timely};
pub use parameters::{LOG_LEVEL_NAME, Parameters};
pub use participant::{OpenError, Participant, RosNode, TopicError};
pub use publisher::{Publisher, SendError, unsent_messages};
pub use recorder::{JournalWriter, RecordTimes};
pub use rosout::Rosout;
pub use service::{Service, ServiceReply, serve};
pub use subscription::{Forward, MessageSource, RecvError, Subscription, forward};
pub use threads::watch_middleware;
pub use watchdog::Watchdog;
