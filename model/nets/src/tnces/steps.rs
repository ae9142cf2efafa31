//! The maximal steps of a state.
//!
//! Forced transitions are gone through with sources before targets. One that is called, willing and has its tokens
//! takes part. If it is contested, leaving it out is tried too, and such a step counts only if in the end the tokens do
//! not suffice for it. Looking at one transition more at a time is enough: if a larger step were possible, the first of
//! its further transitions could be added alone, because tokens that suffice for many suffice for few.

use std::borrow::Borrow;

use super::engine::Engine;
use super::{TimedState, Tnces};
use crate::TransitionId;

/// A step under construction.
#[derive(Clone)]
struct Walk {
    chosen: Vec<TransitionId>,
    fires: Vec<bool>,
    /// Left out although the tokens were there, and the position in `chosen` where it would stand.
    spared: Vec<(TransitionId, usize)>,
    /// Rest after the chosen ones.
    left: TimedState,
}

impl<T: Borrow<Tnces>> Engine<T> {
    /// Every step that is possible now: by trigger; for each trigger first the one that favours low positions.
    pub(super) fn steps(&self, state: &TimedState) -> Vec<Box<[TransitionId]>> {
        let ripe = self.spontaneous().iter().filter(|&&t| self.is_ripe(state, t, 0));
        ripe.flat_map(|&t| self.steps_of(state, t)).collect()
    }

    /// The steps of one trigger, which must be ripe.
    pub(super) fn steps_of(&self, state: &TimedState, trigger: TransitionId) -> Vec<Box<[TransitionId]>> {
        let mut fires = vec![false; self.system().rows.len()];
        fires[trigger.index()] = true;
        let mut left = state.clone();
        if !self.take(&mut left, trigger) {
            return Vec::new();
        }
        let mut found = Vec::new();
        let mut open = vec![(Walk { chosen: vec![trigger], fires, spared: Vec::new(), left }, 0)];
        while let Some((walk, from)) = open.pop() {
            self.complete(state, trigger, walk, from, &mut open, &mut found);
        }
        found
    }

    fn complete(
        &self,
        state: &TimedState,
        trigger: TransitionId,
        mut walk: Walk,
        from: usize,
        open: &mut Vec<(Walk, usize)>,
        found: &mut Vec<Box<[TransitionId]>>,
    ) {
        let sys = self.system();
        let chain = &sys.chains[trigger.index()];
        for (at, (&t, &contested)) in chain.members.iter().zip(&chain.contested).enumerate().skip(from) {
            let mut groups = sys.rows[t.index()].groups.iter();
            let called = groups.all(|group| group.iter().any(|source| walk.fires[source.index()]));
            if !called || !self.is_willing(state, t) {
                continue;
            }
            let without = contested.then(|| walk.clone());
            if !self.take(&mut walk.left, t) {
                continue;
            }
            if let Some(mut without) = without {
                without.spared.push((t, without.chosen.len()));
                open.push((without, at + 1));
            }
            walk.chosen.push(t);
            walk.fires[t.index()] = true;
        }
        if walk.spared.iter().all(|&(t, at)| !self.suffices(state, &walk.chosen, t, at)) {
            found.push(walk.chosen.into());
        }
    }

    /// Whether the tokens suffice for `chosen` and, at position `at`, for `t` too.
    fn suffices(&self, state: &TimedState, chosen: &[TransitionId], t: TransitionId, at: usize) -> bool {
        let mut left = state.clone();
        let all = chosen[..at].iter().chain([&t]).chain(&chosen[at..]);
        all.into_iter().all(|&t| self.take(&mut left, t))
    }
}
