//! The controller by itself: every rule of its behaviour as a short story, inputs driven by hand.

mod agreement;
mod auto;
mod beside;
mod commands;
mod faults;
mod hand;
mod hostile;
mod index;
mod interlock;
mod recovery;
mod restart;
pub mod rig;
mod stuck;
mod undo;
