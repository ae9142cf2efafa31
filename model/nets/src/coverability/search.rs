//! The construction of the graph, breadth first.

use std::collections::HashMap;

use super::label::{MarkingLabel, OMEGA};
use super::{Coverability, CoverabilityLimit, CoverabilityLimits, CoverabilityUndecided, GrowthWitness};
use crate::{Net, TransitionId, semiflows};

/// Finds a finite set of generalised markings that covers exactly what the reachable markings cover.
///
/// Correctness: every label is approached by reachable markings, because ω is only written where a sequence that can be
/// repeated adds tokens. And every reachable marking is covered: if M is covered by a label and M fires t, then so does
/// the label, or another one that is above it and was expanded in its place.
pub fn coverability(net: &Net, limits: &CoverabilityLimits) -> Result<Coverability, CoverabilityUndecided> {
    let initial = net.initial_marking();
    if let Some(full) = net.places().find(|&place| initial.tokens(place) == OMEGA) {
        return Err(CoverabilityUndecided { labels: 0, cause: CoverabilityLimit::TooMany(net.place(full)) });
    }
    let mut graph = CoverabilityGraph::new(net, *limits);
    graph.add(MarkingLabel::of(&initial), None)?;
    let mut fires = vec![false; net.transition_count()];
    let mut next = 0;
    while next < graph.nodes.len() {
        for t in net.transitions() {
            if !graph.labels[next].enables(net, t) {
                continue;
            }
            fires[t.index()] = true;
            let overflow =
                |error| CoverabilityUndecided { labels: graph.labels.len(), cause: CoverabilityLimit::Overflow(error) };
            let fired = graph.labels[next].fired(net, t).map_err(overflow)?;
            if graph.number_of.contains_key(&fired) {
                continue;
            }
            let label = if graph.may_grow { graph.accelerated(fired, next, t) } else { fired };
            graph.check_comparisons()?;
            if !graph.number_of.contains_key(&label) && !graph.below_omega(&label) {
                graph.add(label, Some((next, t)))?;
            }
        }
        next += 1;
    }
    let most = |place: usize| graph.labels.iter().map(|label| label.0[place]).max().filter(|&most| most != OMEGA);
    let bounds = (0..net.place_count()).map(most).collect();
    let dead = net.transitions().filter(|t| !fires[t.index()]).collect();
    Ok(Coverability { labels: graph.labels, bounds, dead, pump: graph.pump })
}

struct CoverabilityNode {
    /// The label this one was first found from, and by which transition.
    from: Option<(usize, TransitionId)>,
    weight: (usize, u64),
}

struct CoverabilityGraph {
    limits: CoverabilityLimits,
    labels: Vec<MarkingLabel>,
    nodes: Vec<CoverabilityNode>,
    number_of: HashMap<MarkingLabel, usize>,
    /// The labels with ω that are below no other.
    tops: Vec<usize>,
    /// Whether some place is in no conserved sum.
    may_grow: bool,
    pump: Option<GrowthWitness>,
    comparisons: u64,
}

impl CoverabilityGraph {
    fn new(net: &Net, limits: CoverabilityLimits) -> CoverabilityGraph {
        // A quick look; a net that is not covered, or too large for it, is treated as one that may grow.
        let quick =
            semiflows::SemiflowLimits { rows: 10_000, combinations: 200_000, ..semiflows::SemiflowLimits::default() };
        let covered = semiflows::place_semiflows(net, &quick).is_ok_and(|flows| flows.uncovered(net).next().is_none());
        CoverabilityGraph {
            limits,
            labels: Vec::new(),
            nodes: Vec::new(),
            number_of: HashMap::new(),
            tops: Vec::new(),
            may_grow: !covered,
            pump: None,
            comparisons: 0,
        }
    }

    fn check_comparisons(&self) -> Result<(), CoverabilityUndecided> {
        if self.comparisons > self.limits.comparisons {
            return Err(CoverabilityUndecided { labels: self.labels.len(), cause: CoverabilityLimit::Comparisons });
        }
        Ok(())
    }

    fn add(&mut self, label: MarkingLabel, from: Option<(usize, TransitionId)>) -> Result<(), CoverabilityUndecided> {
        let number = self.labels.len();
        if number >= self.limits.labels {
            return Err(CoverabilityUndecided { labels: number, cause: CoverabilityLimit::Labels });
        }
        // The label, its copy as a key, and what surrounds them.
        let each =
            2 * (size_of_val(&*label.0) + size_of::<MarkingLabel>()) + size_of::<(CoverabilityNode, usize)>() * 2;
        if (number + 1).saturating_mul(each) > self.limits.bytes {
            return Err(CoverabilityUndecided { labels: number, cause: CoverabilityLimit::Bytes });
        }
        if label.has_omega() {
            self.comparisons += self.tops.len() as u64;
            let labels = &self.labels;
            self.tops.retain(|&top| !label.covers(&labels[top].0));
            self.tops.push(number);
        }
        self.nodes.push(CoverabilityNode { from, weight: label.weight() });
        self.labels.push(label.clone());
        self.number_of.insert(label, number);
        Ok(())
    }

    fn below_omega(&mut self, label: &MarkingLabel) -> bool {
        self.comparisons += self.tops.len() as u64;
        self.tops.iter().any(|&top| self.labels[top].covers(&label.0))
    }

    /// Writes ω wherever the label lies above one that led to it, until it lies above none strictly.
    fn accelerated(&mut self, mut label: MarkingLabel, parent: usize, by: TransitionId) -> MarkingLabel {
        loop {
            let weight = label.weight();
            let mut changed = false;
            let mut at = Some(parent);
            while let Some(number) = at {
                self.comparisons += 1;
                let ancestor = &self.nodes[number];
                at = ancestor.from.map(|(from, _)| from);
                // A label strictly above has more ω, or as many and more tokens.
                let possible = weight.0 > ancestor.weight.0 || weight > ancestor.weight;
                if !possible || !label.covers(&self.labels[number].0) {
                    continue;
                }
                let grows = label.above(&self.labels[number]);
                if grows.iter().all(|place| label.0[place.index()] == OMEGA) {
                    continue;
                }
                if self.pump.is_none() {
                    // The first ω of all: everything before it is an ordinary marking, and the sequence can be played.
                    self.pump = Some(self.pump(number, parent, by, &grows));
                }
                grows.iter().for_each(|place| label.0[place.index()] = OMEGA);
                changed = true;
            }
            if !changed {
                return label;
            }
        }
    }

    fn path(&self, from: usize, to: usize) -> Vec<TransitionId> {
        let mut path = Vec::new();
        let mut at = to;
        while at != from {
            let Some((before, t)) = self.nodes[at].from else { break };
            path.push(t);
            at = before;
        }
        path.reverse();
        path
    }

    fn pump(&self, ancestor: usize, parent: usize, by: TransitionId, grows: &[crate::PlaceId]) -> GrowthWitness {
        let mut cycle = self.path(ancestor, parent);
        cycle.push(by);
        GrowthWitness { prefix: self.path(0, ancestor), cycle, grows: grows.to_vec() }
    }
}
