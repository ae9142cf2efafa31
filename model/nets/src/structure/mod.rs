//! Properties of a net without playing it.
//!
//! Everything here is decided on the arcs (and, for the verdict on state machines, on the initial marking), nearly all of
//! it in time linear in the size of the net. Nothing here computes reachable markings; that is [`crate::reach`].
//!
//! Each question is a method of [`crate::Net`] that answers `Ok(())` or the counterexample, so that a caller can print
//! why not:
//! - classes: [`crate::Net::is_state_machine`], [`crate::Net::is_marked_graph`], [`crate::Net::is_free_choice`]
//! - wider classes: [`crate::Net::is_extended_free_choice`], [`crate::Net::is_asymmetric_choice`]
//! - connection: [`crate::Net::is_strongly_connected`]
//! - conserved sums: [`crate::Net::incidence`]
//! - concurrent groups, as one place each: [`reduce`]
//! - and all of it put to use: [`state_machine_verdict`].

mod choice;
mod classes;
mod connected;
mod incidence;
mod reduce;
mod state_machine;
#[cfg(test)]
mod testnets;

pub use choice::{NotAsymmetricChoice, NotExtendedFreeChoice};
pub use classes::{HeavyArc, NotFreeChoice, NotMarkedGraph, NotStateMachine};
pub use connected::NotConnected;
pub use incidence::{Incidence, NotPlaceInvariant};
pub use reduce::{NotReducible, PlaceGroup, reduce};
pub use state_machine::{NotLive, NotReversible, NotSafe, StateMachineVerdict, state_machine_verdict};
