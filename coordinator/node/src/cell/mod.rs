//! The coordinator of a flexible cell: the token player on a thread of its own, its log, and what it says and hears.
//!
//! What happens next is decided in [`linewright_coordinator_cell`]; here it is written down, sent and told.

mod history;
mod log;
mod people;
mod play;
mod situation;
mod topics;
mod why;
mod wire;
mod words;

pub use history::Chronicle;
pub use log::{CellLog, CellLogError, Found, RECORDS_MAX};
pub use play::{CellError, CellOptions, Playing};
pub use situation::Situation;
