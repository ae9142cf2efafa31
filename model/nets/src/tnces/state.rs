//! A marking with its clocks.
//!
//! The clocks depend on the reading: ages of tokens, or one clock per transition. Only nodes whose clock can matter have
//! one, and a clock stops where it no longer matters, so that equal futures are equal states and a bounded net has
//! finitely many.

use crate::Marking;

/// Tokens of one age. A place lists them oldest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct AgedTokens {
    pub(super) age: u32,
    pub(super) count: u32,
}

/// A marking and the clocks that go with it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TimedState {
    pub(super) marking: Marking,
    /// Per place with a clock, in the order of the places; nothing in the readings with transition clocks.
    pub(super) ages: Box<[Vec<AgedTokens>]>,
    /// Per transition with a clock, in the order of the transitions, 0 where it does not run; nothing for token ages.
    pub(super) clocks: Box<[u32]>,
}

impl TimedState {
    /// Where the tokens are.
    pub fn marking(&self) -> &Marking {
        &self.marking
    }
}

/// Number of tokens with an age, `shift` later, from `earliest` to `latest`.
pub(super) fn within(runs: &[AgedTokens], earliest: u32, latest: Option<u32>, shift: u32) -> u64 {
    let fits = |run: &&AgedTokens| {
        let age = run.age.saturating_add(shift);
        age >= earliest && latest.is_none_or(|latest| age <= latest)
    };
    runs.iter().filter(fits).map(|run| u64::from(run.count)).sum()
}

/// Takes the oldest `weight` tokens with an age from `earliest` to `latest`; there must be so many.
pub(super) fn take(runs: &mut Vec<AgedTokens>, earliest: u32, latest: Option<u32>, mut weight: u32) {
    for run in runs.iter_mut() {
        if run.age >= earliest && latest.is_none_or(|latest| run.age <= latest) {
            let taken = run.count.min(weight);
            run.count -= taken;
            weight -= taken;
        }
    }
    runs.retain(|run| run.count > 0);
}

/// Adds tokens of age 0.
pub(super) fn give(runs: &mut Vec<AgedTokens>, count: u32) {
    match runs.last_mut() {
        Some(AgedTokens { age: 0, count: young }) => *young += count,
        _ => runs.push(AgedTokens { age: 0, count }),
    }
}

/// Lets time pass, up to the age at which a clock stops.
pub(super) fn grow(runs: &mut Vec<AgedTokens>, delay: u32, cap: u32) {
    runs.iter_mut().for_each(|run| run.age = run.age.saturating_add(delay).min(cap));
    // All that reach the cap become one; the others keep their distances.
    runs.dedup_by(|young, old| {
        let same = young.age == old.age;
        if same {
            old.count += young.count;
        }
        same
    });
}
