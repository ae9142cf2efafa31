//! The token game: transitions that may fire, and the effect of firing.
//!
//! Enabling is a question about tokens alone. The game has no conditions, priorities or time, and forces nothing to
//! fire (seed 002 §3.1, firing rule 3). A logic controller fires an enabled transition once its condition holds (§3.2,
//! Definition 6); before that it is enabled here. Every move is all or nothing: a marking is changed only if the whole
//! move is possible.

use thiserror::Error;

use crate::{Marking, NamedId, Net, PlaceId, TransitionId};

/// Reason why a move was refused. The marking is as it was.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum FireError {
    /// A place has too few tokens: the transition is not enabled.
    #[error("{transition} cannot fire: {place} has {has} of the {needs} tokens needed")]
    Lacking {
        transition: NamedId<TransitionId>,
        /// The first place that lacks tokens.
        place: NamedId<PlaceId>,
        /// Tokens on the place.
        has: u32,
        /// Number needed.
        needs: u32,
    },
    /// A place would hold more tokens than can be counted.
    #[error("{transition} cannot fire: {place} has {has} tokens, and {gets} more cannot be counted")]
    Overflow {
        transition: NamedId<TransitionId>,
        /// The first place that would overflow.
        place: NamedId<PlaceId>,
        /// Tokens on the place.
        has: u32,
        /// Number it would get.
        gets: u32,
    },
}

impl FireError {
    /// The transition that was refused.
    pub fn transition(&self) -> TransitionId {
        match self {
            FireError::Lacking { transition, .. } | FireError::Overflow { transition, .. } => transition.id,
        }
    }

    /// The place that stood in the way.
    pub fn place(&self) -> PlaceId {
        match self {
            FireError::Lacking { place, .. } | FireError::Overflow { place, .. } => place.id,
        }
    }
}

impl Net {
    /// Whether every place of the preset has the tokens that the transition takes (seed 002 §3.1, firing rule 1).
    pub fn is_enabled(&self, marking: &Marking, transition: TransitionId) -> bool {
        self.expect_own(marking);
        self.preset(transition).iter().all(|&(place, weight)| marking.tokens(place) >= weight)
    }

    /// The transitions that are enabled, in order.
    pub fn enabled(&self, marking: &Marking) -> impl Iterator<Item = TransitionId> {
        self.expect_own(marking);
        self.transitions().filter(|&transition| self.is_enabled(marking, transition))
    }

    /// M₁[t⟩M₂: takes the tokens of the preset and gives those of the postset (seed 002 §3.1, firing rule 2).
    pub fn fire(&self, marking: &mut Marking, transition: TransitionId) -> Result<(), FireError> {
        self.expect_own(marking);
        let (takes, gives) = (self.preset(transition), self.postset(transition));
        for &(place, needs) in takes {
            let has = marking.tokens(place);
            if has < needs {
                let (transition, place) = (self.transition(transition), self.place(place));
                return Err(FireError::Lacking { transition, place, has, needs });
            }
        }
        for &(place, gets) in gives {
            let has = marking.tokens(place);
            // A place on both sides loses its tokens before it gets the new ones.
            let taken = takes.binary_search_by_key(&place, |&(place, _)| place).map_or(0, |at| takes[at].1);
            if (has - taken).checked_add(gets).is_none() {
                let (transition, place) = (self.transition(transition), self.place(place));
                return Err(FireError::Overflow { transition, place, has, gets });
            }
        }
        for &(place, weight) in takes {
            marking.set(place, marking.tokens(place) - weight);
        }
        for &(place, weight) in gives {
            marking.set(place, marking.tokens(place) + weight);
        }
        Ok(())
    }

    fn expect_own(&self, marking: &Marking) {
        let (places, covers) = (self.place_count(), marking.place_count());
        assert_eq!(covers, places, "a marking of {covers} places is not one of net `{}`", self.name());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NetBuilder;

    /// Four bolts and a plate make a part; the fixture is needed and stays.
    fn assembly(bolts: u32, parts: u32) -> (Net, TransitionId) {
        let mut b = NetBuilder::new("assembly");
        let screw = b.transition("screw");
        let bolts = b.place("bolts", bolts);
        let fixture = b.place("fixture", 1);
        let part = b.place("part", parts);
        b.input(screw, bolts, 4).input(screw, fixture, 1).output(screw, fixture, 1).output(screw, part, 1);
        (b.build().unwrap(), screw)
    }

    #[test]
    fn firing_moves_weighted_tokens_and_keeps_what_is_only_needed() {
        let (net, screw) = assembly(9, 0);
        let mut m = net.initial_marking();
        net.fire(&mut m, screw).unwrap();
        assert_eq!(m, Marking::from_tokens([5, 1, 1]));
        net.fire(&mut m, screw).unwrap();
        assert!(!net.is_enabled(&m, screw));
        assert_eq!(net.enabled(&m).count(), 0);
    }

    #[test]
    fn a_refusal_names_place_and_counts_and_changes_nothing() {
        let (net, screw) = assembly(3, 0);
        let mut m = net.initial_marking();
        let error = net.fire(&mut m, screw).unwrap_err();
        assert_eq!(error.to_string(), "transition `screw` cannot fire: place `bolts` has 3 of the 4 tokens needed");
        assert_eq!((error.transition(), m), (screw, net.initial_marking()));
    }

    #[test]
    fn more_tokens_than_can_be_counted_are_refused() {
        let (net, screw) = assembly(4, u32::MAX);
        let mut m = net.initial_marking();
        assert!(net.is_enabled(&m, screw));
        assert!(matches!(net.fire(&mut m, screw), Err(FireError::Overflow { has: u32::MAX, gets: 1, .. })));
        assert_eq!(m, net.initial_marking());
    }

    #[test]
    fn a_full_place_that_is_also_taken_from_does_not_overflow() {
        let mut b = NetBuilder::new("loop");
        let (p, t) = (b.place("p", u32::MAX), b.transition("t"));
        b.input(t, p, 1).output(t, p, 1);
        let net = b.build().unwrap();
        let mut m = net.initial_marking();
        net.fire(&mut m, t).unwrap();
        assert_eq!(m, net.initial_marking());
    }

    #[test]
    #[should_panic(expected = "a marking of 1 places is not one of net `assembly`")]
    fn the_marking_of_another_net_is_a_programming_error() {
        let (net, screw) = assembly(4, 0);
        net.is_enabled(&Marking::from_tokens([1]), screw);
    }
}
