//! Timed net condition/event systems: condition arcs, event arcs and time on input arcs (seed 003 §3.2).
//!
//! A [`Tnces`] is a set of tables beside a [`Net`](crate::Net). *Condition arcs* let a transition read a place without
//! taking from it. *Event arcs* let the firing of one transition force others, in the same step. *Intervals* on input
//! arcs are the age that a token, or an enabling, must have. The tables only restrict the token game of the net, so
//! what its structure proves about conserved sums holds unchanged.
//!
//! The source leaves a good deal open; every such point is either a named setting ([`Semantics`], [`EventMode`]) or a
//! rule stated with its reason below. There are no machines, units or wall clock here: time is a whole number.
//!
//! # A step
//! A transition with event arcs into it is *forced*: it fires with its sources or not at all. All others are
//! *spontaneous*. A step is one spontaneous transition and everything it forces, directly or along further event arcs:
//! a set that is maximal among those in which each forced transition is called by its sources, all conditions hold in
//! the marking before the step, all intervals allow it, and the tokens suffice for all together. A forced transition
//! that cannot take part is left out; its source fires all the same (seed 003, L362: it "is also fired … because the
//! event happens and the transition is enabled"). Where forced transitions compete for tokens there are several maximal
//! steps. Tokens are taken by the spontaneous transition first, then by the others in the order of the longest way of
//! event arcs to each, then of their numbers. Spontaneous transitions of one instant fire one after the other, in any
//! order. Event arcs form no cycle.
//!
//! This is the rule of signal/event nets, from which these systems come (P. Starke and S. Roch, *Analysing Signal-Net
//! Systems*, Humboldt-Universität zu Berlin, Informatik-Bericht 162, 2002), with one spontaneous transition in a step
//! where they allow several. So a transition in mode [`EventMode::All`] needs sources that one step can hold together.
//!
//! # Several tokens on a place
//! The source has clocks "associated with the places" (L405) and does not treat two tokens. Here each token has its own
//! age, and a firing takes the oldest that its interval allows: pallets in a queue wait each for itself and leave first
//! in, first out. One clock per place, set back by each arrival, would let a stream of arrivals hold the first pallet
//! for ever. A transition clock (the other readings) is one per transition: it starts anew after each firing, as a
//! mechanism that moves one piece after the other does.
//!
//! # Analyses
//! - [`Tnces::untimed_space`]: every marking, with conditions and events and without time.
//! - [`Tnces::timed_space`]: every marking with its clocks, these cut off at the largest bound that matters.
//! - [`StateGraph`]: deadlocks, shortest and longest times between states, prefix and cycles.
//! - [`TncesPlayer`]: one run, step by step, for a simulated plant.
//!
//! # Composition
//! A [`TncesModule`] has condition and event ports; a [`Composite`] joins modules and composites, and [`Composite::flatten`]
//! gives the flat system. [`parts`] has the input, output and update modules of seed 003 §3.3.3.

mod advance;
mod builder;
mod chain;
mod check;
mod compose;
mod engine;
mod error;
mod flatten;
mod graph;
mod loops;
mod module;
pub mod parts;
mod player;
mod semantics;
mod space;
mod state;
mod steps;
mod system;

pub use builder::{TIME_MAX, TncesBuilder};
pub use compose::{ComponentId, Composite, Element, Endpoint};
pub use error::{ComposeError, TncesError};
pub use graph::{GraphArc, Latest, StateGraph, StepId, TimeBound, TimedLabel};
pub use loops::{LoopShape, StateLoop};
pub use module::{Port, TncesModule};
pub use player::{FiredStep, NotEnabled, Policy, Restless, TncesPlayer};
pub use semantics::{ArcClock, Deadline, EventMode, FiringPolicy, Interval, Semantics};
pub use state::TimedState;
pub use system::Tnces;

#[cfg(doctest)]
#[doc = include_str!("../../../../docs/nets.md")]
struct TheExampleOfTheDocumentation;
