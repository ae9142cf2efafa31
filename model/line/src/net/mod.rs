//! From a checked station to its Petri net: operation modules, their connection, and what each transition waits for.
//!
//! This is the connection algorithm of seed 002 §5.2.1 with the conditions of its Figures 12, 13, 20 and 22. The net
//! and its conditions are *data*: the station's logic compiles them to tables, the checker reads them, an exporter
//! prints them, and all three mean the same controller. Nothing here runs.

mod condition;
mod connect;
mod exclusive;
mod hand;
mod module;
mod order;
mod station;

pub use condition::{ControlMode, Literal, Term, Var};
pub use connect::{Kind, Transition};
pub use exclusive::{Overlap, overlaps, overlaps_among};
pub use module::{Block, Place, Stage};
pub use station::StationNet;
