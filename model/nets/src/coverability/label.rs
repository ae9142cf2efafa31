//! Markings in which a place may hold ω, more than any number.

use crate::{FireError, Marking, Net, PlaceId, TransitionId};

/// The count that stands for ω. Real counts stay below it.
pub(super) const OMEGA: u32 = u32::MAX;

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct MarkingLabel(pub Box<[u32]>);

impl MarkingLabel {
    pub fn of(marking: &Marking) -> MarkingLabel {
        MarkingLabel(marking.as_slice().into())
    }

    pub fn counts(&self) -> impl Iterator<Item = Option<u32>> + '_ {
        self.0.iter().map(|&count| (count != OMEGA).then_some(count))
    }

    /// Whether no place has less than in `other`; ω is the greatest count.
    pub fn covers(&self, other: &[u32]) -> bool {
        self.0.iter().zip(other).all(|(mine, theirs)| mine >= theirs)
    }

    pub fn has_omega(&self) -> bool {
        self.0.contains(&OMEGA)
    }

    /// The tokens on places that have a number of them, and how many places have not.
    pub fn weight(&self) -> (usize, u64) {
        let infinite = self.0.iter().filter(|&&count| count == OMEGA).count();
        (infinite, self.0.iter().filter(|&&count| count != OMEGA).map(|&count| u64::from(count)).sum())
    }

    pub fn enables(&self, net: &Net, transition: TransitionId) -> bool {
        net.preset(transition).iter().all(|&(place, weight)| self.0[place.index()] >= weight)
    }

    /// The label after an enabled transition.
    pub fn fired(&self, net: &Net, transition: TransitionId) -> Result<MarkingLabel, FireError> {
        let mut next = self.0.clone();
        for &(place, weight) in net.preset(transition) {
            let count = &mut next[place.index()];
            if *count != OMEGA {
                *count -= weight;
            }
        }
        for &(place, weight) in net.postset(transition) {
            let count = &mut next[place.index()];
            if *count != OMEGA {
                *count = count.checked_add(weight).filter(|&sum| sum != OMEGA).ok_or_else(|| FireError::Overflow {
                    transition: net.transition(transition),
                    place: net.place(place),
                    has: self.0[place.index()],
                    gets: weight,
                })?;
            }
        }
        Ok(MarkingLabel(next))
    }

    /// The places with more than in `below`.
    pub fn above(&self, below: &MarkingLabel) -> Vec<PlaceId> {
        let pairs = (0..).map(PlaceId).zip(self.0.iter().zip(&below.0));
        pairs.filter(|(_, (mine, theirs))| mine > theirs).map(|(place, _)| place).collect()
    }
}
