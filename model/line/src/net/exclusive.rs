//! Are the output transitions of every place mutually exclusive, mode by mode?
//!
//! The seed requires it (§6.2.1: a net with exclusive transitions can be run as it stands). Here it is decided on the
//! conditions as written: two terms exclude each other if some literal of one contradicts some literal of the other.
//! That is sound — terms found exclusive are — and complete for terms whose variables are otherwise independent,
//! which sensors and buttons are.

use crate::net::condition::{Conjunction, ControlMode};
use crate::net::connect::{StationTransition, TransitionKind};
use crate::net::module::StationPlace;
use crate::net::station::StationNet;

/// Two transitions of one place that could both be allowed to fire.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Overlap {
    /// The place they share.
    pub place: StationPlace,
    /// The mode in which it happens.
    pub mode: ControlMode,
    /// One transition and the term that lets it fire.
    pub a: (TransitionKind, Conjunction),
    /// The other.
    pub b: (TransitionKind, Conjunction),
}

/// Every pair of output transitions of a place that is not exclusive. Empty for every net the connection algorithm
/// builds; a caller checks it all the same.
pub fn overlaps(net: &StationNet) -> Vec<Overlap> {
    overlaps_among(net.places(), net.transitions())
}

/// The same of any transitions: of a station's as they would be if a condition were another.
pub fn overlaps_among(places: &[StationPlace], transitions: &[StationTransition]) -> Vec<Overlap> {
    let mut found = Vec::new();
    for &place in places {
        let outgoing: Vec<_> = transitions.iter().filter(|t| t.from.contains(&place)).collect();
        for (i, a) in outgoing.iter().enumerate() {
            for b in &outgoing[i + 1..] {
                for mode in ControlMode::ALL {
                    for ta in a.terms(mode) {
                        for tb in b.terms(mode).iter().filter(|tb| !exclude(ta, tb)) {
                            found.push(Overlap { place, mode, a: (a.kind, ta.clone()), b: (b.kind, tb.clone()) });
                        }
                    }
                }
            }
        }
    }
    found
}

fn exclude(a: &Conjunction, b: &Conjunction) -> bool {
    a.iter().any(|la| b.iter().any(|lb| la.excludes(*lb)))
}
