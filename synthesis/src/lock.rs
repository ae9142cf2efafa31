//! Locked machines: those that wait for each other, whatever the others do.

use std::collections::{BTreeSet, VecDeque};

use linewright_relations::{MachineId, Relations};

use crate::model::{Composition, Mark, MarkSet, ModelEvent, Nth, Predicate, Restriction, holds};

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

/// Up to so many states are looked at for a shortest way.
const STATES_MAX: usize = 20_000;

/// The machines of a cell that wait for each other in a state for ever: of all that do, as few as lock each other.
pub(crate) fn locked(relations: &Relations, composition: &Composition, state: &MarkSet) -> BTreeSet<MachineId> {
    let machines = (0..relations.machines.len()).map(MachineId);
    let is_idle = |machine: &MachineId| {
        let own = |of: Nth| composition.operations[of].machines.contains(machine);
        let executes = state.iter().any(|(of, mark)| {
            *mark == Mark::Started && own(*of) && !state.contains(&(*of, Mark::Finished))
        });
        !executes && !is_done(composition, state, *machine)
    };
    let mut core = stuck(composition, state, machines.filter(is_idle).collect());
    for machine in core.clone() {
        let mut fewer = core.clone();
        fewer.remove(&machine);
        let fewer = stuck(composition, state, fewer);
        if !fewer.is_empty() {
            core = fewer;
        }
    }
    core
}

/// Whether a machine has nothing to do any more: none of its events can come, whatever others do, and its last place is done.
fn is_done(composition: &Composition, state: &MarkSet, machine: MachineId) -> bool {
    let parts = match &composition.finished {
        Predicate::All(parts) => &parts[..],
        one => std::slice::from_ref(one),
    };
    let is_own = |part: &&Predicate| part.operations().iter().any(|of| composition.operations[*of].machines.contains(&machine));
    parts.iter().filter(is_own).all(|part| holds(part, state))
}

/// Of these machines, those none of whose events can come as long as all of them stand still.
fn stuck(composition: &Composition, state: &MarkSet, mut machines: BTreeSet<MachineId>) -> BTreeSet<MachineId> {
    loop {
        let frozen = |of: Nth| composition.operations[of].machines.iter().any(|machine| machines.contains(machine));
        // Marks are never taken back; of machines that go on, those that are not set may come.
        let value = |of: Nth, mark: Mark| match (state.contains(&(of, mark)), frozen(of)) {
            (true, _) => Some(true),
            (false, true) => Some(false),
            (false, false) => None,
        };
        let can_come = |event: &&ModelEvent| {
            !state.contains(&(event.of, event.mark))
                && event.possible.value(&value) != Some(false)
                && event.allowed.iter().all(|(_, part)| part.value(&value) != Some(false))
        };
        let moving: BTreeSet<MachineId> = composition
            .events
            .iter()
            .filter(can_come)
            .flat_map(|event| composition.operations[event.of].machines.iter().copied())
            .collect();
        let fewer: BTreeSet<MachineId> = machines.difference(&moving).copied().collect();
        if fewer == machines {
            return machines;
        }
        machines = fewer;
    }
}

/// What each of these machines waits for.
fn waits(relations: &Relations, composition: &Composition, state: &MarkSet, locked: &BTreeSet<MachineId>) -> Vec<WaitingMachine> {
    let turn = |event: &&ModelEvent| event.mark != Mark::Finished && event.is_possible(state);
    let _ = relations;
    let wait = |machine: &MachineId| {
        let own = |event: &&ModelEvent| composition.operations[event.of].machines.contains(machine);
        let possible: Vec<&ModelEvent> = composition.events.iter().filter(own).filter(turn).collect();
        // A choice that no state allows, or an operation of another machine as well, is not possible yet.
        let next: Vec<&ModelEvent> = match possible.is_empty() {
            false => possible,
            true => next_of(composition, state, *machine),
        };
        let broken = |event: &ModelEvent| -> Vec<(Restriction, Predicate)> {
            event.allowed.iter().filter(|(_, part)| !holds(part, state)).cloned().collect()
        };
        let lacks: Vec<(Restriction, Predicate)> = next.first().map_or_else(Vec::new, |event| broken(event));
        let mut waits_for: Vec<Nth> = lacks.iter().flat_map(|(_, part)| part.operations()).collect();
        if lacks.is_empty() {
            waits_for.extend(next.iter().flat_map(|event| event.possible.operations()));
        }
        let is_open = |of: &Nth| {
            let operation = &composition.operations[*of];
            !state.contains(&(*of, Mark::Finished)) && operation.machines.iter().any(|of| locked.contains(of) && of != machine)
        };
        waits_for.retain(is_open);
        waits_for.sort_unstable();
        waits_for.dedup();
        let mut restrictions: Vec<Restriction> = lacks.into_iter().map(|(restriction, _)| restriction).collect();
        restrictions.dedup();
        WaitingMachine { machine: *machine, next: next.iter().map(|event| event.of).collect(), lacks: restrictions, waits_for }
    };
    locked.iter().map(wait).collect()
}

/// The first events of a machine that are not there yet.
fn next_of<'c>(composition: &'c Composition, state: &MarkSet, machine: MachineId) -> Vec<&'c ModelEvent> {
    let is_next = |event: &&ModelEvent| {
        composition.operations[event.of].machines.contains(&machine) && !state.contains(&(event.of, event.mark))
    };
    let mut next: Vec<&ModelEvent> = composition.events.iter().filter(is_next).collect();
    next.sort_by_key(|event| {
        let operation = &composition.operations[event.of];
        (operation.instance, operation.depth, event.mark)
    });
    next.truncate(1);
    next
}

/// What is wrong in a state for good, if anything.
fn trapped(relations: &Relations, composition: &Composition, state: &MarkSet) -> Option<Trap> {
    let trap = Trap { way: Vec::new(), is_shortest: true, locked: Vec::new(), violated: None };
    if let Some((of, restriction)) = composition.violated(state) {
        return Some(Trap { violated: Some((of, restriction.clone())), ..trap });
    }
    let locked = locked(relations, composition, state);
    (!locked.is_empty()).then(|| Trap { locked: waits(relations, composition, state, &locked), ..trap })
}

/// A way from a state into a trap, through states that are lost already: the shortest, unless too many states lie between.
pub(crate) fn way_into_trap(
    relations: &Relations,
    composition: &Composition,
    from: &MarkSet,
    is_lost: &dyn Fn(&MarkSet) -> bool,
) -> Option<Trap> {
    let mut queue = VecDeque::from([(from.clone(), None::<usize>, None)]);
    let mut seen: BTreeSet<MarkSet> = BTreeSet::from([from.clone()]);
    let mut came: Vec<(Option<usize>, Option<(Nth, Mark)>)> = Vec::new();
    while let Some((state, parent, by)) = queue.pop_front() {
        came.push((parent, by));
        let own = came.len() - 1;
        if let Some(trap) = trapped(relations, composition, &state) {
            let mut way = Vec::new();
            let mut at = Some(own);
            while let Some(nth) = at {
                way.extend(came[nth].1);
                at = came[nth].0;
            }
            way.reverse();
            return Some(Trap { way: without_ends(way), ..trap });
        }
        if seen.len() > STATES_MAX {
            return some_way(relations, composition, from, is_lost);
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
fn some_way(
    relations: &Relations,
    composition: &Composition,
    from: &MarkSet,
    is_lost: &dyn Fn(&MarkSet) -> bool,
) -> Option<Trap> {
    let mut state = from.clone();
    let mut way = Vec::new();
    loop {
        if let Some(trap) = trapped(relations, composition, &state) {
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
