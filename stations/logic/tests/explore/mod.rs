//! The explorer: real controllers of several stations, composed with an environment that may do anything.
//!
//! It is an oracle independent of the controller's own reasoning. Motions complete, fail or stay at any moment;
//! operators press, hold and release at every panel at once; a station hears a change of mode when it hears it; every
//! reader holds any report between its last one and the newest; stations restart from what they kept. In every state
//! the invariants of `oracle.rs` are checked. Time stands still: what expires is left to the controller's own tests.
//!
//! An explorer that finds nothing is worth believing only if it would have. So each rule of [`Rules`] is switched off
//! in turn, and must be missed.
//!
//! `EXPLORE_STATES` and `EXPLORE_STEPS` set how far it looks; the defaults are what a build can wait for.

mod actions;
mod generated;
mod lines;
mod oracle;
mod rules;
mod search;
mod sound;
mod world;

use crate::build;
