//! The operation causality condition (seed 002 Definition 8), extended to counted cycles.
//!
//! Within a cycle an operation waits for the operations before it in its station and, through arrows of lag 0, for
//! operations of others. An arrow of lag 1 reaches into the cycle before, as does the step from a station's last
//! operation to its first. So a circle of waiting is a deadlock exactly when its lags add up to nothing, and all
//! modes' arrows count together, since the mode may change at any time.

use std::collections::{HashMap, HashSet, VecDeque};

use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::EdgeRef;

use linewright_text::{Problem, Report};

use crate::parse::draft::{DraftArrow, DraftLine};
use crate::{OpId, StationId};

/// Searching for the shortest circle of a knot starts from at most this many of its arrows.
const STARTS_MAX: usize = 64;

type ChartOperation = (StationId, OpId);
/// An edge is an arrow, by its number, or the order within a station.
type CausalEdge = DiGraph<ChartOperation, Option<usize>>;

pub(super) fn no_operation_waits_for_itself(draft: &DraftLine<'_>, report: &mut Report) {
    let graph = waits_within_a_cycle(draft);
    for knot in kosaraju_scc(&graph) {
        if knot.len() < 2 {
            continue;
        }
        let knot: HashSet<NodeIndex> = knot.into_iter().collect();
        if let Some(circle) = shortest_circle(&graph, &knot) {
            report.add(problem(draft, &circle));
        }
    }
}

/// Waits within the same cycle: an edge from each operation to those that need it.
fn waits_within_a_cycle(draft: &DraftLine<'_>) -> CausalEdge {
    let mut graph = CausalEdge::new();
    let mut nodes: HashMap<ChartOperation, NodeIndex> = HashMap::new();
    for (id, station) in draft.stations.iter().enumerate() {
        for op in station.op_ids() {
            let operation = (StationId::at(id), OpId::at(op));
            nodes.insert(operation, graph.add_node(operation));
        }
        for pair in station.steps.windows(2) {
            for (&before, &after) in pair[0].iter().flat_map(|b| pair[1].iter().map(move |a| (b, a))) {
                graph.add_edge(nodes[&(StationId::at(id), before)], nodes[&(StationId::at(id), after)], None);
            }
        }
    }
    for (number, arrow) in draft.arrows.iter().enumerate().filter(|(_, arrow)| arrow.lag == 0) {
        let (Some(from), Some(to)) = (&arrow.from, &arrow.to) else { continue };
        // An arrow within a station is another rule's business.
        if from.value.0 == to.value.0 {
            continue;
        }
        // Operations side by side start together, when the arrows into all of them hold.
        let (station, op) = to.value;
        let described = &draft.stations[station.index()];
        for &beside in &described.steps[described.step_of(op)] {
            graph.add_edge(nodes[&from.value], nodes[&(station, beside)], Some(number));
        }
    }
    graph
}

/// The arrows of a shortest circle inside `knot`, in order.
fn shortest_circle(graph: &CausalEdge, knot: &HashSet<NodeIndex>) -> Option<Vec<usize>> {
    let inside = |edge: &petgraph::graph::EdgeReference<'_, Option<usize>>| {
        edge.weight().is_some() && knot.contains(&edge.source()) && knot.contains(&edge.target())
    };
    graph
        .edge_references()
        .filter(inside)
        .take(STARTS_MAX)
        .filter_map(|edge| {
            let mut circle = vec![(*edge.weight())?];
            circle.extend(way(graph, knot, edge.target(), edge.source())?);
            Some(circle)
        })
        .min_by_key(Vec::len)
}

/// The arrows on a way from `start` to `goal` inside `knot`.
fn way(graph: &CausalEdge, knot: &HashSet<NodeIndex>, start: NodeIndex, goal: NodeIndex) -> Option<Vec<usize>> {
    let mut came_by: HashMap<NodeIndex, (NodeIndex, Option<usize>)> = HashMap::new();
    let mut queue = VecDeque::from([start]);
    while let Some(node) = queue.pop_front() {
        if node == goal {
            break;
        }
        for edge in graph.edges(node).filter(|edge| knot.contains(&edge.target())) {
            if edge.target() != start && !came_by.contains_key(&edge.target()) {
                came_by.insert(edge.target(), (node, *edge.weight()));
                queue.push_back(edge.target());
            }
        }
    }
    let mut arrows = Vec::new();
    let mut node = goal;
    while node != start {
        let &(before, arrow) = came_by.get(&node)?;
        arrows.extend(arrow);
        node = before;
    }
    arrows.reverse();
    Some(arrows)
}

fn problem(draft: &DraftLine<'_>, circle: &[usize]) -> Problem {
    let arrows: Vec<&DraftArrow> = circle.iter().map(|&number| &draft.arrows[number]).collect();
    let mut names: Vec<String> = Vec::new();
    for end in arrows.iter().flat_map(|arrow| [&arrow.from, &arrow.to]).flatten() {
        let name = draft.full_name(end.value);
        if names.last() != Some(&name) {
            names.push(name);
        }
    }
    // The circle closes where it began.
    if let Some(first) = names.first().cloned()
        && names.last() != Some(&first)
    {
        names.push(first);
    }
    let message = format!("a deadlock: each of these waits for the one before it: {}", names.join(" → "));
    let mut problem = Problem::error(arrows[0].at.clone(), message)
        .label("this arrow")
        .hint("one arrow of the circle may be meant to carry over from the previous cycle (lag = 1), or be too many");
    for arrow in &arrows[1..] {
        problem = problem.also(&arrow.at, "and this one");
    }
    problem
}
