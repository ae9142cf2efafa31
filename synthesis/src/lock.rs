//! Locked machines: those that keep each other from finishing, whatever the others do.

use std::collections::{BTreeSet, VecDeque};

use linewright_relations::MachineId;

use crate::model::{Composition, Mark, MarkSet, ModelEvent, Nth, Predicate, Restriction};

/// A machine that waits, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WaitingMachine {
    pub machine: MachineId,
    /// What it would do next; several where it is not chosen yet.
    pub next: Vec<Nth>,
    /// Restrictions that do not hold, of the first of these.
    pub lacks: Vec<Restriction>,
    /// Operations that would have to be finished for them, or to go on.
    pub waits_for: Vec<Nth>,
}

/// How a cell gets stuck.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trap {
    /// Starts and choices on the way, from where the trap is looked for.
    pub way: Vec<(Nth, Mark)>,
    /// Whether no shorter way exists.
    pub is_shortest: bool,
    /// Machines that wait for each other; empty where something is violated.
    pub locked: Vec<WaitingMachine>,
    /// An operation that does, or may begin, what a restriction forbids, and nothing can hold back.
    pub violated: Option<(Nth, Restriction)>,
}

/// Machines that cannot finish from a state, and what can still come.
struct Locked {
    machines: BTreeSet<MachineId>,
    may_come: MarkSet,
}

impl Locked {
    fn value(&self, state: &MarkSet, of: Nth, mark: Mark) -> Option<bool> {
        match state.contains(&(of, mark)) {
            true => Some(true),
            false if self.may_come.contains(&(of, mark)) => None,
            false => Some(false),
        }
    }
}

/// The machines that cannot finish from a state, if those that are `free` do whatever they like.
///
/// Marks are added that may be set, beginning with none: an event may come where its condition can hold with these set or not. What is
/// not added in the end never comes, since a mark that is set is not taken back.
fn cannot_finish(composition: &Composition, state: &MarkSet, free: &BTreeSet<MachineId>) -> Locked {
    let is_of = |of: Nth, machines: &BTreeSet<MachineId>| {
        composition.operations[of].machines.iter().any(|machine| machines.contains(machine))
    };
    let mut waiting: Vec<&ModelEvent> =
        composition.events.iter().filter(|event| !state.contains(&(event.of, event.mark))).collect();
    let of_free = waiting.iter().filter(|event| is_of(event.of, free)).map(|event| (event.of, event.mark));
    let mut locked = Locked { machines: BTreeSet::new(), may_come: of_free.collect() };
    waiting.retain(|event| !is_of(event.of, free));
    loop {
        let known = locked.may_come.len();
        waiting.retain(|event| {
            let parts = event.allowed.iter().map(|(_, part)| part);
            let mut parts = std::iter::once(&event.possible).chain(parts);
            let can_come = parts.all(|part| part.value(&|of, mark| locked.value(state, of, mark)) != Some(false));
            if can_come {
                locked.may_come.insert((event.of, event.mark));
            }
            !can_come
        });
        if locked.may_come.len() == known {
            break;
        }
    }
    let parts = match &composition.finished {
        Predicate::All(parts) => &parts[..],
        one => std::slice::from_ref(one),
    };
    let never = parts.iter().filter(|part| part.value(&|of, mark| locked.value(state, of, mark)) == Some(false));
    let machines =
        never.flat_map(|part| part.operations()).flat_map(|of| composition.operations[of].machines.iter().copied());
    locked.machines = machines.filter(|machine| !free.contains(machine)).collect();
    locked
}

/// The machines of a cell that keep each other from finishing: of all that cannot, those of which none can be left out.
fn locked(composition: &Composition, state: &MarkSet) -> Locked {
    let mut free = BTreeSet::new();
    let mut core = cannot_finish(composition, state, &free);
    for machine in core.machines.clone() {
        free.insert(machine);
        let fewer = cannot_finish(composition, state, &free);
        if fewer.machines.is_empty() {
            free.remove(&machine);
        } else {
            core = fewer;
        }
    }
    core
}

/// What each of these machines waits for.
fn waits(composition: &Composition, state: &MarkSet, locked: &Locked) -> Vec<WaitingMachine> {
    let value = |of: Nth, mark: Mark| locked.value(state, of, mark);
    let wait = |machine: &MachineId| {
        let never = composition.events.iter().filter(|event| {
            event.mark != Mark::Finished
                && composition.operations[event.of].machines.contains(machine)
                && value(event.of, event.mark) == Some(false)
        });
        // The first that never comes is the first whose turn comes: what it waits for is not an operation of its own machine.
        let order =
            |event: &&ModelEvent| (composition.operations[event.of].instance, composition.operations[event.of].depth);
        let mut never: Vec<&ModelEvent> = never.collect();
        never.sort_by_key(order);
        let has_turn = |event: &&ModelEvent| event.possible.value(&value) != Some(false);
        let first = never.iter().copied().find(has_turn).or(never.first().copied());
        let lacking = |event: &ModelEvent| -> Vec<(Restriction, Predicate)> {
            event.allowed.iter().filter(|(_, part)| part.value(&value) == Some(false)).cloned().collect()
        };
        let lacks = first.map_or_else(Vec::new, lacking);
        let mut waits_for: Vec<Nth> = lacks.iter().flat_map(|(_, part)| part.operations()).collect();
        if lacks.is_empty() {
            waits_for.extend(first.iter().flat_map(|event| event.possible.operations()));
        }
        let is_open = |of: &Nth| {
            let others = composition.operations[*of].machines.iter().filter(|other| *other != machine);
            value(*of, Mark::Finished) == Some(false) && others.into_iter().any(|other| locked.machines.contains(other))
        };
        waits_for.retain(is_open);
        waits_for.sort_unstable();
        waits_for.dedup();
        let mut restrictions: Vec<Restriction> = lacks.into_iter().map(|(restriction, _)| restriction).collect();
        restrictions.dedup();
        WaitingMachine {
            machine: *machine,
            next: first.iter().map(|event| event.of).collect(),
            lacks: restrictions,
            waits_for,
        }
    };
    locked.machines.iter().map(wait).collect()
}

/// What is wrong in a state for good, if anything.
fn trapped(composition: &Composition, state: &MarkSet) -> Option<Trap> {
    let trap = Trap { way: Vec::new(), is_shortest: true, locked: Vec::new(), violated: None };
    if let Some((of, restriction)) = composition.violated(state) {
        return Some(Trap { violated: Some((of, restriction.clone())), ..trap });
    }
    let locked = locked(composition, state);
    (!locked.machines.is_empty()).then(|| Trap { locked: waits(composition, state, &locked), ..trap })
}

/// The number of the state before, and the mark that was set; neither for the first.
type Arrival = (Option<usize>, Option<(Nth, Mark)>);

/// A way from a state into a trap, through states that are lost already: the shortest, unless more than
/// `states_max` lie between.
pub(crate) fn way_into_trap(
    composition: &Composition,
    from: &MarkSet,
    is_lost: &dyn Fn(&MarkSet) -> bool,
    states_max: usize,
) -> Option<Trap> {
    let mut queue = VecDeque::from([(from.clone(), None::<usize>, None)]);
    let mut seen: BTreeSet<MarkSet> = BTreeSet::from([from.clone()]);
    let mut came: Vec<Arrival> = Vec::new();
    while let Some((state, parent, by)) = queue.pop_front() {
        came.push((parent, by));
        let own = came.len() - 1;
        if let Some(trap) = trapped(composition, &state) {
            let mut way = Vec::new();
            let mut at = Some(own);
            while let Some(nth) = at {
                way.extend(came[nth].1);
                at = came[nth].0;
            }
            way.reverse();
            return Some(Trap { way: without_ends(way), ..trap });
        }
        if seen.len() > states_max {
            return some_way(composition, from, is_lost);
        }
        for event in composition.enabled(&state) {
            let mut next = state.clone();
            next.insert((event.of, event.mark));
            if is_lost(&next) && seen.insert(next.clone()) {
                queue.push_back((next, Some(own), Some((event.of, event.mark))));
            }
        }
    }
    None
}

/// Some way into a trap: what is lost ends in one, since every run ends.
fn some_way(composition: &Composition, from: &MarkSet, is_lost: &dyn Fn(&MarkSet) -> bool) -> Option<Trap> {
    let mut state = from.clone();
    let mut way = Vec::new();
    loop {
        if let Some(trap) = trapped(composition, &state) {
            return Some(Trap { way: without_ends(way), is_shortest: false, ..trap });
        }
        let next = composition.enabled(&state).map(|event| (event.of, event.mark)).find(|mark| {
            let mut next = state.clone();
            next.insert(*mark);
            is_lost(&next)
        })?;
        way.push(next);
        state.insert(next);
    }
}

/// A way without the ends of operations, which follow from the starts.
fn without_ends(way: Vec<(Nth, Mark)>) -> Vec<(Nth, Mark)> {
    way.into_iter().filter(|(_, mark)| *mark != Mark::Finished).collect()
}
