//! Playing a coloured net out, on coloured markings.
//!
//! States are found breadth first, and from each state modes are played in their order. That is the order in which
//! [`crate::explore`] goes through the unfolding of all colours, so the two number the same states the same way; the
//! tests hold them against each other. Nothing is merged that symmetry would allow: two states are one only if they
//! are equal. Beyond its limits the exploration says that it does not know.

use std::collections::HashSet;

use thiserror::Error;

use super::bind;
use super::game::{ColouredFireError, minus};
use super::marking::{ColouredMarking, collect};
use super::net::{ColouredNet, NetMode};
use super::store::MarkingStore;
use crate::components::Components;
use crate::{NamedId, PlaceId, StateId};

/// How far to explore.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ColouredReachLimits {
    /// The most states.
    pub states: usize,
    /// The most memory for states and steps, in bytes, about. Finding the components at the end needs as much again.
    pub bytes: usize,
}

impl ColouredReachLimits {
    /// So many states, in at most a gibibyte.
    pub fn states(states: usize) -> ColouredReachLimits {
        ColouredReachLimits { states, bytes: 1 << 30 }
    }
}

/// The exploration did not come to an end: nothing is known about the net as a whole.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("undecided after {states} states: {cause}")]
pub struct ColouredUndecided {
    /// The states found until then.
    pub states: usize,
    pub cause: ColouredReachLimit,
}

/// What stops an exploration.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ColouredReachLimit {
    /// There are more states than allowed.
    #[error("there are more than allowed")]
    States,
    /// States and steps need more memory than allowed.
    #[error("states and steps need more memory than allowed")]
    Bytes,
    /// A place gets more tokens than can be counted.
    #[error("{0}")]
    Overflow(ColouredFireError),
}

/// M₁[(t, c)⟩M₂ as an arc of the reachability graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ColouredStep {
    /// M₁.
    pub from: StateId,
    /// (t, c).
    pub mode: NetMode,
    /// M₂.
    pub to: StateId,
}

/// All reachable coloured markings and the steps between them.
#[derive(Clone, Debug)]
pub struct ColouredReachability {
    states: MarkingStore,
    /// Ordered by `from`, then by mode.
    steps: Vec<ColouredStep>,
    /// The step by which each state was found; none for the initial one.
    found_by: Vec<Option<u32>>,
    /// The terminal components, each with its first state.
    terminal: Vec<(usize, StateId)>,
    /// Which modes fire in which terminal component.
    fires: HashSet<(usize, NetMode)>,
    /// A state from which the initial one cannot be reached.
    no_return: Option<StateId>,
}

/// Finds all reachable markings, as far as the limits allow.
pub fn explore(net: &ColouredNet, limits: ColouredReachLimits) -> Result<ColouredReachability, ColouredUndecided> {
    // State numbers have 32 bits, and so have step numbers; memory ends long before.
    let most = limits.states.min(u32::MAX as usize);
    let mut states = MarkingStore::new();
    if most == 0 {
        return Err(ColouredUndecided { states: 0, cause: ColouredReachLimit::States });
    }
    states.add(&net.initial.entries);
    let mut found_by = vec![None];
    let mut steps: Vec<ColouredStep> = Vec::new();
    let (mut here, mut colours, mut takes) = (Vec::new(), Vec::new(), Vec::new());
    let mut next = 0;
    while next < states.len() {
        let from = StateId(next as u32);
        here.clear();
        here.extend_from_slice(states.get(from.0));
        for transition in net.transitions() {
            colours.clear();
            let room = limits.bytes.saturating_sub(states.bytes()) / size_of::<ColouredStep>();
            let room = room.saturating_sub(steps.len()).min(u32::MAX as usize - steps.len());
            bind::enabled(net, transition.index(), &here, false, room + 1, &mut colours);
            if colours.len() > room {
                return Err(ColouredUndecided { states: states.len(), cause: ColouredReachLimit::Bytes });
            }
            for &colour in &colours {
                let mode = NetMode { transition, colour };
                let stop = |cause| ColouredUndecided { states: states.len(), cause };
                takes.clear();
                net.demand(&[mode], &mut takes).expect("the builder bounds what a mode takes");
                let mut after = minus(&here, &takes);
                net.append_outputs(mode, &mut after);
                let full = |cell| ColouredFireError::Overflow { mode: net.mode_name(mode), cell: net.cell_name(cell) };
                collect(&mut after).map_err(|cell| stop(ColouredReachLimit::Overflow(full(cell))))?;
                let known = states.find(&after);
                if known.is_none() && states.len() == most {
                    return Err(stop(ColouredReachLimit::States));
                }
                let to = StateId(known.unwrap_or_else(|| states.add(&after)));
                if known.is_none() {
                    found_by.push(Some(steps.len() as u32));
                }
                steps.push(ColouredStep { from, mode, to });
            }
        }
        next += 1;
    }
    Ok(ColouredReachability::new(states, steps, found_by))
}

impl ColouredReachability {
    fn new(states: MarkingStore, steps: Vec<ColouredStep>, found_by: Vec<Option<u32>>) -> ColouredReachability {
        let parts = Components::new(states.len(), steps.iter().map(|step| (step.from.index(), step.to.index())));
        let first = |component: usize| StateId(parts.members(component)[0] as u32);
        let terminal = parts.terminal().map(|component| (component, first(component))).collect();
        let inside = steps.iter().filter(|step| parts.is_terminal(parts.of(step.from.index())));
        let fires = inside.map(|step| (parts.of(step.from.index()), step.mode)).collect();
        let no_return = (parts.count() > 1).then(|| first(0));
        ColouredReachability { states, steps, found_by, terminal, fires, no_return }
    }

    /// How many markings can be reached.
    pub fn state_count(&self) -> usize {
        self.states.len()
    }

    /// All states.
    pub fn states(&self) -> impl ExactSizeIterator<Item = StateId> + use<> {
        (0..self.states.len() as u32).map(StateId)
    }

    pub fn marking(&self, state: StateId) -> ColouredMarking {
        ColouredMarking { entries: self.entries(state).to_vec() }
    }

    /// The same without a copy: the cells that have tokens, ascending, with their counts.
    pub fn entries(&self, state: StateId) -> &[(u32, u32)] {
        self.states.get(state.0)
    }

    /// The state with that marking, if it can be reached.
    pub fn find(&self, marking: &ColouredMarking) -> Option<StateId> {
        self.states.find(&marking.entries).map(StateId)
    }

    /// The steps between states, ordered by where they start, then by mode.
    pub fn steps(&self) -> &[ColouredStep] {
        &self.steps
    }

    /// The steps that start at a state.
    pub fn steps_from(&self, state: StateId) -> &[ColouredStep] {
        let start = self.steps.partition_point(|step| step.from < state);
        let end = self.steps.partition_point(|step| step.from <= state);
        &self.steps[start..end]
    }

    /// A shortest firing sequence from the initial marking to a state.
    pub fn path_to(&self, state: StateId) -> Vec<NetMode> {
        let mut path = Vec::new();
        let mut at = state;
        while let Some(step) = self.found_by[at.index()] {
            let step = self.steps[step as usize];
            path.push(step.mode);
            at = step.from;
        }
        path.reverse();
        path
    }

    /// The states in which nothing is enabled.
    pub fn deadlocks(&self) -> impl Iterator<Item = StateId> + '_ {
        self.states().filter(|&state| self.steps_from(state).is_empty())
    }

    /// Whether a mode can become enabled again from everywhere; else a state from which it never can.
    pub fn is_mode_live(&self, mode: NetMode) -> Result<(), StateId> {
        let missing = self.terminal.iter().find(|&&(component, _)| !self.fires.contains(&(component, mode)));
        missing.map_or(Ok(()), |&(_, state)| Err(state))
    }

    /// Whether every mode that its guard allows is live; else the first that is not, with a state from which it never
    /// fires.
    pub fn is_live(&self, net: &ColouredNet) -> Result<(), (NetMode, StateId)> {
        let lost = |mode: NetMode| self.is_mode_live(mode).err().map(|state| (mode, state));
        net.transitions().flat_map(|transition| net.modes(transition)).find_map(lost).map_or(Ok(()), Err)
    }

    /// Whether the initial marking can be reached from everywhere; else a state from which it cannot.
    pub fn is_reversible(&self) -> Result<(), StateId> {
        self.no_return.map_or(Ok(()), Err)
    }

    /// The most tokens of any colour that a place ever holds together.
    pub fn bound_of(&self, net: &ColouredNet, place: PlaceId) -> u64 {
        let place = &net.places[place.index()];
        let held = |state| bind::on_place(self.entries(state), place).iter().map(|&(_, count)| u64::from(count)).sum();
        self.states().map(held).max().unwrap_or(0)
    }

    /// The most tokens of one colour that a place ever holds.
    pub fn bound_of_cell(&self, cell: u32) -> u32 {
        self.states().map(|state| super::marking::count_in(self.entries(state), cell)).max().unwrap_or(0)
    }

    /// The places that come to hold more tokens than they are declared to, with the most they hold.
    pub fn over_capacity(&self, net: &ColouredNet) -> Vec<(NamedId<PlaceId>, u64)> {
        let over = |place: PlaceId| {
            let most = net.max_tokens(place)?;
            let bound = self.bound_of(net, place);
            (bound > u64::from(most)).then(|| (net.place(place), bound))
        };
        net.places().filter_map(over).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coloured::{ColouredBuilder, Domain, Guard, Operand, compare, component, id, proj, succ};

    /// A token that goes around a ring of `size`, and leaves a trace if asked to.
    fn ring(size: u32, trace: bool) -> ColouredNet {
        let mut b = ColouredBuilder::new("ring");
        let at = b.basic("at", size);
        let here = b.place("here", at);
        let step = b.transition("step", at);
        b.tokens(here, &[1], 1).input(step, here, id()).output(step, here, succ(1, 1));
        if trace {
            let seen = b.place("seen", at);
            b.output(step, seen, proj([1]));
        }
        b.build().unwrap()
    }

    #[test]
    fn a_ring_is_live_and_reversible() {
        let net = ring(5, false);
        let r = explore(&net, ColouredReachLimits::states(10)).unwrap();
        assert_eq!((r.state_count(), r.steps().len(), r.deadlocks().count()), (5, 5, 0));
        assert_eq!((r.is_live(&net), r.is_reversible()), (Ok(()), Ok(())));
        let last: Vec<_> = r.path_to(StateId(4)).into_iter().map(|mode| net.mode_name(mode)).collect();
        assert_eq!(last, ["step<1>", "step<2>", "step<3>", "step<4>"]);
        assert_eq!(net.describe(&r.marking(StateId(4))), "here<5>");
        assert_eq!(r.find(&r.marking(StateId(3))), Some(StateId(3)));
    }

    #[test]
    fn what_does_not_end_is_undecided_by_states_and_by_memory() {
        let net = ring(3, true);
        let stopped = explore(&net, ColouredReachLimits::states(100)).unwrap_err();
        assert_eq!(stopped.to_string(), "undecided after 100 states: there are more than allowed");
        let stopped = explore(&net, ColouredReachLimits { states: usize::MAX, bytes: 100_000 }).unwrap_err();
        assert_eq!(stopped.cause, ColouredReachLimit::Bytes);
        assert!((500..2500).contains(&stopped.states), "{stopped}");
        assert_eq!(explore(&net, ColouredReachLimits::states(0)).unwrap_err().states, 0);
    }

    #[test]
    fn very_many_modes_do_not_take_more_memory_than_allowed() {
        let mut b = ColouredBuilder::new("flood");
        let wide = b.basic("wide", 1 << 20);
        let pool = b.place("pool", wide);
        let spring = b.transition("spring", wide);
        b.output(spring, pool, id());
        let stopped = explore(&b.build().unwrap(), ColouredReachLimits { states: 1000, bytes: 1 << 16 }).unwrap_err();
        assert_eq!((stopped.states, stopped.cause), (1, ColouredReachLimit::Bytes));
    }

    #[test]
    fn capacities_are_claims_that_are_checked() {
        let mut b = ColouredBuilder::new("gather");
        let kind = b.basic("kind", 3);
        let (loose, boxed) = (b.place("loose", kind), b.place("boxed", kind));
        b.max_tokens(boxed, 2);
        (1..=3).for_each(|tone| _ = b.tokens(loose, &[tone], 1));
        let pack = b.transition("pack", Domain::Universal);
        b.input(pack, loose, id()).output(pack, boxed, id());
        b.guard(pack, Guard::all([compare(component(1), crate::coloured::Comparison::Less, Operand::Number(9))]));
        let net = b.build().unwrap();
        let r = explore(&net, ColouredReachLimits::states(100)).unwrap();
        assert_eq!(r.state_count(), 8);
        let over: Vec<_> = r.over_capacity(&net).iter().map(|(place, bound)| format!("{place}: {bound}")).collect();
        assert_eq!(over, ["place `boxed`: 3"]);
        assert_eq!((r.bound_of_cell(net.cell_of(boxed, &[2]).unwrap()), r.deadlocks().count()), (1, 1));
    }
}
