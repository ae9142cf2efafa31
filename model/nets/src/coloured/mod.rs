//! Coloured nets: tokens that carry data, arc functions and guards (seed 000, definitions 13 to 21).
//!
//! One place for "a machine is free" instead of one per machine: the token's colour is the machine. A coloured net is an
//! ordinary net written short, and every statement about it here means the same for the long form; [`unfold`] writes
//! that out, and most tests of this module compare the two. What is gained is a text that people can read, and an
//! exploration that touches only the colours that occur.
//!
//! # Map
//! - [`Domain`], [`Function`], [`Guard`]: what colours there are, what arcs do with them, which modes exist.
//! - [`ColouredBuilder`] → [`ColouredNet`]: written down freely, checked once. [`fuse`]: nets put together.
//! - [`ColouredMarking`] and the token game ([`ColouredNet::enabled`], [`ColouredNet::fire`]).
//! - [`explore`]: all reachable markings; deadlocks, liveness of modes, bounds. The oracle of tests.
//! - [`unfold`]: the ordinary net, with the way back. [`flow`]: conserved sums and cycles, coloured.
//! - [`decide`]: which modes are in conflict, and guards that wait for a dispatcher.

mod bind;
mod builder;
mod check;
pub mod decide;
mod domain;
mod error;
pub mod flow;
mod function;
mod fuse;
mod game;
mod guard;
mod linear;
mod marking;
mod net;
mod reach;
mod table;
mod unfold;

pub use builder::ColouredBuilder;
pub use check::MAX_COMPONENTS;
pub use domain::{BasicDomain, BasicId, Domain};
pub use error::ColouredError;
pub use function::{Function, MAX_TERMS, abs, id, pred, proj, ring, succ};
pub use fuse::{Fusion, fuse};
pub use game::ColouredFireError;
pub use guard::{Atom, Clause, Comparison, Guard, MAX_CLAUSES, Operand, colour, compare, component, not_colour};
pub use linear::FunctionError;
pub use marking::{ColouredMarking, TokenElement};
pub use net::{ColouredNet, NetMode};
pub use reach::{ColouredReachability, explore};
pub use unfold::{Colours, UnfoldError, Unfolding, unfold};
