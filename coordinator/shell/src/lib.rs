//! Behaviour of the coordinator's node between messages, as pure code.
//!
//! [`linewright_coordinator_logic::Coordinator`] decides the mode and [`linewright_coordinator_logic::Gateway`] which
//! outputs may be in force. The rest of a node's decisions (the newest message, what a station behind the gateway was
//! sent last, what is written before what is sent, and what follows when it cannot be) is [`CoordinatorShell`]: it takes
//! what has arrived and gives effects, in the order in which they must become true. The node of ROS 2 performs them with
//! sockets and files, a simulation in memory; neither has rules of its own.

mod effect;
mod gateway_station;
pub mod orders;
pub mod parameters;
mod shell;

pub use effect::{CoordinatorArrival, CoordinatorEffect, CoordinatorRecord, InputsImage, heard};
pub use shell::{CoordinatorShell, RefusalFacts, cell_check, commands_check, coordinator_checks};
