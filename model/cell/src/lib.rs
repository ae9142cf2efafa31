//! The description of a flexible cell: text → checked [`Cell`] → coloured nets.
//!
//! A cell has no fixed cycle: parts of several types come, resources compete for them, and a coordinator decides what
//! happens next. This crate knows what a cell is made of, how its description is written and which nets follow from it
//! (seed 001 §3; seed 000 §3). It knows nothing of time passing, of decisions, or of how stations are talked to.

mod cell;
pub mod net;
mod parse;
mod prototype;
mod routes;

pub use cell::*;
pub use parse::{ParsedCell, fits, is_described, parse, schema};
pub use prototype::{Prototype, ResourceAction, Role};
