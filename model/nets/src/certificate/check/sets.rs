//! Sets and weightings of places: whether they are known to the net, stay empty, stay marked, or change.

use std::collections::BTreeMap;

use super::replay::ReplayTokens;
use super::{CertificateRule, Rejected, require};
use crate::{Net, PlaceId, TransitionId};

pub(super) fn known_place(net: &Net, place: PlaceId) -> Result<(), Rejected> {
    require(place.index() < net.place_count(), CertificateRule::Known)
}

pub(super) fn known_transition(net: &Net, transition: TransitionId) -> Result<(), Rejected> {
    require(transition.index() < net.transition_count(), CertificateRule::Known)
}

/// All of these are places of the net, and none is there twice; which they are, by place.
pub(super) fn known(net: &Net, places: impl Iterator<Item = PlaceId>) -> Result<Vec<bool>, Rejected> {
    let mut members = vec![false; net.place_count()];
    for place in places {
        known_place(net, place)?;
        require(!std::mem::replace(&mut members[place.index()], true), CertificateRule::Once)?;
    }
    Ok(members)
}

fn touches(arcs: &[(PlaceId, u32)], members: &[bool]) -> bool {
    arcs.iter().any(|&(place, _)| members[place.index()])
}

pub(super) fn siphon(net: &Net, places: &[PlaceId]) -> Result<(), Rejected> {
    let members = known(net, places.iter().copied())?;
    let leaks = |&t: &TransitionId| touches(net.postset(t), &members) && !touches(net.preset(t), &members);
    net.transitions().find(leaks).map_or(Ok(()), |t| Err(Rejected::at(CertificateRule::Siphon, net, t)))
}

pub(super) fn trap(net: &Net, places: &[PlaceId]) -> Result<(), Rejected> {
    let members = known(net, places.iter().copied())?;
    let leaks = |&t: &TransitionId| touches(net.preset(t), &members) && !touches(net.postset(t), &members);
    net.transitions().find(leaks).map_or(Ok(()), |t| Err(Rejected::at(CertificateRule::Trap, net, t)))
}

pub(super) fn empty(net: &Net, places: &[PlaceId], tokens: &ReplayTokens) -> Result<(), Rejected> {
    let marked = places.iter().find(|&&place| tokens.on(place) > 0);
    marked.map_or(Ok(()), |&place| Err(Rejected::at(CertificateRule::Empty, net, place)))
}

/// Whether no siphon is without a token initially: taking out of the empty places what can get a token from outside
/// them leaves none.
pub(super) fn no_empty_siphon(net: &Net) -> bool {
    nothing_stays_empty(net, |t| (net.preset(t), net.postset(t)))
}

/// Whether no trap is without a token initially.
pub(super) fn no_empty_trap(net: &Net) -> bool {
    nothing_stays_empty(net, |t| (net.postset(t), net.preset(t)))
}

type Arcs<'net> = &'net [(PlaceId, u32)];

fn nothing_stays_empty<'net>(net: &'net Net, sides: impl Fn(TransitionId) -> (Arcs<'net>, Arcs<'net>)) -> bool {
    let initial = net.initial_marking();
    let mut left: Vec<bool> = net.places().map(|place| initial.tokens(place) == 0).collect();
    loop {
        let mut changed = false;
        for t in net.transitions() {
            let (inputs, outputs) = sides(t);
            if !touches(inputs, &left) && touches(outputs, &left) {
                outputs.iter().for_each(|&(place, _)| left[place.index()] = false);
                changed = true;
            }
        }
        if !changed {
            return !left.contains(&true);
        }
    }
}

/// Effect of each transition on a weighted sum, without those that have none.
pub(super) fn changes(net: &Net, weights: &[(PlaceId, i128)]) -> Result<BTreeMap<TransitionId, i128>, Rejected> {
    let mut changes = BTreeMap::new();
    for &(place, weight) in weights {
        let gives = net.producers(place).iter().map(|&(t, arc)| (t, i128::from(arc)));
        let takes = net.consumers(place).iter().map(|&(t, arc)| (t, -i128::from(arc)));
        for (t, arc) in gives.chain(takes) {
            let change = changes.entry(t).or_insert(0_i128);
            let sum = weight.checked_mul(arc).and_then(|term| change.checked_add(term));
            *change = sum.ok_or(Rejected::rule(CertificateRule::Size))?;
        }
    }
    changes.retain(|_, change| *change != 0);
    Ok(changes)
}
