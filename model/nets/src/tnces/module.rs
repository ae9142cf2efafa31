//! A module: a net with ports for conditions and events (seed 003 §3.2.2, L384-395).
//!
//! Ports have names, because people connect them. Of the printed definition, Cs ⊆ C^out × T and Dt ⊆ E^out × T are read
//! as P × C^out and T × E^out: a marked place is a condition, a firing is an event (L356, L362).
//!
//! A module is only written down here. It is checked when a composition is flattened, with all others.

use super::{EventMode, Interval};
use crate::{PlaceId, TransitionId};

/// An input port of a module or a composite: it names the port to the calls that use it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Port(pub(super) usize);

/// A TNCES module under construction. Its ids are its own.
#[derive(Clone, Debug)]
pub struct TncesModule {
    pub(super) name: String,
    pub(super) places: Vec<(String, u32, u32)>,
    pub(super) transitions: Vec<String>,
    pub(super) inputs: Vec<(TransitionId, PlaceId, u32)>,
    pub(super) outputs: Vec<(TransitionId, PlaceId, u32)>,
    pub(super) intervals: Vec<(TransitionId, PlaceId, Interval)>,
    pub(super) conditions: Vec<(TransitionId, PlaceId, u32)>,
    pub(super) events: Vec<(TransitionId, TransitionId)>,
    pub(super) modes: Vec<(TransitionId, EventMode)>,
    pub(super) external: Vec<TransitionId>,
    pub(super) condition_in: Vec<(String, Vec<TransitionId>)>,
    pub(super) event_in: Vec<(String, Vec<TransitionId>)>,
    pub(super) condition_out: Vec<(String, PlaceId)>,
    pub(super) event_out: Vec<(String, Vec<TransitionId>)>,
}

impl TncesModule {
    /// A module with nothing in it yet.
    pub fn new(name: impl Into<String>) -> Self {
        TncesModule {
            name: name.into(),
            places: Vec::new(),
            transitions: Vec::new(),
            inputs: Vec::new(),
            outputs: Vec::new(),
            intervals: Vec::new(),
            conditions: Vec::new(),
            events: Vec::new(),
            modes: Vec::new(),
            external: Vec::new(),
            condition_in: Vec::new(),
            event_in: Vec::new(),
            condition_out: Vec::new(),
            event_out: Vec::new(),
        }
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    /// Declares a place and the tokens it has at the beginning, of age 0.
    pub fn place(&mut self, name: impl Into<String>, tokens: u32) -> PlaceId {
        self.places.push((name.into(), tokens, 0));
        PlaceId((self.places.len() - 1) as u32)
    }

    /// Declares a place whose tokens have an age at the beginning (D₀).
    pub fn aged_place(&mut self, name: impl Into<String>, tokens: u32, age: u32) -> PlaceId {
        self.places.push((name.into(), tokens, age));
        PlaceId((self.places.len() - 1) as u32)
    }

    /// Declares a transition.
    pub fn transition(&mut self, name: impl Into<String>) -> TransitionId {
        self.transitions.push(name.into());
        TransitionId((self.transitions.len() - 1) as u32)
    }

    /// Declares a transition that takes one token from `from`, in the time of `interval`, and gives one to `to`: the
    /// change of a state.
    pub fn change(&mut self, name: impl Into<String>, from: PlaceId, to: PlaceId, interval: Interval) -> TransitionId {
        let t = self.transition(name);
        self.input(t, from, 1, interval).output(t, to, 1);
        t
    }

    /// `transition` takes `weight` tokens from `place`, in the time of `interval`.
    pub fn input(&mut self, transition: TransitionId, place: PlaceId, weight: u32, interval: Interval) -> &mut Self {
        self.inputs.push((transition, place, weight));
        if interval != Interval::ANY {
            self.intervals.push((transition, place, interval));
        }
        self
    }

    /// `transition` gives `weight` tokens to `place`.
    pub fn output(&mut self, transition: TransitionId, place: PlaceId, weight: u32) -> &mut Self {
        self.outputs.push((transition, place, weight));
        self
    }

    /// CN: a condition arc within the module.
    pub fn condition(&mut self, transition: TransitionId, place: PlaceId, weight: u32) -> &mut Self {
        self.conditions.push((transition, place, weight));
        self
    }

    /// EN: an event arc within the module.
    pub fn event(&mut self, from: TransitionId, to: TransitionId) -> &mut Self {
        self.events.push((from, to));
        self
    }

    /// Combination of events into a transition: those of an input port count as one, whatever drives it.
    pub fn event_mode(&mut self, transition: TransitionId, mode: EventMode) -> &mut Self {
        self.modes.push((transition, mode));
        self
    }

    /// Leaves it to the environment when `transition` fires.
    pub fn external(&mut self, transition: TransitionId) -> &mut Self {
        self.external.push(transition);
        self
    }

    /// C^in: a condition input.
    pub fn condition_in(&mut self, name: impl Into<String>) -> Port {
        self.condition_in.push((name.into(), Vec::new()));
        Port(self.condition_in.len() - 1)
    }

    /// E^in: an event input.
    pub fn event_in(&mut self, name: impl Into<String>) -> Port {
        self.event_in.push((name.into(), Vec::new()));
        Port(self.event_in.len() - 1)
    }

    /// Bc: `transition` fires only while the condition input holds.
    ///
    /// # Panics
    /// When the port is not a condition input of this module.
    pub fn only_if(&mut self, port: Port, transition: TransitionId) -> &mut Self {
        self.condition_in[port.0].1.push(transition);
        self
    }

    /// Be: an event at the input calls `transition`.
    ///
    /// # Panics
    /// When the port is not an event input of this module.
    pub fn on(&mut self, port: Port, transition: TransitionId) -> &mut Self {
        self.event_in[port.0].1.push(transition);
        self
    }

    /// Cs: a condition output, which holds while `place` is marked.
    pub fn condition_out(&mut self, name: impl Into<String>, place: PlaceId) -> &mut Self {
        self.condition_out.push((name.into(), place));
        self
    }

    /// Dt: an event output, which occurs when one of `transitions` fires.
    pub fn event_out(&mut self, name: impl Into<String>, transitions: impl Into<Vec<TransitionId>>) -> &mut Self {
        self.event_out.push((name.into(), transitions.into()));
        self
    }
}
