//! The controller by itself: every rule of its behaviour in a short scenario, inputs driven by hand.

mod agreement;
mod auto;
mod beside;
mod bolt;
mod commands;
mod entry;
mod faults;
mod hand;
mod homing;
mod hostile;
mod index;
mod interlock;
mod late_images;
mod place;
mod recovery;
mod restart;
mod resume;
pub mod rig;
mod stuck;
mod undo;
