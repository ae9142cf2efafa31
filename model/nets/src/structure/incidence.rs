//! The incidence matrix, and the sums that no firing changes.
//!
//! C(p, t) = Post(t, p) − Pre(p, t) is what firing t does to p. A weighting y of the places with y·C = 0 is a *place
//! invariant*: Σ y(p)·M(p) is the same in all reachable markings. That is a
//! claim which this module checks. It does not search for invariants ([`crate::semiflows`] does), and it cannot see what C does
//! not show: a place that is taken from and given back in one firing has entry 0.

use thiserror::Error;

use crate::{NamedId, Net, PlaceId, TransitionId};

/// The non-zero entries of the incidence matrix of a net.
#[derive(Clone, Debug)]
pub struct Incidence<'net> {
    net: &'net Net,
    /// Per transition, ordered by place.
    columns: Vec<Vec<(PlaceId, i64)>>,
}

/// A transition that changes a weighted sum of tokens.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("firing {transition} changes the weighted sum by {change}")]
pub struct NotPlaceInvariant {
    pub transition: NamedId<TransitionId>,
    /// Change of the weighted sum, in tokens.
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
        assert_eq!(c.place_invariant(&[1, 4, 7]), Ok(()));
        let error = c.place_invariant(&[1, 1, 0]).unwrap_err();
        assert_eq!(error.to_string(), "firing transition `screw` changes the weighted sum by -3");
    }
}
