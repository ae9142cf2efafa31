//! What a station's node does between messages, as pure code.
//!
//! The controller decides what the station does; a node around it has to know which message is the newest, how old an
//! image is and under which outputs it was taken, what is written down before what is sent, and what to do after it has
//! stood still itself. That is [`StationShell`]: it takes what has arrived and gives effects, in the order in which they
//! must become true. The node of ROS 2 performs them with sockets and files, a simulation in memory; neither has rules
//! of its own.
//!
//! [`NewestBySequence`] is here for every reader of whole-state messages, [`Rivals`] for those of the coordinator's order.

mod effect;
mod newest;
mod rivals;
mod shell;

pub use effect::{Driven, InputsMessage, StationArrival, StationEffect};
pub use newest::NewestBySequence;
pub use rivals::{RivalLife, Rivals};
pub use shell::{EPOCH_JUMP_MAX, StationShell};
