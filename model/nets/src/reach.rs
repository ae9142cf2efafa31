//! Playing a net out: every marking that can be reached, and facts that follow.
//!
//! The oracle of tests, for plain and for [coloured](crate::coloured::explore) nets: slow and obvious. It stores each
//! marking, stops at a bound, and is undecided then. It does not recognise an unbounded net, and does not reduce or
//! compress. Products use [`crate::explicit`].

use std::collections::{HashMap, HashSet};
use std::fmt::Display;
use std::hash::Hash;

use thiserror::Error;

use crate::components::Components;
use crate::{FireError, Marking, Net, PlaceId, TransitionId};

/// A reachable marking, numbered in the order of discovery: breadth first, the initial marking is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StateId(pub u32);

impl StateId {
    /// The initial marking.
    pub const INITIAL: StateId = StateId(0);

    /// The position in tables that have one entry per state.
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// M₁[t⟩M₂ as an arc of the reachability graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ReachArc<T = TransitionId> {
    /// M₁.
    pub from: StateId,
    /// t: a transition, or a mode of one.
    pub transition: T,
    /// M₂.
    pub to: StateId,
}

/// The exploration did not come to an end: nothing is known about the net as a whole.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("undecided after {states} states: {cause}")]
pub struct ReachUndecided<E: Display = FireError> {
    /// The states found until then.
    pub states: usize,
    pub cause: ReachLimit<E>,
}

/// Limit that stops an exploration.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ReachLimit<E: Display = FireError> {
    /// There are more states than allowed.
    #[error("there are more than allowed")]
    Limit,
    /// A place gets more tokens than can be counted.
    #[error("{0}")]
    Overflow(E),
}

/// R(N, M₀) and the steps within it (seed 002 §3.1).
#[derive(Clone, Debug)]
pub struct Reachability<M = Marking, T = TransitionId> {
    states: Vec<M>,
    number_of: HashMap<M, StateId>,
    /// Ordered by `from`, then by transition.
    steps: Vec<ReachArc<T>>,
    /// The step by which each state was found; none for the initial one.
    found_by: Vec<Option<ReachArc<T>>>,
    /// Transitions that are to be live.
    transitions: Vec<T>,
    /// The terminal components, each with its first state.
    terminal: Vec<(usize, StateId)>,
    /// Component and transition fired.
    fires: HashSet<(usize, T)>,
    /// A state from which the initial one cannot be reached.
    no_return: Option<StateId>,
}

/// Finds all reachable markings, unless there are more than `limit_states`.
pub fn explore(net: &Net, limit_states: usize) -> Result<Reachability, ReachUndecided> {
    let enabled = |here: &Marking| net.enabled(here).collect();
    let fire = |marking: &mut Marking, transition| net.fire(marking, transition);
    explore_by(net.initial_marking(), net.transitions().collect(), limit_states, enabled, fire)
}

/// Finds all markings that can be reached from `initial`: `enabled` lists what fires at one, in order,
/// and `fire` changes it.
pub(crate) fn explore_by<M: Clone + Eq + Hash, T: Copy + Eq + Hash, E: Display>(
    initial: M,
    transitions: Vec<T>,
    limit_states: usize,
    enabled: impl Fn(&M) -> Vec<T>,
    fire: impl Fn(&mut M, T) -> Result<(), E>,
) -> Result<Reachability<M, T>, ReachUndecided<E>> {
    // State numbers have 32 bits; memory ends long before.
    let limit = limit_states.min(u32::MAX as usize);
    if limit == 0 {
        return Err(ReachUndecided { states: 0, cause: ReachLimit::Limit });
    }
    let mut number_of = HashMap::from([(initial.clone(), StateId::INITIAL)]);
    let (mut states, mut found_by, mut steps) = (vec![initial], vec![None], Vec::new());
    let mut next = 0;
    while next < states.len() {
        let from = StateId(next as u32);
        for transition in enabled(&states[next]) {
            let mut marking = states[next].clone();
            let stop = |cause| ReachUndecided { states: states.len(), cause };
            fire(&mut marking, transition).map_err(|error| stop(ReachLimit::Overflow(error)))?;
            let step = |to| ReachArc { from, transition, to };
            if let Some(&known) = number_of.get(&marking) {
                steps.push(step(known));
                continue;
            }
            if states.len() == limit {
                return Err(stop(ReachLimit::Limit));
            }
            let new = step(StateId(states.len() as u32));
            number_of.insert(marking.clone(), new.to);
            states.push(marking);
            found_by.push(Some(new));
            steps.push(new);
        }
        next += 1;
    }
    let parts = Components::new(states.len(), steps.iter().map(|step| (step.from.index(), step.to.index())));
    let first = |component: usize| StateId(parts.members(component)[0] as u32);
    // A transition is live iff it can fire in every terminal component: all states lead into one of them, none leads out.
    let terminal = parts.terminal().map(|component| (component, first(component))).collect();
    let fires = steps.iter().map(|step| (parts.of(step.from.index()), step.transition)).collect();
    let no_return = (parts.count() > 1).then(|| first(0));
    Ok(Reachability { states, number_of, steps, found_by, transitions, terminal, fires, no_return })
}

impl<M: Clone + Eq + Hash, T: Copy + Eq + Hash> Reachability<M, T> {
    /// The reachable markings, by state number.
    pub fn states(&self) -> &[M] {
        &self.states
    }

    /// The numbers of all states.
    pub fn numbers(&self) -> impl ExactSizeIterator<Item = StateId> + use<M, T> {
        (0..self.states.len() as u32).map(StateId)
    }

    /// The steps between them, ordered by where they start, then by transition.
    pub fn steps(&self) -> &[ReachArc<T>] {
        &self.steps
    }

    pub fn marking(&self, state: StateId) -> &M {
        &self.states[state.index()]
    }

    /// The state with that marking, if it can be reached.
    pub fn find(&self, marking: &M) -> Option<StateId> {
        self.number_of.get(marking).copied()
    }

    /// The steps that start at a state.
    pub fn steps_from(&self, state: StateId) -> &[ReachArc<T>] {
        let start = self.steps.partition_point(|step| step.from < state);
        let end = self.steps.partition_point(|step| step.from <= state);
        &self.steps[start..end]
    }

    /// A shortest firing sequence from the initial marking to a state.
    pub fn path_to(&self, state: StateId) -> Vec<T> {
        let mut path = Vec::new();
        let mut at = state;
        while let Some(step) = self.found_by[at.index()] {
            path.push(step.transition);
            at = step.from;
        }
        path.reverse();
        path
    }

    /// The states in which nothing is enabled.
    pub fn deadlocks(&self) -> impl Iterator<Item = StateId> + '_ {
        self.numbers().filter(|&state| self.steps_from(state).is_empty())
    }

    /// Whether every transition is live (seed 002 §3.1, Definition 1); of a coloured net, every mode that its guard
    /// allows.
    pub fn is_live(&self) -> bool {
        self.transitions.iter().all(|&transition| self.is_transition_live(transition).is_ok())
    }

    /// Whether one transition is live, or a state from which it can never be enabled again.
    pub fn is_transition_live(&self, transition: T) -> Result<(), StateId> {
        let missing = self.terminal.iter().find(|&&(component, _)| !self.fires.contains(&(component, transition)));
        missing.map_or(Ok(()), |&(_, state)| Err(state))
    }

    /// Whether the initial marking can be reached from every state, or a state from which it cannot (Definition 1).
    pub fn is_reversible(&self) -> Result<(), StateId> {
        self.no_return.map_or(Ok(()), Err)
    }
}

impl Reachability {
    /// The most tokens that any place ever holds.
    pub fn bound(&self) -> u32 {
        self.states.iter().flat_map(|marking| marking.as_slice()).copied().max().unwrap_or(0)
    }

    /// The most tokens that a place ever holds.
    pub fn bound_of(&self, place: PlaceId) -> u32 {
        self.states.iter().map(|marking| marking.tokens(place)).max().unwrap_or(0)
    }

    /// Whether no place ever holds more than one token (Definition 1).
    pub fn is_safe(&self) -> bool {
        self.bound() <= 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NetBuilder;

    /// Two stations that need two tools each and pick them up one by one, in opposite order.
    fn two_tools() -> Net {
        let mut b = NetBuilder::new("two tools");
        let [wrench, driver] = ["wrench", "driver"].map(|name| b.place(name, 1));
        for (station, first, second) in [("left", wrench, driver), ("right", driver, wrench)] {
            let idle = b.place(format!("{station} idle"), 1);
            let half = b.place(format!("{station} has one"), 0);
            let work = b.place(format!("{station} works"), 0);
            let [one, two, done] = ["one", "two", "done"].map(|name| b.transition(format!("{station} {name}")));
            b.input(one, idle, 1).input(one, first, 1).output(one, half, 1);
            b.input(two, half, 1).input(two, second, 1).output(two, work, 1);
            b.input(done, work, 1).output(done, idle, 1).output(done, first, 1).output(done, second, 1);
        }
        b.build().unwrap()
    }

    #[test]
    fn the_deadlock_of_two_tools_is_found_with_a_shortest_way_into_it() {
        let net = two_tools();
        let r = explore(&net, 100).unwrap();
        let deadlocks: Vec<_> = r.deadlocks().collect();
        assert_eq!(deadlocks.len(), 1);
        assert_eq!(net.describe(r.marking(deadlocks[0])), "left has one, right has one");
        let way: Vec<_> = r.path_to(deadlocks[0]).into_iter().map(|t| net.transition_name(t)).collect();
        assert_eq!(way, ["left one", "right one"]);
        assert!(!r.is_live() && r.is_safe());
        assert_eq!(r.is_reversible(), Err(deadlocks[0]));
        assert!(net.transitions().all(|t| r.is_transition_live(t) == Err(deadlocks[0])));
    }

    #[test]
    fn an_endless_net_is_undecided_not_wrong() {
        let mut b = NetBuilder::new("spring");
        let (pool, spring) = (b.place("pool", 0), b.transition("spring"));
        b.output(spring, pool, 1);
        let error = explore(&b.build().unwrap(), 10).unwrap_err();
        assert_eq!(error, ReachUndecided { states: 10, cause: ReachLimit::Limit });

        let mut b = NetBuilder::new("flood");
        let (pool, spring) = (b.place("pool", 1), b.transition("spring"));
        b.output(spring, pool, u32::MAX);
        let error = explore(&b.build().unwrap(), 10).unwrap_err();
        assert_eq!(
            error.to_string(),
            "undecided after 1 states: transition `spring` cannot fire: \
             place `pool` has 1 tokens, and 4294967295 more cannot be counted"
        );
    }

    #[test]
    fn the_limit_is_the_number_of_states_that_is_still_decided() {
        let net = two_tools();
        let states = explore(&net, 100).unwrap().states().len();
        assert!(explore(&net, states).is_ok());
        assert_eq!(explore(&net, states - 1).unwrap_err().states, states - 1);
        assert_eq!(explore(&net, 0).unwrap_err().states, 0);
    }
}
