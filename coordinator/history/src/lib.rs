//! History of a flexible cell or a line, in an embedded database: for queries while it runs, and for years after.
//!
//! ```text
//!   records ──▶ log on disk ──▶ Recorder ──▶ database ──▶ Reader ──▶ folds of `tracking` ──▶ reports
//!                   │  (own thread, bounded)  ▲   WAL: one writes, any number read
//!                   └─ what did not fit ──────┘
//! ```
//!
//! The log of a cell is what its coordinator goes on from, and a snapshot replaces its records. The database keeps them, and
//! nothing of the cell depends on it: a database that is lost, full or slow is a report that is missing. Each [`HistoryEvent`]
//! is a row: a record of the log by its number, so that feeding it twice changes nothing, or a [`Note`] about what is no record
//! (the mode of the cell, a device that is lost). Rows contain the record as JSON; reports are folds over the same records as
//! everywhere else, and SQL is for people ([`schema`](mod@self) has views for them).
//!
//! A line has no log: its coordinator gives notes alone, with the whole state of the line wherever some may be missing, and
//! [`mod@line`] folds them.
//!
//! A database that cannot be written is tried again: what was lost until then is a [`Note::Gap`] in it. A damaged one is kept
//! under another name. What is older than it has to keep is removed in small steps ([`History::keeping`]).
//!
//! *Only this crate contains SQL.* Times are those of the records; the thread has a clock for its trials alone.

mod about;
mod error;
mod event;
mod feeding;
pub mod line;
mod news;
mod note;
mod outage;
mod reader;
mod recorder;
mod retention;
mod schema;
mod set_aside;
mod writer;

pub use about::{About, CellAbout, LineAbout, LineOperation, LineStation, TimeBase};
pub use error::HistoryError;
pub use event::{EventKind, HistoryEvent};
pub use news::HistoryNews;
pub use note::{MotionOutcome, Note};
pub use outage::{LostNotes, Outages};
pub use reader::HistoryReader;
pub use recorder::{HistoryFeed, RecordSource};
pub use retention::RemovedPart;
pub use set_aside::set_aside;
pub use writer::History;
