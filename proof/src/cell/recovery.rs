//! Whether what fails in a cell leads back, and loses nothing: of the net with error places, by its structure alone.
//!
//! - **Back.** Every transition out of an error place takes one token, from there and from nowhere else. So it waits
//!   for no other, and from every marking a few of them lead to one without a token on any error place: one of the
//!   normal net.
//! - **Nothing lost.** Whatever sum of tokens the normal net conserves, failures and recoveries conserve, where an activity
//!   that has failed counts as much as one in progress. So no capacity, no admission and no reservation is lost by a recovery,
//!   and none is there twice.
//! - **Bounded.** Each place has a weight in a sum that is conserved and has no negative weights.

use std::collections::BTreeMap;

use linewright_cell::Cell;
use linewright_cell::net::Supply;
use linewright_coordinator_cell::compile::{OrderTiming, RecoveryNet, compile_cell, recovery_net};
use linewright_line::Line;
use linewright_nets::semiflows::{BasisFlow, SemiflowLimits, place_flow_basis, place_semiflows};
use linewright_nets::{Net, NetBuilder, PlaceId, TransitionId};

use super::{CellProperty, Verdict};

/// Name of the property.
pub const BACK: &str = "what fails leads back to the normal net";
/// Name of the property.
pub const KEPT: &str = "no failure and no recovery loses a token";
/// Name of the property.
pub const BOUNDED: &str = "with what fails the net is bounded";

/// Properties by the structure of a cell's net with error places; none of a cell that is not played.
pub fn check_recovery(cell: &Cell, line: Option<&Line>) -> Vec<CellProperty> {
    let pace =
        OrderTiming { repeat_interval: std::time::Duration::from_secs(1), grace: std::time::Duration::from_secs(1) };
    let Ok(made) = compile_cell(cell, line, Supply::Open, pace) else { return Vec::new() };
    match recovery_net(&cell.name, &made.table) {
        Ok(net) => judge(&net),
        Err(why) => {
            let reason = why.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
            vec![property(BACK, Verdict::Undecided, reason)]
        }
    }
}

fn property(name: &'static str, verdict: Verdict, reason: String) -> CellProperty {
    CellProperty { name, verdict, reason, help: None, counterexample: None }
}

/// The same of any such net.
pub fn judge(net: &RecoveryNet) -> Vec<CellProperty> {
    vec![leads_back(net), keeps(net), is_bounded(&net.net)]
}

fn error_places(net: &RecoveryNet) -> impl Iterator<Item = PlaceId> + '_ {
    net.errors.iter().flat_map(|part| [Some(part.failed), Some(part.asked), part.carried]).flatten()
}

fn leads_back(net: &RecoveryNet) -> CellProperty {
    let long = &net.net;
    // Distance of each error place from the normal net; `None` while unknown.
    let mut far: BTreeMap<PlaceId, Option<u32>> = error_places(net).map(|place| (place, None)).collect();
    for _ in 0..far.len() {
        for place in far.keys().copied().collect::<Vec<_>>() {
            let ways = long.consumers(place).iter().filter(|(t, _)| long.preset(*t) == [(place, 1)]);
            let leads = ways.filter_map(|&(t, _)| {
                let next = long.postset(t).iter().map(|(to, _)| far.get(to).copied().unwrap_or(Some(0)));
                next.collect::<Option<Vec<u32>>>().map(|next| 1 + next.into_iter().max().unwrap_or(0))
            });
            let least = leads.min();
            far.insert(place, least);
        }
    }
    let waits = |place: &PlaceId| {
        let blocked = long.consumers(*place).iter().any(|(t, _)| long.preset(*t) != [(*place, 1)]);
        blocked || far[place].is_none()
    };
    match far.keys().find(|place| waits(place)) {
        Some(&place) => property(BACK, Verdict::Fails, format!("not from `{}`", long.place_name(place))),
        None => {
            let most = far.values().flatten().max().copied().unwrap_or(0);
            let reason = format!("from all {} error places, by at most {most} steps without waiting", far.len());
            property(BACK, Verdict::Holds, reason)
        }
    }
}

/// The net without failures, with the same places.
fn normal(net: &RecoveryNet) -> Option<Net> {
    let (long, errors) = (&net.net, error_places(net).collect::<std::collections::BTreeSet<_>>());
    let mut b = NetBuilder::new("normal");
    let initial = long.initial_marking();
    long.places().for_each(|place| _ = b.place(long.place_name(place), initial.tokens(place)));
    for t in long.transitions() {
        if long.preset(t).iter().chain(long.postset(t)).any(|(place, _)| errors.contains(place)) {
            continue;
        }
        let own = b.transition(long.transition_name(t));
        long.preset(t).iter().for_each(|&(place, n)| _ = b.input(own, place, n));
        long.postset(t).iter().for_each(|&(place, n)| _ = b.output(own, place, n));
    }
    b.build().ok()
}

fn keeps(net: &RecoveryNet) -> CellProperty {
    let long = &net.net;
    let basis = match normal(net).map(|normal| place_flow_basis(&normal)) {
        Some(Ok(basis)) => basis,
        Some(Err(why)) => return property(KEPT, Verdict::Undecided, why.to_string()),
        None => return property(KEPT, Verdict::Undecided, "the normal net has no form".to_owned()),
    };
    // A failed activity counts as one in progress.
    let mut stands_for: BTreeMap<PlaceId, PlaceId> = BTreeMap::new();
    for part in &net.errors {
        let all = [Some(part.failed), Some(part.asked), part.carried];
        stands_for.extend(all.into_iter().flatten().map(|place| (place, part.busy)));
    }
    let is_normal = |flow: &&BasisFlow<PlaceId>| flow.entries.iter().all(|(place, _)| !stands_for.contains_key(place));
    let flows: Vec<BTreeMap<PlaceId, i64>> =
        basis.iter().filter(is_normal).map(|flow| flow.entries.iter().copied().collect()).collect();
    let weight = |flow: &BTreeMap<PlaceId, i64>, place: PlaceId| {
        flow.get(stands_for.get(&place).unwrap_or(&place)).copied().unwrap_or(0)
    };
    let sum = |flow: &BTreeMap<PlaceId, i64>, arcs: &[(PlaceId, u32)]| -> i64 {
        arcs.iter().map(|&(place, n)| weight(flow, place) * i64::from(n)).sum()
    };
    let is_kept = |t: &TransitionId| flows.iter().all(|flow| sum(flow, long.preset(*t)) == sum(flow, long.postset(*t)));
    match long.transitions().find(|t| !is_kept(t)) {
        Some(t) => {
            let reason = format!("`{}` changes what the normal net conserves", long.transition_name(t));
            property(KEPT, Verdict::Fails, reason)
        }
        None => {
            let reason = format!("all {} sums that the normal net conserves are conserved", flows.len());
            property(KEPT, Verdict::Holds, reason)
        }
    }
}

fn is_bounded(net: &Net) -> CellProperty {
    match place_semiflows(net, &SemiflowLimits::default()) {
        Ok(flows) => match flows.uncovered(net).next() {
            None => {
                let reason = format!("all {} places, by {} sums", net.place_count(), flows.all().len());
                property(BOUNDED, Verdict::Holds, reason)
            }
            Some(place) => property(BOUNDED, Verdict::Fails, format!("no sum bounds `{}`", net.place_name(place))),
        },
        Err(why) => property(BOUNDED, Verdict::Undecided, why.to_string()),
    }
}
