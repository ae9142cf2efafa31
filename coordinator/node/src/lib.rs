//! The coordinator's ROS 2 node: a thin shell around [`linewright_coordinator_logic`].
//!
//! It carries the line's CAN bus: the console's devices, and those of every station that has no bus of its own. For
//! these it is the gateway: input images go to the stations by message, output images come back, with age and
//! validity. What may be energised is decided in [`linewright_coordinator_logic::Gateway`], which mode the line is in
//! in [`linewright_coordinator_logic::Coordinator`]; this crate performs it. Of a flexible cell
//! [`cell`] keeps on disk what happens, of a line [`mod@line`].

mod arrivals;
pub mod cell;
mod command;
mod gateway_topics;
mod lifecycle;
pub mod line;
mod mode_services;
mod node;
mod publish;
mod refusals;
mod remembered;
mod situation;
mod stop_time;
mod topics;
mod waiting;

pub use command::{command_of, words_of};
pub use gateway_topics::outputs_from_message;
pub use node::{CoordinatorNodeError, CoordinatorOptions, run};
pub use refusals::Refusals;
pub use remembered::{record_of, remembered};
pub use situation::{LineSituation, fault_note};
pub use stop_time::StopTime;
