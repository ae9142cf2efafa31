//! The coordinator of a flexible cell: the token player on a thread of its own, its log, and its messages.
//!
//! What happens next is decided in [`linewright_coordinator_cell`]; here it is written down, sent and published.

mod dispatched;
mod history;
mod keeping;
mod log;
mod pending_replies;
mod planning;
mod play;
mod requests;
mod topics;
mod why;
pub mod wire;
mod words;

pub use dispatched::{GoalStep, step_of};
pub use history::HistoryFeeder;
pub use keeping::{CellLogKeeper, ROOM_BYTES};
pub use log::{CellLog, CellLogError, OpenedLog, RECORDS_MAX};
pub use planning::{CellPlanning, RESTART_AFTER};
pub use play::{CellError, CellNodeOptions, CellThread};
pub use words::by_whom;
