//! From relations to a [`Composition`]: automata of operations, machines and zones, machine sequences, relations, and safety
//! specifications (Richardsson, Andersson, Fabian, §V.B to D).

mod components;
mod zones;

use std::collections::{BTreeMap, BTreeSet};

use linewright_relations::{
    ConditionId, Execution, MachineId, OperationId, OperationKind, Precondition, RelatedOperation, Relations,
};

use crate::model::{Composition, Mark, ModelEvent, ModelOperation, Nth, Predicate, Restriction};

/// A place in the sequence of a machine, for one product.
pub(super) struct Place<'r> {
    pub instance: usize,
    pub machine: MachineId,
    /// Operations of which one is done here, each with its row; one that is left out has none.
    pub choices: Vec<(Nth, Option<&'r RelatedOperation>)>,
}

impl Place<'_> {
    /// That it is done.
    pub fn done(&self) -> Predicate {
        any(self.choices.iter().map(|(of, _)| Predicate::Has(*of, Mark::Finished)))
    }
}

/// A cell while it is composed.
pub(super) struct Draft<'r> {
    pub relations: &'r Relations,
    /// The condition of each product.
    pub products: &'r [ConditionId],
    pub operations: Vec<ModelOperation>,
    /// In the order in which each machine comes to them, machine by machine.
    pub places: Vec<Place<'r>>,
    /// For each operation those that are certainly finished before it.
    pub before: Vec<BTreeSet<Nth>>,
}

/// Composes the cell with these products, of which the first came first, without the restrictions that `is_left_out`.
pub fn compose(
    relations: &Relations,
    products: &[ConditionId],
    is_left_out: &impl Fn(&Restriction) -> bool,
) -> Composition {
    let mut draft = Draft { relations, products, operations: Vec::new(), places: Vec::new(), before: Vec::new() };
    draft.lay_out();
    draft.sort_by_depth();
    let mut events = Vec::new();
    for of in 0..draft.operations.len() {
        events.extend(draft.events_of(of));
    }
    for event in &mut events {
        event.allowed.retain(|(restriction, _)| !is_left_out(restriction));
    }
    events.sort_by_key(|event| (draft.operations[event.of].depth, event.of, event.mark));
    let mut requirements = draft.requirements();
    requirements.retain(|requirement| !is_left_out(&requirement.restriction));
    let finished = all(draft.places.iter().map(Place::done));
    Composition { finished, events, requirements, operations: draft.operations }
}

/// All restrictions of the tables that play a part with these products.
pub fn restrictions(of: &Composition) -> Vec<Restriction> {
    let allowed = of.events.iter().flat_map(|event| event.allowed.iter().map(|(restriction, _)| restriction));
    let required = of.requirements.iter().map(|requirement| &requirement.restriction);
    let all: BTreeSet<&Restriction> = allowed.chain(required).collect();
    all.into_iter().cloned().collect()
}

pub(super) fn all(parts: impl IntoIterator<Item = Predicate>) -> Predicate {
    let mut parts: Vec<Predicate> = parts.into_iter().filter(|part| *part != Predicate::Const(true)).collect();
    match parts.len() {
        0 => Predicate::Const(true),
        1 => parts.remove(0),
        _ => Predicate::All(parts),
    }
}

pub(super) fn any(parts: impl IntoIterator<Item = Predicate>) -> Predicate {
    let mut parts: Vec<Predicate> = parts.into_iter().filter(|part| *part != Predicate::Const(false)).collect();
    match parts.len() {
        0 => Predicate::Const(false),
        1 => parts.remove(0),
        _ => Predicate::Any(parts),
    }
}

impl<'r> Draft<'r> {
    /// Makes the operations, and the places of the sequences.
    fn lay_out(&mut self) {
        let relations = self.relations;
        let mut parallel: BTreeMap<(usize, &str), Nth> = BTreeMap::new();
        for machine in 0..relations.machines.len() {
            let machine = MachineId(machine);
            for (instance, condition) in self.products.iter().enumerate() {
                let elements = relations.sequence(*condition, machine).map_or(&[][..], |sequence| &sequence.elements);
                for element in elements {
                    let mut choices = Vec::new();
                    for row in &element.alternatives {
                        match (row.kind, row.group.as_deref()) {
                            // It is not scheduled.
                            (OperationKind::Exception, None) => {}
                            (OperationKind::Parallel, Some(group)) => {
                                let known = parallel.get(&(instance, group)).copied();
                                let of = known.unwrap_or_else(|| self.add(instance, row, None));
                                parallel.insert((instance, group), of);
                                if known.is_some() {
                                    self.operations[of].operations.push(row.operation);
                                    self.operations[of].machines.push(machine);
                                }
                                choices.push((of, Some(row)));
                            }
                            _ => {
                                let ways: Vec<&Execution> = relations.ways(row.operation).collect();
                                if ways.len() < 2 {
                                    choices.push((self.add(instance, row, None), Some(row)));
                                }
                                for way in ways.iter().filter(|_| ways.len() > 1) {
                                    choices.push((self.add(instance, row, way.way.clone()), Some(row)));
                                }
                            }
                        }
                        if relations.operation(row.operation).every > 1 {
                            let left_out = self.add(instance, row, None);
                            self.operations[left_out].is_left_out = true;
                            choices.push((left_out, None));
                        }
                    }
                    if !choices.is_empty() {
                        self.places.push(Place { instance, machine, choices });
                    }
                }
            }
        }
    }

    fn add(&mut self, instance: usize, row: &RelatedOperation, way: Option<String>) -> Nth {
        let machine = self.relations.operation(row.operation).machine;
        self.operations.push(ModelOperation {
            instance,
            operations: vec![row.operation],
            way,
            is_left_out: false,
            machines: vec![machine],
            depth: 0,
        });
        self.operations.len() - 1
    }

    /// The place before another one of the same machine, of whichever product.
    fn previous(&self, place: usize) -> Option<&Place<'r>> {
        let before = place.checked_sub(1).map(|before| &self.places[before])?;
        (before.machine == self.places[place].machine).then_some(before)
    }

    /// The places of an operation: one for each of its machines.
    fn places_of(&self, of: Nth) -> impl Iterator<Item = (usize, &Place<'r>)> {
        let places = self.places.iter().enumerate();
        places.filter(move |(_, place)| place.choices.iter().any(|(choice, _)| *choice == of))
    }

    /// The rows of an operation, each with its machine.
    pub fn rows_of(&self, of: Nth) -> impl Iterator<Item = (MachineId, &'r RelatedOperation)> {
        self.places_of(of).filter_map(move |(_, place)| {
            let (_, row) = place.choices.iter().find(|(choice, _)| *choice == of)?;
            row.map(|row| (place.machine, row))
        })
    }

    /// What is certainly before what, and how long the chains are.
    fn sort_by_depth(&mut self) {
        let count = self.operations.len();
        let mut direct: Vec<BTreeSet<Nth>> = vec![BTreeSet::new(); count];
        // All that come right before, certain or not: for the depth.
        let mut near: Vec<BTreeSet<Nth>> = vec![BTreeSet::new(); count];
        let mut earlier: BTreeSet<Nth> = BTreeSet::new();
        for (nth, place) in self.places.iter().enumerate() {
            let previous = self.previous(nth);
            if previous.is_none() {
                earlier.clear();
            }
            for (of, row) in &place.choices {
                direct[*of].extend(&earlier);
                near[*of].extend(previous.iter().flat_map(|previous| previous.choices.iter().map(|(of, _)| *of)));
                let Some(row) = row else { continue };
                for operation in row.after.operations() {
                    near[*of].extend(self.done_by(place.instance, operation));
                }
                for operation in row.after.required() {
                    if let [only] = self.done_by(place.instance, operation)[..] {
                        direct[*of].insert(only);
                    }
                }
            }
            if let [(only, _)] = place.choices[..] {
                earlier.insert(only);
            }
        }
        for middle in 0..count {
            let through = direct[middle].clone();
            for before in direct.iter_mut().filter(|before| before.contains(&middle)) {
                before.extend(&through);
            }
        }
        self.before = direct;
        // As many rounds as the longest chain; a ring, which the tables cannot have among certain predecessors, ends it too.
        for _ in 0..count {
            let mut is_same = true;
            for (of, near) in near.iter().enumerate() {
                let depth = near.iter().map(|before| self.operations[*before].depth + 1).max().unwrap_or(0).min(count);
                is_same &= depth <= self.operations[of].depth;
                self.operations[of].depth = depth.max(self.operations[of].depth);
            }
            if is_same {
                break;
            }
        }
    }

    /// The operations of a product by which one of the tables is finished, left out or not.
    pub fn done_by(&self, instance: usize, operation: OperationId) -> Vec<Nth> {
        let is_it = |of: &ModelOperation| of.instance == instance && of.operations.contains(&operation);
        self.operations.iter().enumerate().filter(|(_, of)| is_it(of)).map(|(nth, _)| nth).collect()
    }

    fn precondition(&self, instance: usize, after: &Precondition) -> Predicate {
        match after {
            Precondition::Always => Predicate::Const(true),
            Precondition::Finished(operation) => {
                let done = self.done_by(instance, *operation);
                any(done.into_iter().map(|of| Predicate::Has(of, Mark::Finished)))
            }
            Precondition::All(parts) => all(parts.iter().map(|part| self.precondition(instance, part))),
            Precondition::Any(parts) => any(parts.iter().map(|part| self.precondition(instance, part))),
        }
    }

    /// The events of an operation.
    fn events_of(&self, of: Nth) -> Vec<ModelEvent> {
        let operation = &self.operations[of];
        let not = |mark: Mark| Predicate::Has(of, mark).negated();
        let turn =
            all(self.places_of(of).map(|(nth, _)| self.previous(nth).map_or(Predicate::Const(true), Place::done)));
        let others = self.places_of(of).flat_map(|(_, place)| place.choices.iter().map(|(other, _)| *other));
        let others: Vec<Nth> = others.filter(|other| *other != of).collect();
        let mut events = Vec::new();
        let mut begin = turn;
        if !others.is_empty() {
            let mut possible = vec![begin, not(Mark::Chosen)];
            possible.extend(others.iter().map(|other| Predicate::Has(*other, Mark::Chosen).negated()));
            possible.push(self.can_be_chosen(of));
            let (mark, possible, allowed) = (Mark::Chosen, all(possible), Vec::new());
            events.push(ModelEvent { of, mark, is_controllable: false, possible, allowed });
            begin = Predicate::Has(of, Mark::Chosen);
        }
        let is_free = self.rows_of(of).any(|(_, row)| row.kind == OperationKind::Uncontrolled);
        let is_controllable = !is_free && !operation.is_left_out;
        let mut possible = vec![begin, not(Mark::Started)];
        let mut allowed = Vec::new();
        for (machine, row) in self.rows_of(of) {
            if row.after != Precondition::Always {
                let after = self.precondition(operation.instance, &row.after);
                match is_free {
                    // They say when it may happen; nothing else holds it back.
                    true => possible.push(after),
                    false => allowed.push((Restriction::Predecessors(row.row), after)),
                }
            }
            for zone in &row.zones_before {
                for other in self.machines_of(*zone).into_iter().filter(|other| !operation.machines.contains(other)) {
                    let free = self.has_zone(other, *zone).negated();
                    allowed.push((Restriction::Booking(machine, *zone), free.clone()));
                }
            }
        }
        allowed.extend(self.interlocks(of, true));
        events.push(ModelEvent { of, mark: Mark::Started, is_controllable, possible: all(possible), allowed });
        let possible = all([Predicate::Has(of, Mark::Started), not(Mark::Finished)]);
        let (mark, allowed) = (Mark::Finished, Vec::new());
        events.push(ModelEvent { of, mark, is_controllable: false, possible, allowed });
        events
    }
}
