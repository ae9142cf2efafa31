//! Verdicts on marked graphs: exact for every one of them, connected or not, live or not; of very large ones that are
//! not safe, [`bounds`] may leave some bounds open.
//!
//! A marked graph is a directed graph with transitions as nodes and places as edges, each with its tokens. Firing keeps
//! the tokens of every circuit (Commoner, Holt, Even and Pnueli, *Marked directed graphs*, 1971; Murata 1989, §VI), and
//! more generally the tokens on a path from u to v limit how often v can fire before u fires:
//! - a transition on an empty circuit never fires, and what can be reached from there fires finitely often;
//! - everything else fires for ever: by itself it is a live marked graph;
//! - the most tokens on a place from t to t′ are its own and those on the lightest path to t from t′, or from a
//!   transition that never fires. The lightest circuit through the place is that for a live net. Without such a path
//!   there is no bound.
//!
//! In each case the counts that reach the extreme are the lengths of the lightest paths, and they can be played.

mod bounds;

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use bounds::Effort;

use super::evidence::{Dead, Evidence, FiringOrder, NetProperty, NoReturn, RepeatedFiring, UnboundedCycle};
use super::play::play;
use super::{CertificateAnswer, NetClass, StructuralVerdict, Unknown};
use crate::components::Components;
use crate::{Net, PlaceId, TransitionId};

struct WeightedGraph<'net> {
    net: &'net Net,
    /// Per place, the transition that gives to it, the one that takes from it, and its tokens.
    edges: Vec<(usize, usize, u64)>,
    /// The empty edges on empty circuits.
    siphon: Vec<PlaceId>,
    /// The transitions on empty circuits: those that never fire because of the siphon.
    never: Vec<bool>,
    /// The transitions that fire finitely often.
    stuck: Vec<bool>,
    /// All transitions, such that every empty edge leads forward, apart from those on empty circuits.
    order: Vec<TransitionId>,
}

/// The verdict on a marked graph; the caller has checked that it is one.
pub(super) fn decide(net: &Net) -> StructuralVerdict {
    let graph = WeightedGraph::new(net);
    let (bounds, bounded, safe) = graph.bounds(Effort::of(net));
    StructuralVerdict {
        class: NetClass::MarkedGraph,
        deadlock_free: graph.deadlock_free(),
        live: graph.live(),
        bounded,
        safe,
        reversible: graph.reversible(),
        bounds,
    }
}

impl<'net> WeightedGraph<'net> {
    fn new(net: &'net Net) -> Self {
        let initial = net.initial_marking();
        let end = |arcs: &[(TransitionId, u32)]| arcs[0].0.index();
        let edges: Vec<(usize, usize, u64)> =
            net.places().map(|p| (end(net.producers(p)), end(net.consumers(p)), initial.tokens(p).into())).collect();
        let empty = edges.iter().filter(|edge| edge.2 == 0).map(|&(from, to, _)| (from, to));
        let parts = Components::new(net.transition_count(), empty);
        let on_circuit = |&(from, to, tokens): &(usize, usize, u64)| tokens == 0 && parts.of(from) == parts.of(to);
        let siphon: Vec<PlaceId> = net.places().filter(|p| on_circuit(&edges[p.index()])).collect();
        let mut never = vec![false; net.transition_count()];
        siphon.iter().for_each(|p| never[edges[p.index()].1] = true);
        let mut order: Vec<TransitionId> = net.transitions().collect();
        // Components come with successors first.
        order.sort_by_key(|t| Reverse(parts.of(t.index())));
        let mut graph = WeightedGraph { net, edges, siphon, stuck: never.clone(), never, order };
        let mut ahead: Vec<usize> = (0..graph.stuck.len()).filter(|&t| graph.stuck[t]).collect();
        while let Some(t) = ahead.pop() {
            for &(place, _) in net.postset(TransitionId(t as u32)) {
                let to = graph.edges[place.index()].1;
                if !std::mem::replace(&mut graph.stuck[to], true) {
                    ahead.push(to);
                }
            }
        }
        graph
    }

    fn order_of(&self, wanted: impl Fn(usize) -> bool) -> Evidence {
        Evidence::Order(FiringOrder { transitions: self.order.iter().copied().filter(|t| wanted(t.index())).collect() })
    }

    fn live(&self) -> CertificateAnswer {
        match self.net.transitions().find(|t| self.never[t.index()]) {
            None => CertificateAnswer::yes(NetProperty::Live, self.order_of(|_| true)),
            Some(transition) => {
                let dead = Dead { run: Vec::new(), siphon: self.siphon.clone(), transition };
                CertificateAnswer::no(NetProperty::Live, Evidence::Dead(dead))
            }
        }
    }

    fn deadlock_free(&self) -> CertificateAnswer {
        if self.stuck.contains(&false) {
            return CertificateAnswer::yes(NetProperty::DeadlockFree, self.order_of(|t| !self.stuck[t]));
        }
        let sources = (0..self.never.len()).filter(|&t| self.never[t]);
        let (counts, _) = self.lightest(sources, None);
        // Every transition is behind one that never fires, so there is a path to each.
        let counts: Vec<u64> = counts.into_iter().map(|count| count.unwrap_or(0)).collect();
        match play(self.net, counts) {
            Some(run) => CertificateAnswer::no(NetProperty::DeadlockFree, Evidence::Deadlock(run)),
            None => CertificateAnswer::Unknown(Unknown::TooLong),
        }
    }

    /// The pieces that do not hang together are judged one by one.
    fn reversible(&self) -> CertificateAnswer {
        let both_ways = self.edges.iter().flat_map(|&(from, to, _)| [(from, to), (to, from)]);
        let pieces = Components::new(self.net.transition_count(), both_ways);
        let mut halts = vec![false; pieces.count()];
        (0..self.never.len()).filter(|&t| self.never[t]).for_each(|t| halts[pieces.of(t)] = true);
        let initial = self.net.initial_marking();
        match self.net.enabled(&initial).find(|t| halts[pieces.of(t.index())]) {
            None => CertificateAnswer::yes(NetProperty::Reversible, self.order_of(|t| !halts[pieces.of(t)])),
            Some(t) => CertificateAnswer::no(NetProperty::Reversible, Evidence::NoReturn(self.no_return(t))),
        }
    }

    /// Along a chain of places from an enabled transition to one that never fires, signs can be chosen such that only
    /// the enabled one changes the sum: it counts how often that one has fired.
    fn no_return(&self, transition: TransitionId) -> NoReturn {
        let mut found_by: Vec<Option<(usize, PlaceId)>> = vec![None; self.never.len()];
        let mut ahead = VecDeque::from([transition.index()]);
        let mut end = transition.index();
        while let Some(t) = ahead.pop_front() {
            if self.never[t] {
                end = t;
                break;
            }
            let id = TransitionId(t as u32);
            for &(place, _) in self.net.preset(id).iter().chain(self.net.postset(id)) {
                let (from, to, _) = self.edges[place.index()];
                let other = if from == t { to } else { from };
                if other != transition.index() && found_by[other].is_none() {
                    found_by[other] = Some((t, place));
                    ahead.push_back(other);
                }
            }
        }
        let mut chain = Vec::new();
        while let Some((before, place)) = found_by[end] {
            chain.push((before, place));
            end = before;
        }
        // The first place counts the firings of the transition up; each next one makes up for the one before.
        let mut weights: Vec<(PlaceId, i64)> = Vec::new();
        let mut owed = 1;
        for &(t, place) in chain.iter().rev() {
            let gives = self.edges[place.index()].0 == t;
            let weight = if gives { owed } else { -owed };
            weights.push((place, weight));
            // What the place does to the sum when the transition at its other end fires has to be undone there.
            owed = weight * if gives { 1 } else { -1 };
        }
        weights.sort_unstable();
        NoReturn { run: vec![RepeatedFiring { transition, times: 1 }], dead: self.siphon.clone(), weights }
    }

    /// The lightest paths from some transitions: per transition its length, and the last place of the path. Ends early
    /// when `goal` is reached.
    fn lightest(
        &self,
        sources: impl Iterator<Item = usize>,
        goal: Option<usize>,
    ) -> (Vec<Option<u64>>, Vec<Option<PlaceId>>) {
        let mut lengths: Vec<Option<u64>> = vec![None; self.never.len()];
        let mut last: Vec<Option<PlaceId>> = vec![None; self.never.len()];
        let mut heap = BinaryHeap::new();
        for source in sources {
            lengths[source] = Some(0);
            heap.push((Reverse(0), source));
        }
        while let Some((Reverse(length), t)) = heap.pop() {
            if Some(t) == goal {
                break;
            }
            if lengths[t] != Some(length) {
                continue;
            }
            for &(place, _) in self.net.postset(TransitionId(t as u32)) {
                let (_, to, tokens) = self.edges[place.index()];
                // 32 bits of tokens on each of 24 bits of places.
                let further = length + tokens;
                if lengths[to].is_none_or(|known| further < known) {
                    lengths[to] = Some(further);
                    last[to] = Some(place);
                    heap.push((Reverse(further), to));
                }
            }
        }
        (lengths, last)
    }

    /// The lightest path that limits a place, with the place itself, in order; and the most tokens of the place.
    fn heaviest(&self, place: PlaceId) -> Option<(Vec<PlaceId>, u64)> {
        let (from, to, tokens) = self.edges[place.index()];
        let (lengths, last) = self.lightest(self.limiting(to), Some(from));
        let bound = tokens + lengths[from]?;
        let mut path = vec![place];
        let mut at = from;
        while let Some(before) = last[at] {
            path.push(before);
            at = self.edges[before.index()].0;
        }
        path.sort_unstable();
        Some((path, bound))
    }

    /// The transitions before which others can fire only so often: one that does not fire, and those that never do.
    fn limiting(&self, waits: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.never.len()).filter(move |&t| t == waits || self.never[t])
    }

    /// The fewest firings that bring two tokens to a place whose bound allows it.
    fn two_on(&self, place: PlaceId) -> Option<Vec<RepeatedFiring>> {
        let (from, _, tokens) = self.edges[place.index()];
        let mut counts = vec![0; self.never.len()];
        counts[from] = 2_u64.saturating_sub(tokens);
        let mut ahead = vec![from];
        while let Some(t) = ahead.pop() {
            for &(input, _) in self.net.preset(TransitionId(t as u32)) {
                let (before, _, tokens) = self.edges[input.index()];
                let needs = counts[t].saturating_sub(tokens);
                if needs > counts[before] {
                    counts[before] = needs;
                    ahead.push(before);
                }
            }
        }
        play(self.net, counts)
    }

    /// Everything that can fire any number of times before the consumer of the place does, once each.
    fn pump(&self, place: PlaceId) -> CertificateAnswer {
        let (lengths, _) = self.lightest(self.limiting(self.edges[place.index()].1), None);
        let counts = lengths.iter().map(|length| u64::from(length.is_none())).collect();
        match play(self.net, counts) {
            Some(cycle) => CertificateAnswer::no(
                NetProperty::Bounded,
                Evidence::Pump(UnboundedCycle { prefix: Vec::new(), cycle, place }),
            ),
            None => CertificateAnswer::Unknown(Unknown::TooLong),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NetBuilder;

    #[test]
    fn the_lightest_path_counts_tokens_not_places() {
        let mut b = NetBuilder::new("n");
        let [t, u] = ["t", "u"].map(|name| b.transition(name));
        for (name, tokens) in [("short", 5), ("back", 1), ("other", 2)] {
            let place = b.place(name, tokens);
            let (from, to) = if name == "back" { (u, t) } else { (t, u) };
            b.output(from, place, 1).input(to, place, 1);
        }
        let net = b.build().unwrap();
        let graph = WeightedGraph::new(&net);
        let (path, bound) = graph.heaviest(net.place_named("back").unwrap()).unwrap();
        assert_eq!((path, bound), (vec![PlaceId(1), PlaceId(2)], 3));
    }
}
