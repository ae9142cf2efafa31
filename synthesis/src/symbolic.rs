//! Sets of states as decision diagrams, with one variable for each mark.
//!
//! An event sets one mark that was not set, so there are no variables for the state after it: what an event leads to is the set
//! where it is enabled, without its variable, and with that variable set.

use std::collections::BTreeMap;

use oxidd::bdd::{BDDFunction, BDDManagerRef, new_manager};
use oxidd::util::{OptBool, OutOfMemory, SatCountCache, num::F64};
use oxidd::{BooleanFunction, BooleanFunctionQuant, BooleanOperator, Function, Manager, ManagerRef};

use crate::model::{Composition, Mark, MarkSet, ModelEvent, Nth, Predicate};

/// A set of states; an error where the store is full.
pub(crate) type Set = Result<BDDFunction, OutOfMemory>;

/// An event as sets.
pub(crate) struct SymbolicEvent<'c> {
    pub event: &'c ModelEvent,
    pub variable: BDDFunction,
    /// Where it is possible, allowed or not.
    pub possible: BDDFunction,
    /// Where it is possible and allowed.
    pub enabled: BDDFunction,
}

/// A store of decision diagrams over the marks of a cell.
pub(crate) struct Diagrams {
    manager: BDDManagerRef,
    variables: BTreeMap<(Nth, Mark), (u32, BDDFunction)>,
    marks: Vec<(Nth, Mark)>,
    /// Nodes of the largest set.
    pub peak_nodes: usize,
    /// Steps of the computation: images and preimages.
    pub steps: u64,
}

impl Diagrams {
    /// A store for at most `nodes` nodes, whose variables have the order of `order`.
    pub fn new(composition: &Composition, order: &[Nth], nodes: usize) -> Result<Self, OutOfMemory> {
        let manager = new_manager(nodes, nodes.clamp(1 << 12, 1 << 22), 1);
        let is_chosen = |of: Nth| composition.events.iter().any(|event| event.of == of && event.mark == Mark::Chosen);
        let of = |of: Nth| {
            let chosen = is_chosen(of).then_some((of, Mark::Chosen));
            chosen.into_iter().chain([(of, Mark::Started), (of, Mark::Finished)])
        };
        let marks: Vec<(Nth, Mark)> = order.iter().flat_map(|nth| of(*nth)).collect();
        let variables = manager.with_manager_exclusive(|manager| {
            let numbers = manager.add_vars(u32::try_from(marks.len()).unwrap_or(u32::MAX));
            let variables = marks.iter().zip(numbers);
            let variables = variables.map(|(mark, number)| Ok((*mark, (number, BDDFunction::var(manager, number)?))));
            variables.collect::<Result<BTreeMap<_, _>, OutOfMemory>>()
        })?;
        Ok(Diagrams { manager, variables, marks, peak_nodes: 0, steps: 0 })
    }

    /// Number of variables.
    pub fn variables(&self) -> usize {
        self.marks.len()
    }

    /// All states, or none.
    pub fn constant(&self, value: bool) -> BDDFunction {
        self.manager
            .with_manager_shared(|manager| if value { BDDFunction::t(manager) } else { BDDFunction::f(manager) })
    }

    /// The states with a mark.
    pub fn variable(&self, of: Nth, mark: Mark) -> BDDFunction {
        self.variables.get(&(of, mark)).map_or_else(|| self.constant(false), |(_, variable)| variable.clone())
    }

    /// The marks, in the order of their variables.
    pub fn marks(&self) -> &[(Nth, Mark)] {
        &self.marks
    }

    /// The states in which a predicate holds.
    pub fn set(&self, predicate: &Predicate) -> Set {
        match predicate {
            Predicate::Const(value) => Ok(self.constant(*value)),
            Predicate::Has(of, mark) => Ok(self.variable(*of, *mark)),
            Predicate::Not(part) => self.set(part)?.not(),
            Predicate::All(parts) => parts.iter().try_fold(self.constant(true), |set, part| set.and(&self.set(part)?)),
            Predicate::Any(parts) => parts.iter().try_fold(self.constant(false), |set, part| set.or(&self.set(part)?)),
        }
    }

    /// The state in which nothing has happened.
    pub fn initial(&self) -> Set {
        let variables = self.variables.values().rev();
        variables.into_iter().try_fold(self.constant(true), |set, (_, variable)| set.and(&variable.not()?))
    }

    /// The events of a cell.
    pub fn events<'c>(&self, composition: &'c Composition) -> Result<Vec<SymbolicEvent<'c>>, OutOfMemory> {
        let sets = composition.events.iter().map(|event| {
            let possible = self.set(&event.possible)?;
            let parts = event.allowed.iter();
            let enabled = parts.into_iter().try_fold(possible.clone(), |set, (_, part)| set.and(&self.set(part)?))?;
            Ok(SymbolicEvent { event, variable: self.variable(event.of, event.mark), possible, enabled })
        });
        sets.collect()
    }

    /// The states that an event leads to from those of `of` that are in `enabled`.
    pub fn image(&mut self, event: &SymbolicEvent<'_>, enabled: &BDDFunction, of: &BDDFunction) -> Set {
        self.steps += 1;
        of.apply_exists(BooleanOperator::And, enabled, &event.variable)?.and(&event.variable)
    }

    /// The states from which an event leads into `to`, whether it is enabled or not.
    pub fn preimage(&mut self, event: &SymbolicEvent<'_>, to: &BDDFunction) -> Set {
        self.steps += 1;
        to.restrict(&event.variable)
    }

    /// Notes the size of a set.
    pub fn note(&mut self, set: &BDDFunction) {
        self.peak_nodes = self.peak_nodes.max(set.node_count());
    }

    /// Number of states.
    pub fn count(&self, set: &BDDFunction) -> f64 {
        let mut cache: SatCountCache<F64, std::hash::RandomState> = SatCountCache::default();
        set.sat_count(u32::try_from(self.marks.len()).unwrap_or(u32::MAX), &mut cache).0
    }

    /// A state of a set, with as few marks as a choice at each allows; none where it is empty.
    pub fn pick(&self, set: &BDDFunction) -> Option<MarkSet> {
        let cube = set.pick_cube(|_, _, _| false)?;
        let set = self.marks.iter().zip(cube).filter(|(_, value)| *value == OptBool::True);
        Some(set.map(|(mark, _)| *mark).collect())
    }

    /// Whether a state is in a set.
    pub fn has(&self, set: &BDDFunction, state: &MarkSet) -> bool {
        let values = self.variables.iter().map(|(mark, (number, _))| (*number, state.contains(mark)));
        set.eval(values)
    }
}

/// Whether two sets have a state in common.
pub(crate) fn meet(one: &BDDFunction, other: &BDDFunction) -> Result<bool, OutOfMemory> {
    Ok(one.and(other)?.satisfiable())
}

/// The states of one set that are not in another.
pub(crate) fn without(one: &BDDFunction, other: &BDDFunction) -> Set {
    one.and(&other.not()?)
}
