//! All tests of this crate in one program.

mod contest;
mod estop;
mod gap;
mod health;
mod held;
mod lifecycle;
mod newest;
mod numbered;
mod order_of_effects;
mod rig;
mod rivals;
mod senders;
mod start;
