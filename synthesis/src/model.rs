//! The automata of a cell as marks and events: what synthesis works on.
//!
//! An operation on a product is chosen (where there is a choice), started, finished, in this order; each of these marks is a bit
//! that is set by one event and never taken back. So every run ends, and whatever does not end with everything finished is locked.
//! Automata of machines and zones need no bits of their own: their states follow from those of the operations.

use linewright_relations::{MachineId, OperationId, TableRow, ZoneId};

/// Number of an operation on a product in [`Composition::operations`].
pub type Nth = usize;

/// A mark of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Mark {
    /// Of several alternatives or ways, the states of components have chosen this one.
    Chosen,
    Started,
    Finished,
}

/// A condition on marks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Predicate {
    Const(bool),
    Has(Nth, Mark),
    Not(Box<Predicate>),
    All(Vec<Predicate>),
    Any(Vec<Predicate>),
}

impl Predicate {
    /// The opposite.
    pub fn negated(self) -> Predicate {
        Predicate::Not(Box::new(self))
    }

    /// That an operation is going on.
    pub fn executing(of: Nth) -> Predicate {
        Predicate::All(vec![Predicate::Has(of, Mark::Started), Predicate::Has(of, Mark::Finished).negated()])
    }

    /// Its value where marks have the values of `mark`; `None` where it depends on those that have none.
    pub fn value(&self, mark: &impl Fn(Nth, Mark) -> Option<bool>) -> Option<bool> {
        let joined = |parts: &[Predicate], decides: bool| {
            let mut is_open = false;
            for part in parts {
                match part.value(mark) {
                    Some(value) if value == decides => return Some(decides),
                    Some(_) => {}
                    None => is_open = true,
                }
            }
            (!is_open).then_some(!decides)
        };
        match self {
            Predicate::Const(value) => Some(*value),
            Predicate::Has(of, kind) => mark(*of, *kind),
            Predicate::Not(part) => part.value(mark).map(|value| !value),
            Predicate::All(parts) => joined(parts, false),
            Predicate::Any(parts) => joined(parts, true),
        }
    }

    /// The operations that occur in it.
    pub fn operations(&self) -> Vec<Nth> {
        match self {
            Predicate::Const(_) => Vec::new(),
            Predicate::Has(of, _) => vec![*of],
            Predicate::Not(part) => part.operations(),
            Predicate::All(parts) | Predicate::Any(parts) => parts.iter().flat_map(Predicate::operations).collect(),
        }
    }
}

/// A restriction of the tables: without it more would be possible.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Restriction {
    /// The predecessors in this row of the relations.
    Predecessors(TableRow),
    /// That a machine waits for a zone that another one has. Without it others still wait for this one's.
    Booking(MachineId, ZoneId),
    /// The automatic terms of an interlock, by its number.
    Interlock(usize),
}

/// What is done on one product.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelOperation {
    /// The product, from 0 for the one that came first.
    pub instance: usize,
    /// One, or several that are done at once.
    pub operations: Vec<OperationId>,
    /// The way, where there are several.
    pub way: Option<String>,
    /// That the operation is left out in this cycle.
    pub is_left_out: bool,
    /// One for each of `operations`.
    pub machines: Vec<MachineId>,
    /// Length of the longest chain of operations before it: earlier ones are smaller.
    pub depth: usize,
}

/// An event: it sets one mark.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelEvent {
    pub of: Nth,
    pub mark: Mark,
    /// Whether a supervisor can hold it back.
    pub is_controllable: bool,
    /// When it is possible at all, the mark not being set included.
    pub possible: Predicate,
    /// What has to hold besides, each part with the restriction that it is.
    pub allowed: Vec<(Restriction, Predicate)>,
}

/// A requirement of every state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Requirement {
    /// The operation during which it holds.
    pub during: Nth,
    pub restriction: Restriction,
    pub holds: Predicate,
}

/// A cell with some products in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Composition {
    pub operations: Vec<ModelOperation>,
    /// Sorted by the depth of their operations.
    pub events: Vec<ModelEvent>,
    pub requirements: Vec<Requirement>,
    /// That every sequence is finished.
    pub finished: Predicate,
}

/// Marks that are set.
pub type MarkSet = std::collections::BTreeSet<(Nth, Mark)>;

impl ModelEvent {
    /// Whether it is possible in a state.
    pub fn is_possible(&self, state: &MarkSet) -> bool {
        holds(&self.possible, state)
    }

    /// Whether every restriction allows it in a state.
    pub fn is_allowed(&self, state: &MarkSet) -> bool {
        self.allowed.iter().all(|(_, part)| holds(part, state))
    }
}

/// The value of a predicate in a state.
pub fn holds(predicate: &Predicate, state: &MarkSet) -> bool {
    predicate.value(&|of, mark| Some(state.contains(&(of, mark)))) == Some(true)
}

impl Composition {
    /// The events that are possible and allowed in a state.
    pub fn enabled<'a>(&'a self, state: &'a MarkSet) -> impl Iterator<Item = &'a ModelEvent> {
        self.events.iter().filter(|event| event.is_possible(state) && event.is_allowed(state))
    }

    /// What is wrong in a state by itself: a requirement that does not hold, or something that nothing can hold back and that is
    /// not allowed.
    pub fn violated(&self, state: &MarkSet) -> Option<(Nth, &Restriction)> {
        let requirement = self.requirements.iter().find(|requirement| !holds(&requirement.holds, state));
        if let Some(requirement) = requirement {
            return Some((requirement.during, &requirement.restriction));
        }
        let free = self.events.iter().filter(|event| !event.is_controllable && event.is_possible(state));
        let mut not_allowed = free.filter_map(|event| {
            let broken = event.allowed.iter().find(|(_, part)| !holds(part, state));
            broken.map(|(restriction, _)| (event.of, restriction))
        });
        not_allowed.next()
    }
}
