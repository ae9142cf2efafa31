//! The shape of a state graph: states left for good, and loops.
//!
//! "One of the most important requirements it must fulfill is that the representation has to constitute a closed-loop"
//! (seed 003 §5.1.1, L877): some states of start-up, then cycles (L884-892).

use std::collections::HashMap;

use super::StateGraph;
use super::graph::GraphArc;
use crate::components::Components;
use crate::reach::StateId;

/// States that lead to one another, for ever if the system stays among them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StateLoop {
    /// The states. If it is one cycle: in its order, beginning with the lowest number, which is where the shortest way
    /// from the initial state enters. Otherwise by number.
    pub states: Vec<StateId>,
    /// Time of one round, if it is one cycle: each state leads to one other of the loop, by one arc.
    pub period: Option<u64>,
    /// Whether nothing leads out.
    pub is_final: bool,
}

/// Start-up and cycles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoopShape {
    /// The states to which the system never returns, by number.
    pub transient: Vec<StateId>,
    /// The loops, by their lowest state.
    pub loops: Vec<StateLoop>,
}

impl<S> StateGraph<S> {
    /// States that are passed once, and states on cycles.
    pub fn shape(&self) -> LoopShape {
        let parts = self.components(self.arcs().iter());
        let mut shape = LoopShape { transient: Vec::new(), loops: Vec::new() };
        for part in 0..parts.count() {
            let members = parts.members(part);
            let inside = |&&arc: &&GraphArc| parts.of(arc.to.index()) == part;
            let states: Vec<StateId> = members.iter().map(|&state| StateId(state as u32)).collect();
            let single = states.iter().all(|&state| self.arcs_from(state).iter().filter(inside).count() == 1);
            if states.len() == 1 && self.arcs_from(states[0]).iter().filter(inside).count() == 0 {
                shape.transient.extend(states);
            } else if single {
                let mut round = vec![states[0]];
                let mut period = 0_u64;
                loop {
                    let at = round[round.len() - 1];
                    let Some(arc) = self.arcs_from(at).iter().find(inside) else { break };
                    period = period.saturating_add(arc.label.delay());
                    if arc.to == states[0] {
                        break;
                    }
                    round.push(arc.to);
                }
                shape.loops.push(StateLoop { states: round, period: Some(period), is_final: parts.is_terminal(part) });
            } else {
                shape.loops.push(StateLoop { states, period: None, is_final: parts.is_terminal(part) });
            }
        }
        shape.transient.sort_unstable();
        shape.loops.sort_by_key(|l| l.states[0]);
        shape
    }

    /// Number of different cycles through a state, each arc sequence counted, if every cycle of its loop does; a count
    /// beyond 64 bits is given as the largest. `None` if a cycle of the loop avoids the state. The testing station of
    /// seed 003 has four, which "all start in p4" (L888).
    pub fn cycles_through(&self, head: StateId) -> Option<u64> {
        let parts = self.components(self.arcs().iter());
        let part = parts.of(head.index());
        let members = parts.members(part);
        let inside = |&&arc: &&GraphArc| parts.of(arc.to.index()) == part;
        // Ways back to the head, counted against the arcs, where the head is cut.
        let mut waits: HashMap<usize, usize> = HashMap::new();
        for &state in members.iter().filter(|&&state| state != head.index()) {
            let arcs = self.arcs_from(StateId(state as u32)).iter().filter(inside);
            waits.insert(state, arcs.filter(|arc| arc.to != head).count());
        }
        let mut into: HashMap<usize, Vec<usize>> = HashMap::new();
        for &state in members {
            for arc in self.arcs_from(StateId(state as u32)).iter().filter(inside) {
                into.entry(arc.to.index()).or_default().push(state);
            }
        }
        let mut ways: HashMap<usize, u64> = HashMap::new();
        let mut ready = vec![head.index()];
        let (mut cycles, mut done) = (0_u64, 0);
        let add = |to: &mut u64, more: u64| *to = to.saturating_add(more);
        ready.extend(waits.iter().filter(|&(_, &n)| n == 0).map(|(&state, _)| state));
        for &from in into.get(&head.index()).into_iter().flatten() {
            add(if from == head.index() { &mut cycles } else { ways.entry(from).or_default() }, 1);
        }
        ready.retain(|&state| state != head.index());
        while let Some(at) = ready.pop() {
            done += 1;
            let count = ways.get(&at).copied().unwrap_or(0);
            for &from in into.get(&at).into_iter().flatten() {
                if from == head.index() {
                    add(&mut cycles, count);
                    continue;
                }
                add(ways.entry(from).or_default(), count);
                if let Some(n) = waits.get_mut(&from) {
                    *n -= 1;
                    if *n == 0 {
                        ready.push(from);
                    }
                }
            }
        }
        (done == members.len() - 1).then_some(cycles)
    }

    /// A state on a cycle that takes no time, if there is one: a run could stay there while the clock stands still.
    pub fn standstill(&self) -> Option<StateId> {
        self.on_cycle(self.arcs().iter().filter(|arc| arc.label.delay() == 0))
    }

    /// The lowest state on a cycle of the given arcs.
    pub(super) fn on_cycle<'a>(&self, arcs: impl Iterator<Item = &'a GraphArc> + Clone) -> Option<StateId> {
        let parts = self.components(arcs.clone());
        let inside = |arc: &&GraphArc| parts.of(arc.from.index()) == parts.of(arc.to.index());
        arcs.filter(inside).map(|arc| arc.from).min()
    }

    fn components<'a>(&self, arcs: impl Iterator<Item = &'a GraphArc> + Clone) -> Components {
        Components::new(self.states().len(), arcs.map(|arc| (arc.from.index(), arc.to.index())))
    }
}
