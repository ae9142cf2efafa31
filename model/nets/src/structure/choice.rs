//! The wider classes: extended free choice and asymmetric choice; and nets without any choice.
//!
//! The definitions are those of Murata (*Petri nets: properties, analysis and applications*, 1989, §VI), for nets whose
//! arcs have weight 1. Every free-choice net is one of extended free choice, and every one of those is one of
//! asymmetric choice. What is proved about free-choice nets (Desel and Esparza, *Free Choice Petri Nets*, 1995) holds
//! for the extended class, which they call simply free-choice.

use thiserror::Error;

use super::HeavyArc;
use crate::{NamedId, Net, PlaceId, TransitionId};

/// Reason why a net is not of extended free choice.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum NotExtendedFreeChoice {
    /// Two transitions compete for one place, and one of them needs another place that the other does not.
    #[error("{first} and {second} compete for {shared}, but only {first} waits for {waits_for}")]
    Unequal {
        /// The place both take from.
        shared: NamedId<PlaceId>,
        /// The transition that needs more, or something else.
        first: NamedId<TransitionId>,
        /// Its competitor.
        second: NamedId<TransitionId>,
        /// Place that only the first one needs.
        waits_for: NamedId<PlaceId>,
    },
    #[error(transparent)]
    Weight(HeavyArc),
}

/// Reason why a net is not of asymmetric choice.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum NotAsymmetricChoice {
    /// Two places feed a common transition, and each also feeds one that the other does not.
    #[error(
        "{first} and {second} both feed {shared}, but {first} alone feeds {of_first}, and {second} alone {of_second}"
    )]
    Crossed {
        first: NamedId<PlaceId>,
        /// The other.
        second: NamedId<PlaceId>,
        /// The transition that takes from both.
        shared: NamedId<TransitionId>,
        /// One that takes from the first alone.
        of_first: NamedId<TransitionId>,
        /// One that takes from the second alone.
        of_second: NamedId<TransitionId>,
    },
    #[error(transparent)]
    Weight(HeavyArc),
}

impl Net {
    /// Whether transitions that share an input place have the same input places: if one of them can fire, all can.
    pub fn is_extended_free_choice(&self) -> Result<(), NotExtendedFreeChoice> {
        for p in self.places() {
            // Equality with the first consumer is equality among all.
            let Some((&(model, _), others)) = self.consumers(p).split_first() else { continue };
            for &(t, _) in others {
                let found = self.needs_more(model, t).or_else(|| self.needs_more(t, model));
                if let Some((first, second, waits_for)) = found {
                    return Err(NotExtendedFreeChoice::Unequal {
                        shared: self.place(p),
                        first: self.transition(first),
                        second: self.transition(second),
                        waits_for: self.place(waits_for),
                    });
                }
            }
        }
        self.heavy_arc().map_or(Ok(()), |heavy| Err(NotExtendedFreeChoice::Weight(heavy)))
    }

    /// An input place of one transition that is none of the other.
    fn needs_more(&self, t: TransitionId, other: TransitionId) -> Option<(TransitionId, TransitionId, PlaceId)> {
        let takes =
            |&&(place, _): &&(PlaceId, u32)| self.preset(other).binary_search_by_key(&place, |arc| arc.0).is_err();
        self.preset(t).iter().find(takes).map(|&(place, _)| (t, other, place))
    }

    /// Whether of two places with a common output transition, one has all the output transitions of the other.
    pub fn is_asymmetric_choice(&self) -> Result<(), NotAsymmetricChoice> {
        for shared in self.transitions() {
            let inputs = self.preset(shared);
            for (i, &(first, _)) in inputs.iter().enumerate() {
                for &(second, _) in &inputs[i + 1..] {
                    if let (Some(a), Some(b)) = (self.feeds_more(first, second), self.feeds_more(second, first)) {
                        return Err(NotAsymmetricChoice::Crossed {
                            first: self.place(first),
                            second: self.place(second),
                            shared: self.transition(shared),
                            of_first: self.transition(a),
                            of_second: self.transition(b),
                        });
                    }
                }
            }
        }
        self.heavy_arc().map_or(Ok(()), |heavy| Err(NotAsymmetricChoice::Weight(heavy)))
    }

    /// An output transition of one place that is none of the other.
    fn feeds_more(&self, place: PlaceId, other: PlaceId) -> Option<TransitionId> {
        let feeds =
            |&&(t, _): &&(TransitionId, u32)| self.consumers(other).binary_search_by_key(&t, |arc| arc.0).is_err();
        self.consumers(place).iter().find(feeds).map(|&(t, _)| t)
    }
}

#[cfg(test)]
mod tests {
    use crate::structure::testnets::{net, why};

    #[test]
    fn extended_free_choice_lets_competitors_need_the_same() {
        let extended = net(&["ab>c", "ab>d"]);
        assert!(extended.is_free_choice().is_err());
        assert_eq!(why(extended.is_extended_free_choice()), "yes");
        assert_eq!(
            why(net(&["a>c", "ab>d"]).is_extended_free_choice()),
            "transition `ab>d` and transition `a>c` compete for place `a`, \
             but only transition `ab>d` waits for place `b`"
        );
    }

    #[test]
    fn asymmetric_choice_lets_one_of_two_places_feed_more() {
        assert_eq!(why(net(&["a>c", "ab>d"]).is_asymmetric_choice()), "yes");
        assert_eq!(
            why(net(&["a>c", "ab>d", "b>c"]).is_asymmetric_choice()),
            "place `a` and place `b` both feed transition `ab>d`, \
             but place `a` alone feeds transition `a>c`, and place `b` alone transition `b>c`"
        );
    }
}
