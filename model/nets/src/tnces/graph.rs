//! The state graph, and its paths and times.
//!
//! "A timing diagram represents the variables between a source state and a destination state" (seed 003 §5.1.2, L898):
//! [`StateGraph::fastest`] gives the moments of one, [`StateGraph::span`] the bounds of all.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use crate::TransitionId;
use crate::reach::StateId;

/// A step, numbered in the order of discovery.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StepId(pub u32);

/// Label of an arc from one state to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TimedLabel {
    /// A step, which takes no time.
    Step(StepId),
    /// Time in which nothing fires.
    Delay(u64),
}

impl TimedLabel {
    /// Time that passes.
    pub fn delay(self) -> u64 {
        match self {
            TimedLabel::Step(_) => 0,
            TimedLabel::Delay(delay) => delay,
        }
    }
}

/// An arc of the state graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GraphArc {
    /// Where it starts.
    pub from: StateId,
    /// Event.
    pub label: TimedLabel,
    /// Where it ends.
    pub to: StateId,
}

/// The longest time that a run can take to a goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Latest {
    /// Every run reaches the goal, within this time.
    After(u64),
    /// Some run never reaches it: it can stay at this state, or come back to it for ever.
    Never(StateId),
}

/// Time from a state to a goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeBound {
    /// On the fastest run.
    pub earliest: u64,
    /// On the slowest.
    pub latest: Latest,
}

/// All reachable states and the arcs between them.
#[derive(Clone, Debug)]
pub struct StateGraph<S> {
    states: Vec<S>,
    /// Ordered by `from`; of one state, steps by trigger and then the delay.
    arcs: Vec<GraphArc>,
    steps: Vec<Box<[TransitionId]>>,
    /// Per state, the arc by which it was found.
    found_by: Vec<Option<u32>>,
}

impl<S> StateGraph<S> {
    pub(super) fn new(states: Vec<S>, arcs: Vec<GraphArc>, steps: Vec<Box<[TransitionId]>>) -> Self {
        let mut found_by = vec![None; states.len()];
        for (number, arc) in (0..).zip(&arcs) {
            if arc.to != StateId::INITIAL {
                found_by[arc.to.index()].get_or_insert(number);
            }
        }
        StateGraph { states, arcs, steps, found_by }
    }

    pub(super) fn map<R>(self, convert: impl FnMut(S) -> R) -> StateGraph<R> {
        let StateGraph { states, arcs, steps, found_by } = self;
        StateGraph { states: states.into_iter().map(convert).collect(), arcs, steps, found_by }
    }

    /// The states, by number; breadth first from the initial one.
    pub fn states(&self) -> &[S] {
        &self.states
    }

    pub fn state(&self, state: StateId) -> &S {
        &self.states[state.index()]
    }

    /// The arcs, ordered by where they start.
    pub fn arcs(&self) -> &[GraphArc] {
        &self.arcs
    }

    /// The arcs that start at a state.
    pub fn arcs_from(&self, state: StateId) -> &[GraphArc] {
        let start = self.arcs.partition_point(|arc| arc.from < state);
        let end = self.arcs.partition_point(|arc| arc.from <= state);
        &self.arcs[start..end]
    }

    /// The transitions of a step: the spontaneous one, then what it forces.
    pub fn step(&self, step: StepId) -> &[TransitionId] {
        &self.steps[step.0 as usize]
    }

    /// The transitions that fire along an arc; none along a delay.
    pub fn fired(&self, arc: &GraphArc) -> &[TransitionId] {
        match arc.label {
            TimedLabel::Step(step) => self.step(step),
            TimedLabel::Delay(_) => &[],
        }
    }

    /// The states after which nothing fires any more.
    pub fn deadlocks(&self) -> impl Iterator<Item = StateId> + '_ {
        self.numbers().filter(|&state| self.arcs_from(state).is_empty())
    }

    /// A way from the initial state to a state, with the fewest arcs.
    pub fn path_to(&self, state: StateId) -> Vec<GraphArc> {
        let mut path = Vec::new();
        let mut at = state;
        while let Some(arc) = self.found_by[at.index()] {
            path.push(self.arcs[arc as usize]);
            at = self.arcs[arc as usize].from;
        }
        path.reverse();
        path
    }

    /// A fastest way from a state to one that is a goal, with the time at the end of each arc; `None` if there is none,
    /// and empty if the state is a goal itself. These are the moments of a timing diagram.
    pub fn fastest(&self, from: StateId, goal: impl Fn(&S) -> bool) -> Option<Vec<(u64, GraphArc)>> {
        let mut reached: HashMap<StateId, (u64, Option<GraphArc>)> = HashMap::from([(from, (0, None))]);
        let mut open = BinaryHeap::from([Reverse((0, from))]);
        while let Some(Reverse((time, at))) = open.pop() {
            if reached[&at].0 < time {
                continue;
            }
            if goal(self.state(at)) {
                let mut way = Vec::new();
                let mut end = at;
                while let (time, Some(arc)) = reached[&end] {
                    way.push((time, arc));
                    end = arc.from;
                }
                way.reverse();
                return Some(way);
            }
            for &arc in self.arcs_from(at) {
                let time = time.saturating_add(arc.label.delay());
                if reached.get(&arc.to).is_none_or(|&(known, _)| time < known) {
                    reached.insert(arc.to, (time, Some(arc)));
                    open.push(Reverse((time, arc.to)));
                }
            }
        }
        None
    }

    /// The shortest and the longest time from a state to a goal; `None` if no run leads there.
    pub fn span(&self, from: StateId, goal: impl Fn(&S) -> bool) -> Option<TimeBound> {
        let way = self.fastest(from, &goal)?;
        let earliest = way.last().map_or(0, |&(time, _)| time);
        Some(TimeBound { earliest, latest: self.latest(from, goal) })
    }

    /// The longest time to a goal: a longest path, if the states before the goal have neither a cycle nor an end.
    fn latest(&self, from: StateId, goal: impl Fn(&S) -> bool) -> Latest {
        // Everything before the goal, with the number of arcs into it from there.
        let mut before: HashMap<StateId, usize> = HashMap::new();
        let mut open = vec![from];
        if goal(self.state(from)) {
            return Latest::After(0);
        }
        before.insert(from, 0);
        while let Some(at) = open.pop() {
            if self.arcs_from(at).is_empty() {
                return Latest::Never(at);
            }
            for arc in self.arcs_from(at) {
                if goal(self.state(arc.to)) {
                    continue;
                }
                *before.entry(arc.to).or_insert_with(|| {
                    open.push(arc.to);
                    0
                }) += 1;
            }
        }
        let mut longest: HashMap<StateId, u64> = HashMap::new();
        let mut ready: Vec<StateId> = before.iter().filter(|&(_, &arcs)| arcs == 0).map(|(&at, _)| at).collect();
        let mut latest = 0;
        while let Some(at) = ready.pop() {
            let time = longest.get(&at).copied().unwrap_or(0);
            before.remove(&at);
            for arc in self.arcs_from(at) {
                let time = time.saturating_add(arc.label.delay());
                match before.get_mut(&arc.to) {
                    None => latest = latest.max(time),
                    Some(arcs) => {
                        *arcs -= 1;
                        let known = longest.entry(arc.to).or_default();
                        *known = time.max(*known);
                        if *arcs == 0 {
                            ready.push(arc.to);
                        }
                    }
                }
            }
        }
        // The rest lies on a cycle or behind one.
        let left = |arc: &&GraphArc| before.contains_key(&arc.from) && before.contains_key(&arc.to);
        self.on_cycle(self.arcs.iter().filter(left)).map_or(Latest::After(latest), Latest::Never)
    }

    pub(super) fn numbers(&self) -> impl Iterator<Item = StateId> + use<S> {
        (0..self.states.len() as u32).map(StateId)
    }
}
