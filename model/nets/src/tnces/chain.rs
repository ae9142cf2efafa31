//! Transitions that a spontaneous one forces: all that event arcs lead to, sources before targets.
//!
//! Computed once, when the system is built. A forced transition is *contested* if it shares an input place with another
//! one of the same chain: only then can a step be completed in more than one way, and the number of ways is at most two
//! to the power of the contested.

use std::collections::HashMap;

use crate::{Net, PlaceId, TransitionId};

/// The forced transitions of one trigger.
#[derive(Clone, Debug, Default)]
pub(super) struct Chain {
    /// Sources before what they force: by the longest way of event arcs to each, then by number.
    pub(super) members: Box<[TransitionId]>,
    /// For each member, whether another one takes from one of its places.
    pub(super) contested: Box<[bool]>,
}

impl Chain {
    /// Follows `targets` from a trigger; `rank` numbers the transitions so that sources come first.
    pub(super) fn new(net: &Net, trigger: TransitionId, targets: &[Vec<TransitionId>], rank: &[usize]) -> Chain {
        let mut members: Vec<TransitionId> = Vec::new();
        let mut known = std::collections::HashSet::from([trigger]);
        let mut open = vec![trigger];
        while let Some(from) = open.pop() {
            for &to in &targets[from.index()] {
                if known.insert(to) {
                    members.push(to);
                    open.push(to);
                }
            }
        }
        members.sort_by_key(|t| rank[t.index()]);
        let mut takers: HashMap<PlaceId, usize> = HashMap::new();
        for (place, _) in members.iter().flat_map(|&t| net.preset(t)) {
            *takers.entry(*place).or_default() += 1;
        }
        let contested = |&t: &TransitionId| net.preset(t).iter().any(|(place, _)| takers[place] > 1);
        Chain { contested: members.iter().map(contested).collect(), members: members.into() }
    }

    pub(super) fn choices(&self) -> usize {
        self.contested.iter().filter(|&&contested| contested).count()
    }
}

/// Orders the transitions by the longest way of event arcs that leads to them, then by number, so that every event arc
/// leads onwards; or returns a cycle. The result is the position of each.
pub(super) fn rank(targets: &[Vec<TransitionId>]) -> Result<Vec<usize>, Vec<TransitionId>> {
    let mut waits = vec![0_usize; targets.len()];
    targets.iter().flatten().for_each(|to| waits[to.index()] += 1);
    let mut order: Vec<usize> = (0..targets.len()).filter(|&t| waits[t] == 0).collect();
    let mut depth = vec![0_usize; targets.len()];
    let mut next = 0;
    while next < order.len() {
        let from = order[next];
        for to in targets[from].iter().map(|to| to.index()) {
            depth[to] = depth[to].max(depth[from] + 1);
            waits[to] -= 1;
            if waits[to] == 0 {
                order.push(to);
            }
        }
        next += 1;
    }
    if order.len() < targets.len() {
        return Err(cycle(targets, &waits));
    }
    order.sort_by_key(|&t| (depth[t], t));
    let mut rank = vec![0; targets.len()];
    order.into_iter().enumerate().for_each(|(at, t)| rank[t] = at);
    Ok(rank)
}

/// A cycle among the transitions that still wait: each has a source that waits too, so walking back must repeat.
fn cycle(targets: &[Vec<TransitionId>], waits: &[usize]) -> Vec<TransitionId> {
    let mut source: Vec<Option<usize>> = vec![None; targets.len()];
    for (from, tos) in targets.iter().enumerate().filter(|&(from, _)| waits[from] > 0) {
        tos.iter().for_each(|to| source[to.index()] = Some(from));
    }
    let mut at = waits.iter().position(|&n| n > 0).expect("some transition waits");
    let mut seen_at = HashMap::new();
    let mut walk = Vec::new();
    while !seen_at.contains_key(&at) {
        seen_at.insert(at, walk.len());
        walk.push(at);
        at = source[at].expect("what waits has a source that waits");
    }
    // Walked against the arcs; start with the smallest, so that the message is the same however the arcs are ordered.
    let mut cycle: Vec<_> = walk.split_off(seen_at[&at]);
    cycle.reverse();
    let smallest = cycle.iter().enumerate().min_by_key(|&(_, t)| t).map_or(0, |(at, _)| at);
    cycle.rotate_left(smallest);
    cycle.into_iter().map(|t| TransitionId(t as u32)).collect()
}
