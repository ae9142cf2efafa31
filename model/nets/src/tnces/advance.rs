//! When something happens next, if nothing happens until then.

use std::borrow::Borrow;

use super::engine::Engine;
use super::{TimedState, Tnces};
use crate::TransitionId;

/// Results of a delay in the state space.
pub(super) enum Pause {
    /// No time may pass: a transition is due.
    None,
    /// Nothing changes any more by waiting.
    Endless,
    /// So long, after which a transition may fire that could not before, or one that may fire may still do so.
    Until(u32),
}

impl<T: Borrow<Tnces>> Engine<T> {
    /// Time until a spontaneous transition is ripe, if it is not disabled before.
    pub(super) fn until_ripe(&self, state: &TimedState, t: TransitionId) -> Option<u32> {
        if !self.is_marked(&state.marking, t) || !self.conditions_hold(&state.marking, t) {
            return None;
        }
        self.moments(state, t).into_iter().find(|&shift| self.is_ripe(state, t, shift))
    }

    /// Time until no time may pass before a spontaneous transition fires.
    pub(super) fn until_due(&self, state: &TimedState, t: TransitionId) -> Option<u32> {
        if !self.is_marked(&state.marking, t) || !self.conditions_hold(&state.marking, t) {
            return None;
        }
        self.moments(state, t).into_iter().find(|&shift| self.is_due(state, t, shift))
    }

    /// The delay that leads to the next state worth having. While nothing is ripe, the states in between allow only to
    /// wait on, and are skipped. Once something is ripe that need not fire, each unit of time is a choice.
    pub(super) fn pause(&self, state: &TimedState) -> Pause {
        if self.spontaneous().iter().any(|&t| self.is_due(state, t, 0)) {
            return Pause::None;
        }
        let waits = self.spontaneous().iter().filter_map(|&t| self.until_ripe(state, t)).min();
        waits.map_or(Pause::Endless, |delay| Pause::Until(delay.max(1)))
    }
}
