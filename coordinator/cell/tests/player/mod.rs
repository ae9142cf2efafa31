//! The token player: its enabled set and its records against slower twins, the states of seed 000 that are printed, and
//! whole runs with pretended stations, some of them killed at every step. Under `dispatch` the dispatcher with rules.

mod crash;
pub mod dispatch;
mod enabled;
mod exceptions;
mod ledger;
mod picks;
pub mod plans;
pub mod printed;
mod records;
mod snapshot;
mod workcell;
pub mod world;
