//! Consequences of conserved sums for a marked net: bounds of places, and places that are never marked together.
//!
//! All of it follows from Σ y(p)·M(p) = Σ y(p)·M₀(p) for every reachable M, so it is true, but need not be tight: a
//! bound may be more than what is ever reached, and two places may exclude each other for reasons that no sum shows.

use super::{Semiflow, Semiflows};
use crate::{Marking, Net, PlaceId};

impl Semiflow<PlaceId> {
    /// Σ y(p)·M(p).
    ///
    /// # Panics
    /// When the marking is of a net with fewer places.
    pub fn sum(&self, marking: &Marking) -> u128 {
        // 63 bits of weight, 32 of tokens and 24 of places.
        self.weights.iter().map(|&(place, weight)| u128::from(weight) * u128::from(marking.tokens(place))).sum()
    }
}

impl Semiflows<PlaceId> {
    /// The places in no support: no conserved sum bounds them.
    pub fn uncovered<'a>(&'a self, net: &Net) -> impl Iterator<Item = PlaceId> + 'a {
        net.places().filter(|&place| !self.covers(place))
    }

    /// The most tokens that the sums of `initial` allow on a place, and the semiflow that proves it; none if no
    /// semiflow has the place in its support.
    pub fn bound(&self, place: PlaceId, initial: &Marking) -> Option<(u128, &Semiflow<PlaceId>)> {
        let bound = |flow: &Semiflow<PlaceId>| flow.sum(initial) / u128::from(flow.weight(place));
        self.through(place).map(|flow| (bound(flow), flow)).min_by_key(|&(bound, _)| bound)
    }

    /// A semiflow by which two different places are never marked at the same time, starting from `initial`.
    pub fn excludes(&self, a: PlaceId, b: PlaceId, initial: &Marking) -> Option<&Semiflow<PlaceId>> {
        let both = |flow: &&Semiflow<PlaceId>| {
            u128::from(flow.weight(a)) + u128::from(flow.weight(b)) > flow.sum(initial) && a != b
        };
        self.through(a).chain(self.through(b)).find(both)
    }
}
