//! The shortest makespan of a timed net, by Dijkstra's algorithm over markings and what is left of activities in progress.
//!
//! It plays the long form of the coloured net itself, with nothing of the table, the player or its orders; and without
//! bounds. A transition that takes time takes its tokens when it starts and gives them when it ends, and happens once at a
//! time (seed 000, proposition 15, L2385).

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use linewright_nets::Net;

/// Number of tokens on each place, and activities in progress: transition and its remaining time, sorted.
type Node = (Vec<u32>, Vec<(usize, u64)>);

/// The shortest time in which `done` is so, in the unit of `times`; none if it never is. What has no time does not happen.
pub fn shortest(net: &Net, start: Vec<u32>, times: &[Option<u64>], done: impl Fn(&[u32]) -> bool) -> Option<u64> {
    let mut best: HashMap<Node, u64> = HashMap::new();
    let mut open = BinaryHeap::from([Reverse((0, (start, Vec::new())))]);
    while let Some(Reverse((at, node))) = open.pop() {
        if best.get(&node).is_some_and(|&known| known < at) {
            continue;
        }
        let (marking, running) = &node;
        if running.is_empty() && done(marking) {
            return Some(at);
        }
        let mut visit = |at: u64, node: Node| {
            if best.get(&node).is_none_or(|&known| at < known) {
                best.insert(node.clone(), at);
                open.push(Reverse((at, node)));
            }
        };
        for t in net.transitions() {
            let Some(time) = times[t.index()] else { continue };
            let busy = running.iter().any(|&(other, _)| other == t.index());
            if busy || !net.preset(t).iter().all(|&(place, weight)| marking[place.index()] >= weight) {
                continue;
            }
            let (mut marking, mut running) = node.clone();
            net.preset(t).iter().for_each(|&(place, weight)| marking[place.index()] -= weight);
            if time == 0 {
                net.postset(t).iter().for_each(|&(place, weight)| marking[place.index()] += weight);
            } else {
                running.push((t.index(), time));
                running.sort_unstable();
            }
            visit(at, (marking, running));
        }
        if let Some(step) = running.iter().map(|&(_, left)| left).min() {
            let (mut marking, mut after) = (marking.clone(), Vec::new());
            for &(t, left) in running {
                if left > step {
                    after.push((t, left - step));
                    continue;
                }
                let t = net.transitions().nth(t).unwrap();
                net.postset(t).iter().for_each(|&(place, weight)| marking[place.index()] += weight);
            }
            visit(at + step, (marking, after));
        }
    }
    None
}

/// The least tardiness, in the unit of `times`: the sum over all tokens that come to a place with a due time of how much later
/// than that they come. By Dijkstra's algorithm again, with the time itself as part of a node.
pub fn least_tardiness(
    net: &Net,
    start: Vec<u32>,
    times: &[Option<u64>],
    due: &[Option<u64>],
    done: impl Fn(&[u32]) -> bool,
) -> Option<u64> {
    let mut best: HashMap<(u64, Node), u64> = HashMap::new();
    let mut open = BinaryHeap::from([Reverse((0, 0, (start, Vec::new())))]);
    while let Some(Reverse((cost, at, node))) = open.pop() {
        if best.get(&(at, node.clone())).is_some_and(|&known| known < cost) {
            continue;
        }
        let (marking, running) = &node;
        if running.is_empty() && done(marking) {
            return Some(cost);
        }
        let late = |place: usize, at: u64| due[place].map_or(0, |due| at.saturating_sub(due));
        let mut visit = |cost: u64, at: u64, node: Node| {
            let key = (at, node);
            if best.get(&key).is_none_or(|&known| cost < known) {
                best.insert(key.clone(), cost);
                open.push(Reverse((cost, at, key.1)));
            }
        };
        for t in net.transitions() {
            let busy = running.iter().any(|&(other, _)| other == t.index());
            // Nothing that is moved at once is due anywhere.
            let Some(time) = times[t.index()].filter(|&time| time > 0) else { continue };
            if busy || !net.preset(t).iter().all(|&(place, weight)| marking[place.index()] >= weight) {
                continue;
            }
            let (mut marking, mut running) = node.clone();
            net.preset(t).iter().for_each(|&(place, weight)| marking[place.index()] -= weight);
            running.push((t.index(), time));
            running.sort_unstable();
            visit(cost, at, (marking, running));
        }
        if let Some(step) = running.iter().map(|&(_, left)| left).min() {
            let (mut marking, mut after, mut cost) = (marking.clone(), Vec::new(), cost);
            for &(t, left) in running {
                if left > step {
                    after.push((t, left - step));
                    continue;
                }
                for &(place, weight) in net.postset(net.transitions().nth(t).unwrap()) {
                    marking[place.index()] += weight;
                    cost += u64::from(weight) * late(place.index(), at + step);
                }
            }
            visit(cost, at + step, (marking, after));
        }
    }
    None
}
