//! The conditions of the theorems that the evidence appeals to.

use super::replay::ReplayTokens;
use super::{CertificateRule, Rejected, rank, require, sets};
use crate::certificate::evidence::{Component, FiringOrder, WellFormed};
use crate::{Net, PlaceId, TransitionId};

/// Per transition, its position in the order, if it is listed.
fn positions(net: &Net, order: &FiringOrder) -> Result<Vec<Option<usize>>, Rejected> {
    let mut positions = vec![None; net.transition_count()];
    for (position, &t) in order.transitions.iter().enumerate() {
        sets::known_transition(net, t)?;
        require(positions[t.index()].replace(position).is_none(), CertificateRule::Once)?;
    }
    for &t in &order.transitions {
        for &(place, _) in net.preset(t) {
            let [(producer, 1)] = *net.producers(place) else {
                return Err(Rejected::at(CertificateRule::Closed, net, place));
            };
            let [(_, 1)] = *net.consumers(place) else { return Err(Rejected::at(CertificateRule::Closed, net, place)) };
            let Some(before) = positions[producer.index()] else {
                return Err(Rejected::at(CertificateRule::Closed, net, place));
            };
            let rises = positions[t.index()] > Some(before);
            if !rises && net.initial_marking().tokens(place) == 0 {
                return Err(Rejected::at(CertificateRule::Rising, net, place));
            }
        }
    }
    Ok(positions)
}

pub(super) fn live_order(net: &Net, order: &FiringOrder) -> Result<(), Rejected> {
    let positions = positions(net, order)?;
    require(positions.iter().all(Option::is_some), CertificateRule::AllTransitions)
}

pub(super) fn moving_order(net: &Net, order: &FiringOrder) -> Result<(), Rejected> {
    positions(net, order)?;
    require(!order.transitions.is_empty(), CertificateRule::NotEmpty)
}

pub(super) fn returning_order(net: &Net, order: &FiringOrder) -> Result<(), Rejected> {
    let positions = positions(net, order)?;
    let tokens = ReplayTokens::initial(net);
    for t in net.transitions() {
        if positions[t.index()].is_none() {
            require(!tokens.enables(net, t), CertificateRule::Still)?;
            continue;
        }
        for &(place, _) in net.postset(t) {
            let ([(_, 1)], [(consumer, 1)]) = (net.producers(place), net.consumers(place)) else {
                return Err(Rejected::at(CertificateRule::Closed, net, place));
            };
            require(positions[consumer.index()].is_some(), CertificateRule::Closed)?;
        }
    }
    Ok(())
}

/// Input and output place, if the transition is one of a state machine.
fn step(net: &Net, t: TransitionId) -> Result<(PlaceId, PlaceId), Rejected> {
    sets::known_transition(net, t)?;
    match (net.preset(t), net.postset(t)) {
        (&[(from, 1)], &[(to, 1)]) => Ok((from, to)),
        _ => Err(Rejected::at(CertificateRule::StateMachine, net, t)),
    }
}

/// For each component its places; the whole net is a state machine, and no component can be left.
fn components(net: &Net, parts: &[Component]) -> Result<Vec<Vec<PlaceId>>, Rejected> {
    net.transitions().try_for_each(|t| step(net, t).map(|_| ()))?;
    let mut covered = vec![false; net.place_count()];
    let mut found = Vec::with_capacity(parts.len());
    for part in parts {
        sets::known_place(net, part.root)?;
        let places = walked(net, part)?;
        for &place in &places {
            // Each place is in one part at most, which also keeps the work linear.
            require(!std::mem::replace(&mut covered[place.index()], true), CertificateRule::Once)?;
        }
        found.push(places);
    }
    Ok(found)
}

fn walked(net: &Net, part: &Component) -> Result<Vec<PlaceId>, Rejected> {
    let mut places = std::collections::BTreeSet::from([part.root]);
    for &t in &part.out {
        let (from, to) = step(net, t)?;
        require(places.contains(&from), CertificateRule::Connected)?;
        places.insert(to);
    }
    let mut home = std::collections::BTreeSet::from([part.root]);
    for &t in &part.back {
        let (from, to) = step(net, t)?;
        require(home.contains(&to), CertificateRule::Connected)?;
        home.insert(from);
    }
    for &place in &places {
        require(home.contains(&place), CertificateRule::Connected)?;
        for &(t, _) in net.consumers(place) {
            require(places.contains(&step(net, t)?.1), CertificateRule::Terminal)?;
        }
    }
    Ok(places.into_iter().collect())
}

pub(super) fn live_components(net: &Net, parts: &[Component]) -> Result<(), Rejected> {
    let (found, tokens) = (components(net, parts)?, ReplayTokens::initial(net));
    require(found.iter().all(|places| places.iter().any(|&place| tokens.on(place) > 0)), CertificateRule::Marked)?;
    let covered = sets::known(net, found.into_iter().flatten())?;
    for t in net.transitions() {
        require(covered[step(net, t)?.0.index()], CertificateRule::AllTransitions)?;
    }
    Ok(())
}

pub(super) fn moving_components(net: &Net, parts: &[Component]) -> Result<(), Rejected> {
    let (found, tokens) = (components(net, parts)?, ReplayTokens::initial(net));
    let moves = |places: &Vec<PlaceId>| {
        let marked = places.iter().any(|&place| tokens.on(place) > 0);
        marked && places.iter().any(|&place| !net.consumers(place).is_empty())
    };
    require(found.iter().any(moves), CertificateRule::Marked)
}

pub(super) fn returning_components(net: &Net, parts: &[Component]) -> Result<(), Rejected> {
    let covered = sets::known(net, components(net, parts)?.into_iter().flatten())?;
    let tokens = ReplayTokens::initial(net);
    let lost = net.places().find(|&place| tokens.on(place) > 0 && !covered[place.index()]);
    lost.map_or(Ok(()), |place| Err(Rejected::at(CertificateRule::AllTokens, net, place)))
}

pub(super) fn moving_trap(net: &Net, trap: &[PlaceId]) -> Result<(), Rejected> {
    sets::trap(net, trap)?;
    let tokens = ReplayTokens::initial(net);
    require(trap.iter().any(|&place| tokens.on(place) > 0), CertificateRule::Marked)?;
    for &place in trap {
        let free = net.consumers(place).iter().any(|&(t, _)| *net.preset(t) == [(place, 1)]);
        require(free, CertificateRule::Free)?;
    }
    Ok(())
}

/// All conditions of the rank theorem for a live and bounded free-choice net.
pub(super) fn well_formed(net: &Net, formed: &WellFormed) -> Result<(), Rejected> {
    for t in net.transitions() {
        require(net.preset(t).iter().chain(net.postset(t)).all(|&(_, weight)| weight == 1), CertificateRule::Ordinary)?;
    }
    for place in net.places() {
        let mut presets = net.consumers(place).iter().map(|&(t, _)| net.preset(t));
        let first = presets.next();
        if presets.any(|preset| Some(preset) != first) {
            return Err(Rejected::at(CertificateRule::FreeChoice, net, place));
        }
    }
    let all_arcs = |t: TransitionId| [net.preset(t), net.postset(t)].concat();
    let places_and_transitions = net.place_count() > 0 && net.transition_count() > 0;
    require(places_and_transitions && pieces(net, all_arcs) == 1, CertificateRule::OnePiece)?;
    invariants(net, formed)?;

    let clusters = pieces(net, |t| net.preset(t).to_vec());
    let columns = net.transitions().map(|t| {
        let gives = net.postset(t).iter().map(|&(place, _)| (place, 1));
        let takes = net.preset(t).iter().map(|&(place, _)| (place, -1));
        let mut column: std::collections::BTreeMap<u32, i64> = std::collections::BTreeMap::new();
        gives.chain(takes).for_each(|(place, change)| *column.entry(place.0).or_insert(0) += change);
        column.into_iter().collect()
    });
    require(rank::rank(columns) + 1 >= clusters, CertificateRule::Rank)?;
    let flows = formed.flows.iter().map(|flow| flow.iter().map(|&(t, count)| (t.0, count)).collect());
    require(rank::rank(flows) + clusters > net.transition_count(), CertificateRule::Rank)?;
    require(sets::no_empty_siphon(net), CertificateRule::Marked)
}

fn invariants(net: &Net, formed: &WellFormed) -> Result<(), Rejected> {
    let WellFormed { conserved, repeated, flows } = formed;
    require(
        conserved.len() == net.place_count() && repeated.len() == net.transition_count(),
        CertificateRule::Positive,
    )?;
    require(conserved.iter().chain(repeated).all(|&weight| weight > 0), CertificateRule::Positive)?;
    let weights: Vec<(PlaceId, i128)> = net.places().zip(conserved.iter().map(|&weight| weight.into())).collect();
    require(sets::changes(net, &weights)?.is_empty(), CertificateRule::Conserved)?;
    let counts: Vec<(TransitionId, i128)> = net.transitions().zip(repeated.iter().map(|&count| count.into())).collect();
    leads_back(net, &counts)?;
    for flow in flows {
        let mut listed = vec![false; net.transition_count()];
        for &(t, _) in flow {
            sets::known_transition(net, t)?;
            require(!std::mem::replace(&mut listed[t.index()], true), CertificateRule::Once)?;
        }
        leads_back(net, &flow.iter().map(|&(t, count)| (t, count.into())).collect::<Vec<_>>())?;
    }
    Ok(())
}

fn leads_back(net: &Net, counts: &[(TransitionId, i128)]) -> Result<(), Rejected> {
    let mut changes = std::collections::BTreeMap::new();
    for &(t, count) in counts {
        let gives = net.postset(t).iter().map(|&(place, weight)| (place, i128::from(weight)));
        let takes = net.preset(t).iter().map(|&(place, weight)| (place, -i128::from(weight)));
        for (place, arc) in gives.chain(takes) {
            // 64 bits of count, 32 of weight, and 24 of transitions, since none is listed twice.
            *changes.entry(place).or_insert(0_i128) += count * arc;
        }
    }
    require(changes.values().all(|&change| change == 0), CertificateRule::LeadsBack)
}

/// Into how many pieces the nodes fall when each transition is joined to these places.
fn pieces(net: &Net, joined: impl Fn(TransitionId) -> Vec<(PlaceId, u32)>) -> usize {
    let places = net.place_count();
    let mut leader: Vec<usize> = (0..places + net.transition_count()).collect();
    fn find(leader: &mut [usize], mut node: usize) -> usize {
        while leader[node] != node {
            leader[node] = leader[leader[node]];
            node = leader[node];
        }
        node
    }
    for t in net.transitions() {
        for (place, _) in joined(t) {
            let (a, b) = (find(&mut leader, places + t.index()), find(&mut leader, place.index()));
            leader[a] = b;
        }
    }
    (0..leader.len()).filter(|&node| leader[node] == node).count()
}
