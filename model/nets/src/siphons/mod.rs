//! Siphons and traps: sets of places that stay empty, and sets that stay marked.
//!
//! A *siphon* is a set S of places with •S ⊆ S•: every transition that puts a token in takes one out, so that an empty
//! siphon stays empty, and every transition that takes from it is dead. A *trap* is the mirror image, S• ⊆ •S: once it
//! has a token it always will. Both hold for weighted arcs too. Unions of siphons are siphons, so every set of places
//! contains a largest one, found in time linear in the net; *minimal* ones, with no other inside, can be exponentially
//! many, and their search is bounded.
//!
//! Commoner's theorem (Hack, *Analysis of production schemata by Petri nets*, 1972; Murata 1989, §VI): a free-choice net
//! is live iff every siphon contains a trap that is marked initially. In any net without weights the same condition
//! still excludes deadlocks. This module does not check the class of a net.

mod search;
mod sides;

use thiserror::Error;

use crate::{Marking, Net, PlaceId};
use sides::Sides;

/// Largest size of the search for minimal sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SiphonLimits {
    /// The most partial sets that are looked at, each in time linear in the net. A set counts again for each place that
    /// joins it, and for each that is taken out to see whether it is minimal.
    pub sets: usize,
    /// The most bytes that partial sets and results may take.
    pub bytes: usize,
}

impl Default for SiphonLimits {
    /// Limits that take some seconds on a net of a hundred places.
    fn default() -> Self {
        SiphonLimits { sets: 500_000, bytes: 256 << 20 }
    }
}

/// The search did not come to an end: there may be more minimal sets.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("undecided after {sets} partial sets, with {found} minimal ones found: {cause}")]
pub struct SiphonsUndecided {
    /// The partial sets looked at.
    pub sets: usize,
    /// The minimal sets found until then.
    pub found: usize,
    /// Limit that stopped the search.
    pub cause: SiphonLimit,
}

/// Limit that stops a search for siphons or traps.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SiphonLimit {
    /// [`SiphonLimits::sets`].
    #[error("there are more to look at than allowed")]
    Sets,
    /// [`SiphonLimits::bytes`].
    #[error("they take more memory than allowed")]
    Bytes,
    /// The circuits of a marked graph are found as semiflows, and those were too many.
    #[error("{0}")]
    Semiflows(crate::semiflows::SemiflowsUndecided),
}

/// A siphon without a marked trap: it can run empty, in a free-choice net for certain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Uncontrolled {
    /// The siphon, minimal, in order.
    pub siphon: Vec<PlaceId>,
    /// The largest trap in it, which has no token; often there is none.
    pub trap: Vec<PlaceId>,
}

/// The union of all siphons within a set of places, in order.
pub fn largest_siphon_in(net: &Net, places: &[PlaceId]) -> Vec<PlaceId> {
    listed(&Sides::of_siphons(net).largest_in(members(net, places)))
}

/// The union of all traps within a set of places, in order.
pub fn largest_trap_in(net: &Net, places: &[PlaceId]) -> Vec<PlaceId> {
    listed(&Sides::of_traps(net).largest_in(members(net, places)))
}

/// The union of all siphons without a token: these places are empty for ever.
pub fn largest_empty_siphon(net: &Net, marking: &Marking) -> Vec<PlaceId> {
    let empty: Vec<PlaceId> = net.places().filter(|&place| marking.tokens(place) == 0).collect();
    largest_siphon_in(net, &empty)
}

/// All siphons, except the empty one, that contain no other; each in order, and the list too.
pub fn minimal_siphons(net: &Net, limits: &SiphonLimits) -> Result<Vec<Vec<PlaceId>>, SiphonsUndecided> {
    minimal(net, &Sides::of_siphons(net), limits)
}

/// All traps, except the empty one, that contain no other; each in order, and the list too.
pub fn minimal_traps(net: &Net, limits: &SiphonLimits) -> Result<Vec<Vec<PlaceId>>, SiphonsUndecided> {
    minimal(net, &Sides::of_traps(net), limits)
}

/// Commoner's condition: whether every siphon contains a trap that is marked initially. A place without arcs is a
/// siphon too, but no transition depends on it, so it does not count.
pub fn commoner(net: &Net, limits: &SiphonLimits) -> Result<Result<(), Uncontrolled>, SiphonsUndecided> {
    let initial = net.initial_marking();
    let traps = Sides::of_traps(net);
    for siphon in minimal_siphons(net, limits)? {
        let trap = listed(&traps.largest_in(members(net, &siphon)));
        let feeds = siphon.iter().any(|&place| !net.consumers(place).is_empty());
        if feeds && trap.iter().all(|&place| initial.tokens(place) == 0) {
            return Ok(Err(Uncontrolled { siphon, trap }));
        }
    }
    Ok(Ok(()))
}

fn minimal(net: &Net, sides: &Sides, limits: &SiphonLimits) -> Result<Vec<Vec<PlaceId>>, SiphonsUndecided> {
    if net.is_marked_graph().is_ok() {
        // Every place has one way in and one way out: minimal siphons and traps are both the elementary circuits, and
        // these are the minimal semiflows. That search does not have to guess.
        let within =
            crate::semiflows::SemiflowLimits { bytes: limits.bytes, ..crate::semiflows::SemiflowLimits::default() };
        let circuits = crate::semiflows::place_semiflows(net, &within).map_err(|error| SiphonsUndecided {
            sets: 0,
            found: 0,
            cause: SiphonLimit::Semiflows(error),
        })?;
        return Ok(circuits.all().iter().map(|circuit| circuit.support().collect()).collect());
    }
    let found = search::minimal(sides, limits)?;
    let mut found: Vec<Vec<PlaceId>> = found.iter().map(|set| listed(set)).collect();
    found.sort_unstable();
    Ok(found)
}

fn members(net: &Net, places: &[PlaceId]) -> Vec<bool> {
    let mut members = vec![false; net.place_count()];
    places.iter().for_each(|place| members[place.index()] = true);
    members
}

fn listed(members: &[bool]) -> Vec<PlaceId> {
    (0..).map(PlaceId).zip(members).filter(|&(_, &member)| member).map(|(place, _)| place).collect()
}
