//! The description of a flexible cell: text → checked [`Cell`] → coloured nets.
//!
//! A cell has no fixed cycle: parts of several types come, resources compete for them, and a coordinator decides what
//! happens next. This crate contains the parts of a cell, its description and the nets that follow from it (seed 001
//! §3; seed 000 §3). It contains no time passing, no decisions, and no messages to stations.

mod cell;
pub mod net;
mod parse;
mod prototype;
mod routes;

pub use cell::*;
pub use parse::{ParsedCell, fits, is_described, parse, schema};
pub use prototype::{Prototype, ResourceAction, Role};
