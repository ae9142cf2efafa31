//! The incidence matrix, and the sums that no firing changes.
//!
//! C(p, t) = Post(t, p) − Pre(p, t) is what firing t does to p. A weighting y of the places with y·C = 0 is a *place
//! invariant*: Σ y(p)·M(p) is the same in all reachable markings. A count x of firings with C·x = 0 is a *transition
//! invariant*: a sequence with these counts leads back to where it began. Both are claims that a generator of nets can
//! make and this module checks. It does not search for invariants, and it cannot see what C does not show: a place
//! that is taken from and given back in one firing has entry 0.

use thiserror::Error;

use crate::{NamedId, Net, PlaceId, TransitionId};

/// The non-zero entries of the incidence matrix of a net.
#[derive(Clone, Debug)]
pub struct Incidence<'net> {
    net: &'net Net,
    /// Per transition, ordered by place.
    columns: Vec<Vec<(PlaceId, i64)>>,
}

/// A transition that makes or loses tokens.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{transition} takes {takes} tokens and gives {gives}")]
pub struct NotConservative {
    pub transition: NamedId<TransitionId>,
    /// Tokens that firing takes, summed over all places.
    pub takes: u64,
    /// Tokens that firing gives.
    pub gives: u64,
}

/// A transition that changes a weighted sum of tokens.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("firing {transition} changes the weighted sum by {change}")]
pub struct NotPlaceInvariant {
    pub transition: NamedId<TransitionId>,
    /// Change of the weighted sum, in tokens.
    pub change: i128,
}

/// A place whose tokens are not the same again after a sequence of firings.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("the firings change the tokens of {place} by {change}")]
pub struct NotTransitionInvariant {
    pub place: NamedId<PlaceId>,
    /// Change of the place, in tokens.
    pub change: i128,
}

impl Net {
    /// The incidence matrix.
    pub fn incidence(&self) -> Incidence<'_> {
        let column = |t| {
            let gives = self.postset(t).iter().map(|&(place, weight)| (place, i64::from(weight)));
            let takes = self.preset(t).iter().map(|&(place, weight)| (place, -i64::from(weight)));
            let mut entries: Vec<_> = gives.chain(takes).collect();
            entries.sort_unstable_by_key(|&(place, _)| place);
            entries.dedup_by(|later, earlier| {
                let same = later.0 == earlier.0;
                if same {
                    earlier.1 += later.1;
                }
                same
            });
            entries.retain(|&(_, change)| change != 0);
            entries
        };
        Incidence { net: self, columns: self.transitions().map(column).collect() }
    }

    /// Whether every transition gives as many tokens as it takes, so that their number never changes. State machines
    /// are conservative. It is the place invariant with all weights 1.
    pub fn is_conservative(&self) -> Result<(), NotConservative> {
        let sum = |arcs: &[(PlaceId, u32)]| arcs.iter().map(|&(_, weight)| u64::from(weight)).sum();
        for t in self.transitions() {
            let (takes, gives) = (sum(self.preset(t)), sum(self.postset(t)));
            if takes != gives {
                return Err(NotConservative { transition: self.transition(t), takes, gives });
            }
        }
        Ok(())
    }
}

impl Incidence<'_> {
    /// C(p, t).
    pub fn entry(&self, place: PlaceId, transition: TransitionId) -> i64 {
        let column = self.column(transition);
        column.binary_search_by_key(&place, |&(place, _)| place).map_or(0, |at| column[at].1)
    }

    /// Change by firing a transition, without the zeros; ordered by place.
    pub fn column(&self, transition: TransitionId) -> &[(PlaceId, i64)] {
        &self.columns[transition.index()]
    }

    /// Whether y·C = 0.
    ///
    /// # Panics
    /// When `weights` has not one entry per place.
    pub fn place_invariant(&self, weights: &[i64]) -> Result<(), NotPlaceInvariant> {
        assert_eq!(weights.len(), self.net.place_count(), "a place invariant has one weight per place");
        for t in self.net.transitions() {
            let product = |&(place, entry): &(PlaceId, i64)| i128::from(weights[place.index()]) * i128::from(entry);
            let change: i128 = self.column(t).iter().map(product).sum();
            if change != 0 {
                return Err(NotPlaceInvariant { transition: self.net.transition(t), change });
            }
        }
        Ok(())
    }

    /// Whether C·x = 0.
    ///
    /// # Panics
    /// When `firings` has not one entry per transition.
    pub fn transition_invariant(&self, firings: &[u32]) -> Result<(), NotTransitionInvariant> {
        assert_eq!(firings.len(), self.net.transition_count(), "a transition invariant has one count per transition");
        let mut changes = vec![0_i128; self.net.place_count()];
        for (t, &count) in self.net.transitions().zip(firings) {
            for &(place, entry) in self.column(t) {
                changes[place.index()] += i128::from(entry) * i128::from(count);
            }
        }
        match self.net.places().find(|place| changes[place.index()] != 0) {
            Some(p) => Err(NotTransitionInvariant { place: self.net.place(p), change: changes[p.index()] }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::NetBuilder;

    #[test]
    fn four_bolts_weigh_as_much_as_one_part() {
        let mut b = NetBuilder::new("assembly");
        let [bolts, part, fixture] = ["bolts", "part", "fixture"].map(|name| b.place(name, 1));
        let screw = b.transition("screw");
        let unscrew = b.transition("unscrew");
        b.input(screw, bolts, 4).input(screw, fixture, 1).output(screw, fixture, 1).output(screw, part, 1);
        b.input(unscrew, part, 1).output(unscrew, bolts, 4);
        let net = b.build().unwrap();
        let c = net.incidence();

        assert_eq!(c.column(screw), [(bolts, -4), (part, 1)]);
        assert_eq!((c.entry(fixture, screw), c.entry(bolts, unscrew)), (0, 4));
        assert_eq!(net.is_conservative().unwrap_err().to_string(), "transition `screw` takes 5 tokens and gives 2");
        assert_eq!(c.place_invariant(&[1, 4, 7]), Ok(()));
        let error = c.place_invariant(&[1, 1, 0]).unwrap_err();
        assert_eq!(error.to_string(), "firing transition `screw` changes the weighted sum by -3");
        assert_eq!(c.transition_invariant(&[3, 3]), Ok(()));
        let error = c.transition_invariant(&[1, 0]).unwrap_err();
        assert_eq!(error.to_string(), "the firings change the tokens of place `bolts` by -4");
    }
}
