//! Petri nets: structure, marking, token game and structural analysis.
//!
//! A net is the common language of this project: a station's controller, the mode decision and the coordination of a
//! line are nets, and what is proved about a line is proved about nets. This crate contains nets alone: no operations,
//! stations or conditions, and no clock, thread or socket: every function is called with all it needs.
//!
//! ```
//! use linewright_nets::{NetBuilder, state_machine_verdict};
//!
//! // A clamp that advances and returns: two states, one token.
//! let mut b = NetBuilder::new("clamp");
//! let open = b.place("open", 1);
//! let closed = b.place("closed", 0);
//! let advance = b.transition("advance");
//! let retract = b.transition("retract");
//! b.input(advance, open, 1).output(advance, closed, 1);
//! b.input(retract, closed, 1).output(retract, open, 1);
//! let net = b.build().expect("the clamp is written down correctly");
//!
//! // Play it.
//! let mut marking = net.initial_marking();
//! assert!(net.enabled(&marking).eq([advance]));
//! net.fire(&mut marking, advance)?;
//! assert_eq!(net.describe(&marking), "closed");
//!
//! // What cannot happen says why.
//! let refused = net.fire(&mut marking, advance).unwrap_err();
//! assert_eq!(refused.to_string(), "transition `advance` cannot fire: place `open` has 0 of the 1 tokens needed");
//!
//! // Prove it: live, safe and reversible, by structure alone.
//! let verdict = state_machine_verdict(&net)?;
//! assert!(verdict.holds(), "{verdict}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Map
//! - [`NetBuilder`] → [`Net`]: written down freely, checked once, immutable afterwards.
//! - [`Marking`] and [`game`]: where the tokens are, and how they move.
//! - [`structure`]: facts without playing: classes of nets, connection, conserved sums, and the verdict on state
//!   machines. Linear in the size of the net, so this is what scales.
//! - [`semiflows`], [`siphons`], [`coverability`]: conserved sums and repetitions, sets that stay empty or marked, and
//!   boundedness of any net. Each is complete or returns where it stopped.
//! - [`certificate`]: live, bounded, safe, reversible and free of deadlocks by structure, each answer with evidence that
//!   a small checker accepts on its own.
//! - [`explicit`]: every reachable marking of a bounded net. [`reach`]: the same the slow and obvious way, for tests.
//! - [`tnces`]: nets with conditions, events and time, and modules that are joined at their ports.
//! - [`dot()`] and the `Display` of [`Net`]: for eyes.
//!
//! # How richer nets fit
//! Event arcs, time intervals and colours restrict *when* a transition of the underlying net fires, or split a place
//! by the colour of its tokens. Each is a table beside a [`Net`], indexed by its dense ids, with its own state beside
//! the [`Marking`]; whatever structure proves about conserved sums holds for the restricted net unchanged.

mod builder;
pub mod certificate;
pub mod coloured;
mod components;
pub mod coverability;
mod dot;
pub mod explicit;
pub mod game;
mod id;
mod marking;
mod net;
pub mod reach;
pub mod semiflows;
pub mod siphons;
pub mod structure;
mod table;
pub mod tnces;

pub use builder::{ArcDirection, ArcName, MAX_NODES, NetBuilder, NetError};
pub use dot::dot;
pub use game::FireError;
pub use id::{NamedId, NetNode, PlaceId, TransitionId};
pub use marking::Marking;
pub use net::Net;
pub use reach::{ReachArc, ReachLimit, ReachUndecided, Reachability, StateId, explore};
pub use structure::{NotLive, NotReversible, NotSafe, NotStateMachine, StateMachineVerdict, state_machine_verdict};
