//! Behaviour of a station's node between messages, as pure code.
//!
//! The controller decides what the station does; the rest of a node's decisions (the newest message, the age of an image
//! and the outputs it was taken under, what is written before what is sent, and what follows after a standstill of the
//! node) is [`StationShell`]: it takes arrivals and gives effects, in the order in which they must become true. The node
//! of ROS 2 performs them with sockets and files, a simulation in memory; neither has rules of its own.
//!
//! [`NewestBySequence`] is here for every reader of whole-state messages, [`Rivals`] for those of the coordinator's order,
//! [`HeldByOne`] for those of held buttons. [`parameters`] declares those of every node; [`HealthCheck`] is what a node reports about
//! itself for diagnostics.

mod effect;
mod health;
mod held;
mod newest;
pub mod parameters;
mod rivals;
mod rules;
mod shell;

pub use effect::{Driven, InputsMessage, ParticipantId, StationArrival, StationEffect};
pub use health::{HealthCheck, HealthLevel, JournalFacts, RecentGrowth, STATION_CHECKS, journal_check, messages_check};
pub use held::{HeldByOne, HeldPass};
pub use newest::NewestBySequence;
pub use rivals::{RivalLife, Rivals};
pub use rules::ShellRules;
pub use shell::{EPOCH_JUMP_MAX, StationFacts, StationShell};
