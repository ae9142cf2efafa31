//! The controller by itself: every rule of its behaviour as a short story, inputs driven by hand.

#[path = "../../../../model/line/tests/common/mod.rs"]
mod build;
mod rig;

mod agreement;
mod auto;
mod beside;
mod commands;
mod faults;
mod hand;
mod hostile;
mod recovery;
mod restart;
mod undo;
