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
mod sheet;
mod station;
mod task_driven;

pub use condition::{Conjunction, ControlMode, Literal, Var};
pub use connect::{StationTransition, TransitionKind};
pub use exclusive::{Overlap, overlaps, overlaps_among};
pub use module::{Block, MotionStage, StationPlace};
pub use sheet::{NODE_RADIUS, NetSheet, SheetArc, SheetPoint};
pub use station::StationNet;
