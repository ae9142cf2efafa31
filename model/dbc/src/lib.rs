//! CAN databases: DBC files, read, and bound to a line description.
//!
//! [`read`] turns a file's bytes into a [`Database`] of messages and signals; [`bind`] turns a device's `dbc` table in
//! the file's names into numbers. The grammar is the library `can-dbc`'s; places in a frame are
//! [`FrameField`](linewright_line::FrameField)'s. *Only this crate reads DBC.* It has no bus and no time.

mod bind;
mod database;
mod told;

pub use bind::bind;
pub use database::{Database, DbcError, DbcMessage, DbcSignal, FILE_BYTES_MAX, Mux, read};
