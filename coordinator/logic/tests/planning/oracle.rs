//! The shortest makespan of a timed net, by Dijkstra's algorithm over markings and what is left of activities in progress.
//!
//! It plays the long form of the coloured net itself, with nothing of the table, the player or its orders; and it knows
//! nothing of bounds. A transition that takes time takes its tokens when it starts and gives them when it ends, and happens
//! once at a time (seed 000, proposition 15, L2385).

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use linewright_nets::Net;

/// How many tokens are on each place, and what is in progress: transition and what is left of it, sorted.
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
