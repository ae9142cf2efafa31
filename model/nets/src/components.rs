//! Strongly connected components, in the one form that this crate needs.
//!
//! Liveness and reversibility are the same question for a graph of places and for a graph of markings: which parts can
//! be left for good? A component with no edge out is *terminal*: whatever enters it stays.

use petgraph::algo::kosaraju_scc;
use petgraph::graph::DiGraph;

/// The strongly connected components of a graph whose nodes are numbered from zero.
pub(crate) struct Components {
    /// The nodes of each component, ascending. Successors come before predecessors, so the first one is terminal.
    members: Vec<Vec<usize>>,
    of: Vec<usize>,
    terminal: Vec<bool>,
}

impl Components {
    /// `nodes` nodes, joined by `edges`.
    pub(crate) fn new(nodes: usize, edges: impl Iterator<Item = (usize, usize)> + Clone) -> Self {
        let mut graph: DiGraph<(), (), usize> = DiGraph::with_capacity(nodes, edges.size_hint().0);
        for _ in 0..nodes {
            graph.add_node(());
        }
        for (from, to) in edges.clone() {
            graph.add_edge(from.into(), to.into(), ());
        }
        // Kosaraju and not Tarjan: petgraph's Tarjan recurses, and a ring of a million markings would end the stack.
        let mut members: Vec<Vec<usize>> =
            kosaraju_scc(&graph).into_iter().map(|scc| scc.into_iter().map(|node| node.index()).collect()).collect();
        let mut of = vec![0; nodes];
        for (component, nodes) in members.iter_mut().enumerate() {
            nodes.sort_unstable();
            nodes.iter().for_each(|&node| of[node] = component);
        }
        let mut terminal = vec![true; members.len()];
        edges.filter(|&(from, to)| of[from] != of[to]).for_each(|(from, _)| terminal[of[from]] = false);
        Components { members, of, terminal }
    }

    pub(crate) fn count(&self) -> usize {
        self.members.len()
    }

    pub(crate) fn of(&self, node: usize) -> usize {
        self.of[node]
    }

    /// The nodes of a component, ascending.
    pub(crate) fn members(&self, component: usize) -> &[usize] {
        &self.members[component]
    }

    /// Whether no edge leaves the component.
    pub(crate) fn is_terminal(&self, component: usize) -> bool {
        self.terminal[component]
    }

    /// All terminal components.
    pub(crate) fn terminal(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.count()).filter(|&component| self.terminal[component])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn successors_come_first_and_only_the_ends_are_terminal() {
        // 0 ⇄ 1 → 2 ⇄ 3, 1 → 4
        let edges = [(0, 1), (1, 0), (1, 2), (2, 3), (3, 2), (1, 4)];
        let found = Components::new(5, edges.into_iter());
        assert_eq!(found.count(), 3);
        assert_eq!(found.members(found.of(3)), [2, 3]);
        let terminal: Vec<_> = found.terminal().map(|component| found.members(component)[0]).collect();
        assert!(terminal == [2, 4] || terminal == [4, 2]);
        assert_eq!(found.members(2), [0, 1]);
    }

    #[test]
    fn a_long_path_does_not_exhaust_the_stack() {
        let n = 300_000;
        assert_eq!(Components::new(n, (1..n).map(|node| (node - 1, node))).count(), n);
    }
}
