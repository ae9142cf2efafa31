//! The monolithic way: every state of the composed automata one by one.
//!
//! It is there for comparison. Machines, zones, components and sequences are automata of their own here, stepped together as
//! Richardsson, Andersson and Fabian draw them, and share no code with the composition that [`synthesise`](crate::synthesise) works
//! on: tests compare what both find, benchmarks how long both take. Components that several machines change are followed as they
//! change, where the composition follows only what is certain.

use std::collections::HashMap;

use linewright_relations::{
    ComponentRef, ConditionId, Execution, InterlockTerm, InterlockedAction, MachineId, OperationId, OperationKind,
    RelatedOperation, Relations, ZoneId,
};

use crate::model::Mark;

/// An operation on a product, as it is called in every model: product, operation, way, whether it is left out.
pub type OperationKey = (usize, OperationId, Option<String>, bool);

/// What the monolithic way finds.
#[derive(Clone, Debug)]
pub struct Explored {
    /// States that the tables allow.
    pub reachable: usize,
    /// The states that are reached under supervision, as marks; none without a supervisor.
    pub supervised: Vec<Vec<(OperationKey, Mark)>>,
}

/// An operation of a place.
struct Task<'r> {
    instance: usize,
    /// Each with its machine.
    rows: Vec<(MachineId, &'r RelatedOperation)>,
    executions: Vec<&'r Execution>,
    way: Option<String>,
    is_left_out: bool,
    has_choice: bool,
}

const IDLE: u8 = 0;
const CHOSEN: u8 = 1;
const EXECUTING: u8 = 2;
const DONE: u8 = 3;
/// A component whose state is unknown, and one that is being changed.
const UNKNOWN: u8 = 254;
const MOVING: u8 = 255;

/// The automata side by side.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct State {
    tasks: Vec<u8>,
    /// Places that each machine has done.
    places: Vec<u8>,
    /// Of each zone: 0 for free, or its machine from 1.
    zones: Vec<u8>,
    components: Vec<u8>,
}

/// A step: the task, what it is then, whether a supervisor can hold it back.
type Step = (usize, u8, bool);

struct Automata<'r> {
    relations: &'r Relations,
    products: &'r [ConditionId],
    tasks: Vec<Task<'r>>,
    /// For each machine its places, each with its tasks.
    machines: Vec<Vec<Vec<usize>>>,
    components: Vec<ComponentRef>,
}

/// Explores a cell with these products; none where there are more than `most` states.
pub fn explore(relations: &Relations, products: &[ConditionId], most: usize) -> Option<Explored> {
    let automata = Automata::of(relations, products);
    let first = automata.first();
    let mut numbers: HashMap<State, usize> = HashMap::from([(first.clone(), 0)]);
    let mut states = vec![first];
    let mut arcs: Vec<Vec<(usize, bool)>> = Vec::new();
    let mut is_good: Vec<bool> = Vec::new();
    while let Some(state) = states.get(arcs.len()).cloned() {
        let (mut own, mut good) = (Vec::new(), automata.requirements_hold(&state));
        for step in automata.possible(&state) {
            if !automata.is_allowed(&state, &step) {
                good &= step.2;
                continue;
            }
            let next = automata.after(&state, &step);
            let known = numbers.len();
            let number = *numbers.entry(next.clone()).or_insert(known);
            if number == known {
                states.push(next);
            }
            own.push((number, step.2));
        }
        arcs.push(own);
        is_good.push(good);
        if states.len() > most {
            return None;
        }
    }
    shrink(&arcs, &mut is_good, &states.iter().map(|state| automata.is_finished(state)).collect::<Vec<_>>());
    let mut reached = vec![false; states.len()];
    let mut open: Vec<usize> = is_good[0].then_some(0).into_iter().collect();
    let mut supervised = Vec::new();
    while let Some(of) = open.pop() {
        if !std::mem::replace(&mut reached[of], true) {
            supervised.push(automata.marks(&states[of]));
            open.extend(arcs[of].iter().map(|(to, _)| *to).filter(|to| is_good[*to]));
        }
    }
    Some(Explored { reachable: states.len(), supervised })
}

/// Takes states away until from each that remains the end is reached, and nothing leads out by itself.
fn shrink(arcs: &[Vec<(usize, bool)>], is_good: &mut [bool], is_finished: &[bool]) {
    loop {
        let mut ends: Vec<bool> = (0..arcs.len()).map(|of| is_good[of] && is_finished[of]).collect();
        loop {
            let more: Vec<usize> = (0..arcs.len())
                .filter(|of| is_good[*of] && !ends[*of] && arcs[*of].iter().any(|(to, _)| ends[*to]))
                .collect();
            if more.is_empty() {
                break;
            }
            more.into_iter().for_each(|of| ends[of] = true);
        }
        let stays = |of: usize| ends[of] && arcs[of].iter().all(|(to, is_controllable)| *is_controllable || ends[*to]);
        let next: Vec<bool> = (0..arcs.len()).map(stays).collect();
        if next == is_good {
            return;
        }
        is_good.copy_from_slice(&next);
    }
}

impl<'r> Automata<'r> {
    fn of(relations: &'r Relations, products: &'r [ConditionId]) -> Self {
        let mut tasks: Vec<Task<'r>> = Vec::new();
        let mut parallel: HashMap<(usize, &str), usize> = HashMap::new();
        let mut machines = Vec::new();
        for machine in (0..relations.machines.len()).map(MachineId) {
            let mut places = Vec::new();
            for (instance, condition) in products.iter().enumerate() {
                let Some(sequence) = relations.sequence(*condition, machine) else { continue };
                for element in &sequence.elements {
                    let mut place = Vec::new();
                    for row in &element.alternatives {
                        if row.kind == OperationKind::Exception && row.group.is_none() {
                            continue;
                        }
                        let group = row.group.as_deref().filter(|_| row.kind == OperationKind::Parallel);
                        if let Some(known) = group.and_then(|group| parallel.get(&(instance, group))) {
                            tasks[*known].rows.push((machine, row));
                            tasks[*known].executions.extend(relations.ways(row.operation));
                            place.push(*known);
                            continue;
                        }
                        let ways: Vec<&Execution> = relations.ways(row.operation).collect();
                        let groups: Vec<Vec<&Execution>> =
                            if ways.len() > 1 { ways.into_iter().map(|way| vec![way]).collect() } else { vec![ways] };
                        let has_ways = groups.len() > 1;
                        for executions in groups {
                            let way = executions.first().filter(|_| has_ways).and_then(|way| way.way.clone());
                            place.push(tasks.len());
                            parallel.extend(group.map(|group| ((instance, group), tasks.len())));
                            let rows = vec![(machine, row)];
                            tasks.push(Task { instance, rows, executions, way, is_left_out: false, has_choice: false });
                        }
                        if relations.operation(row.operation).every > 1 {
                            place.push(tasks.len());
                            let (rows, executions) = (vec![(machine, row)], Vec::new());
                            tasks.push(Task {
                                instance,
                                rows,
                                executions,
                                way: None,
                                is_left_out: true,
                                has_choice: false,
                            });
                        }
                    }
                    if place.len() > 1 {
                        place.iter().for_each(|task: &usize| tasks[*task].has_choice = true);
                    }
                    if !place.is_empty() {
                        places.push(place);
                    }
                }
            }
            machines.push(places);
        }
        let all = relations.machines.iter().enumerate();
        let components = all.flat_map(|(machine, of)| {
            (0..of.components.len()).map(move |component| ComponentRef { machine: MachineId(machine), component })
        });
        Automata { relations, products, tasks, machines, components: components.collect() }
    }

    fn first(&self) -> State {
        let state = |component: &ComponentRef| {
            let sequence = self.relations.sequence(*self.products.first()?, component.machine)?;
            let home = self.relations.ways(sequence.elements[0].alternatives[0].operation).next()?;
            home.initial.state(*component).flatten()
        };
        let number = |component: &ComponentRef| {
            state(component).map_or(UNKNOWN, |state| u8::try_from(state.0).unwrap_or(UNKNOWN))
        };
        State {
            tasks: vec![IDLE; self.tasks.len()],
            places: vec![0; self.machines.len()],
            zones: vec![0; self.relations.zones.len()],
            components: self.components.iter().map(number).collect(),
        }
    }

    fn is_finished(&self, state: &State) -> bool {
        self.machines.iter().zip(&state.places).all(|(places, done)| usize::from(*done) == places.len())
    }

    /// Whether every machine of a task is at its place.
    fn is_its_turn(&self, state: &State, task: usize) -> bool {
        self.tasks[task].rows.iter().all(|(machine, _)| {
            let place = self.machines[machine.0].get(usize::from(state.places[machine.0]));
            place.is_some_and(|place| place.contains(&task))
        })
    }

    /// The steps that are possible, allowed or not.
    fn possible(&self, state: &State) -> Vec<Step> {
        let mut steps = Vec::new();
        for (nth, task) in self.tasks.iter().enumerate() {
            match state.tasks[nth] {
                IDLE if task.has_choice => {
                    let (machine, _) = task.rows[0];
                    let place = self.machines[machine.0].get(usize::from(state.places[machine.0]));
                    let is_open = place.is_some_and(|place| place.iter().all(|other| state.tasks[*other] == IDLE));
                    if self.is_its_turn(state, nth) && is_open && self.fits(state, task) {
                        steps.push((nth, CHOSEN, false));
                    }
                }
                IDLE | CHOSEN => {
                    let is_free = task.rows.iter().any(|(_, row)| row.kind == OperationKind::Uncontrolled);
                    let begins =
                        self.is_its_turn(state, nth) && (!is_free || task.is_left_out || self.preceded(state, task));
                    if begins {
                        steps.push((nth, EXECUTING, !is_free && !task.is_left_out));
                    }
                }
                EXECUTING => steps.push((nth, DONE, false)),
                _ => {}
            }
        }
        steps
    }

    /// Whether the states of components are those in which a way can begin.
    fn fits(&self, state: &State, task: &Task<'_>) -> bool {
        let fits = |way: &&Execution| {
            way.initial.states.iter().all(|(of, wanted)| match (wanted, self.component(state, *of)) {
                (None, _) | (Some(_), UNKNOWN) => true,
                (Some(wanted), is) => usize::from(is) == wanted.0,
            })
        };
        task.executions.is_empty() || task.executions.iter().any(fits)
    }

    fn component(&self, state: &State, of: ComponentRef) -> u8 {
        let number = self.components.iter().position(|component| *component == of);
        number.map_or(UNKNOWN, |number| state.components[number])
    }

    fn preceded(&self, state: &State, task: &Task<'_>) -> bool {
        let is_finished = |operation: OperationId| {
            self.tasks.iter().zip(&state.tasks).any(|(other, is)| {
                other.instance == task.instance
                    && *is == DONE
                    && other.rows.iter().any(|(_, row)| row.operation == operation)
            })
        };
        task.rows.iter().all(|(_, row)| row.after.holds(&is_finished))
    }

    fn is_allowed(&self, state: &State, (nth, to, _): &Step) -> bool {
        let task = &self.tasks[*nth];
        if *to != EXECUTING || task.is_left_out {
            return true;
        }
        let own: Vec<usize> = task.rows.iter().map(|(machine, _)| machine.0 + 1).collect();
        let is_free = |zone: &ZoneId| {
            let holder = usize::from(state.zones[zone.0]);
            holder == 0 || own.contains(&holder)
        };
        self.preceded(state, task)
            && task.rows.iter().all(|(_, row)| row.zones_before.iter().all(is_free))
            && self.interlocks_hold(state, *nth, true)
    }

    fn requirements_hold(&self, state: &State) -> bool {
        (0..self.tasks.len()).all(|nth| state.tasks[nth] != EXECUTING || self.interlocks_hold(state, nth, false))
    }

    fn interlocks_hold(&self, state: &State, nth: usize, at_start: bool) -> bool {
        let task = &self.tasks[nth];
        let product = self.relations.conditions[self.products[task.instance].0].product.as_ref();
        self.relations.interlocks.iter().all(|interlock| {
            let terms: Vec<&InterlockTerm> = interlock
                .terms
                .iter()
                .filter(|term| term.is_automatic && (term.product.is_none() || term.product.as_ref() == product))
                .collect();
            match &interlock.action {
                InterlockedAction::Operation { operation, way } => {
                    let is_it = !task.is_left_out && task.rows.iter().any(|(_, row)| row.operation == *operation);
                    let is_way = way.is_none() || *way == task.way;
                    !(is_it && is_way) || terms.iter().any(|term| self.term_holds(state, nth, term, at_start))
                }
                InterlockedAction::State { component, to } => task.executions.iter().all(|way| {
                    let steps: Vec<_> = way.steps().collect();
                    steps.windows(2).all(|pair| {
                        let is_ordered = pair[1].state(*component) == Some(Some(*to))
                            && pair[0].state(*component) != Some(Some(*to));
                        let is_internal = |term: &&&InterlockTerm| {
                            let own = term.states.iter().filter(|state| state.component.machine == component.machine);
                            own.into_iter().all(|state| pair[0].state(state.component) == Some(Some(state.state)))
                        };
                        !is_ordered
                            || terms.iter().filter(is_internal).any(|term| self.term_holds(state, nth, term, at_start))
                    })
                }),
            }
        })
    }

    fn term_holds(&self, state: &State, nth: usize, term: &InterlockTerm, at_start: bool) -> bool {
        let task = &self.tasks[nth];
        let others = |operations: &[OperationId], is_same_product: bool, is_wrong: &dyn Fn(u8) -> bool| {
            self.tasks.iter().enumerate().any(|(other, of)| {
                other != nth
                    && !of.is_left_out
                    && (!is_same_product || of.instance == task.instance)
                    && of.rows.iter().any(|(_, row)| operations.contains(&row.operation))
                    && is_wrong(state.tasks[other])
            })
        };
        let is_own = |of: ComponentRef| task.rows.iter().any(|(machine, _)| *machine == of.machine);
        let external =
            term.states.iter().filter(|wanted| !is_own(wanted.component) && (at_start || !wanted.is_initial));
        external.into_iter().all(|wanted| usize::from(self.component(state, wanted.component)) == wanted.state.0)
            && !others(&term.not_started, true, &|is| is >= EXECUTING)
            && !others(&term.not_ongoing, false, &|is| is == EXECUTING)
    }

    fn after(&self, state: &State, (nth, to, _): &Step) -> State {
        let (mut next, task) = (state.clone(), &self.tasks[*nth]);
        next.tasks[*nth] = *to;
        if *to == CHOSEN {
            return next;
        }
        for (machine, row) in &task.rows {
            if *to == DONE {
                next.places[machine.0] += 1;
            }
            if task.is_left_out {
                continue;
            }
            for zone in &row.zones_before {
                let is_kept = *to == EXECUTING || row.zones_after.contains(zone);
                next.zones[zone.0] = if is_kept { u8::try_from(machine.0 + 1).unwrap_or(u8::MAX) } else { 0 };
            }
        }
        for way in &task.executions {
            for (number, component) in self.components.iter().enumerate() {
                let states: Vec<_> = way.steps().filter_map(|step| step.state(*component)).collect();
                if states.windows(2).any(|pair| pair[0] != pair[1]) {
                    let last = states.last().copied().flatten();
                    let last = last.map_or(UNKNOWN, |last| u8::try_from(last.0).unwrap_or(UNKNOWN));
                    next.components[number] = if *to == EXECUTING { MOVING } else { last };
                }
            }
        }
        next
    }

    fn marks(&self, state: &State) -> Vec<(OperationKey, Mark)> {
        let mut marks = Vec::new();
        for (task, is) in self.tasks.iter().zip(&state.tasks) {
            let key = (task.instance, task.rows[0].1.operation, task.way.clone(), task.is_left_out);
            let set = [(CHOSEN, Mark::Chosen), (EXECUTING, Mark::Started), (DONE, Mark::Finished)];
            let set = set.into_iter().filter(|(from, mark)| is >= from && (task.has_choice || *mark != Mark::Chosen));
            marks.extend(set.map(|(_, mark)| (key.clone(), mark)));
        }
        marks.sort();
        marks
    }
}
