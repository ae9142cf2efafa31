//! CAN databases: DBC files, read, and bound to a line description.
//!
//! [`read`] turns a file's bytes into a [`Database`] of messages and signals; [`bind`] works out in numbers what a
//! device's `dbc` table says in the file's names. The grammar is the library `can-dbc`'s; what lies where in a frame is
//! [`FrameField`](linewright_line::FrameField)'s. *Only this crate knows DBC.* It knows no bus and no time.

mod bind;
mod database;
mod told;

pub use bind::bind;
pub use database::{Database, DbcError, DbcMessage, DbcSignal, FILE_BYTES_MAX, Mux, read};
