//! Safety specifications: interlocks as conditions on operations, in the three steps of Richardsson, Andersson, Fabian §V.D.
//!
//! 1. Of the automatic terms of an action count those whose internal states the execution fulfils before it.
//! 2. The state of a component of another machine follows from the operations that change it: it is there where it was there from
//!    the beginning, or an operation has brought it about, and since every operation that takes it away one has that brings it back.
//! 3. Operations that have not started, and that are not going on, are marks.

use linewright_relations::{
    ComponentRef, ComponentState, ConditionId, Execution, ExecutionStep, Interlock, InterlockTerm, InterlockedAction,
    MachineId, Relations,
};

use super::{Draft, all, any};
use crate::model::{Mark, Nth, Predicate, Requirement, Restriction};

/// An operation that changes a component.
struct Changer {
    of: Nth,
    /// It leaves the component in the state that is asked for.
    is_safe: bool,
    /// The component is in another state at some time.
    is_unsafe: bool,
}

impl Draft<'_> {
    /// The executions of an operation: that of its way, or all.
    fn executions(&self, of: Nth) -> Vec<&Execution> {
        let operation = &self.operations[of];
        if operation.is_left_out {
            return Vec::new();
        }
        let ways = operation.operations.iter().flat_map(|id| self.relations.ways(*id));
        ways.filter(|way| operation.way.is_none() || way.way == operation.way).collect()
    }

    /// Interlocks of the actions of an operation: at its start, or the parts that hold all the time.
    pub(super) fn interlocks(&self, of: Nth, at_start: bool) -> Vec<(Restriction, Predicate)> {
        let operation = &self.operations[of];
        let product = self.relations.conditions[self.products[operation.instance].0].product.as_deref();
        let mut found = Vec::new();
        if operation.is_left_out {
            return found;
        }
        for (nth, interlock) in self.relations.interlocks.iter().enumerate() {
            let is_of_product = |term: &&&InterlockTerm| term.product.is_none() || term.product.as_deref() == product;
            for terms in self.fulfilled(of, interlock) {
                let terms = terms.iter().filter(is_of_product);
                let terms = any(terms.map(|term| self.term(of, term, at_start)));
                found.push((Restriction::Interlock(nth), terms));
            }
        }
        found.retain(|(_, part)| *part != Predicate::Const(true));
        found
    }

    /// The automatic terms that count, once for each time that an operation does the action.
    fn fulfilled<'i>(&self, of: Nth, interlock: &'i Interlock) -> Vec<Vec<&'i InterlockTerm>> {
        let automatic = || interlock.terms.iter().filter(|term| term.is_automatic);
        match &interlock.action {
            InterlockedAction::Operation { operation, way } => {
                let is_it = self.operations[of].operations.contains(operation);
                let is_way = way.is_none() || *way == self.operations[of].way;
                if is_it && is_way { vec![automatic().collect()] } else { Vec::new() }
            }
            InterlockedAction::State { component, to } => {
                let mut times = Vec::new();
                for way in self.executions(of) {
                    let steps: Vec<&ExecutionStep> = way.steps().collect();
                    for pair in steps.windows(2).filter(|pair| orders(pair, *component, *to)) {
                        let terms = automatic().filter(|term| has_internal(term, pair[0], component.machine));
                        times.push(terms.collect());
                    }
                }
                times
            }
        }
    }

    fn term(&self, of: Nth, term: &InterlockTerm, at_start: bool) -> Predicate {
        let instance = self.operations[of].instance;
        let own = &self.operations[of].machines;
        let external = term.states.iter().filter(|state| !own.contains(&state.component.machine));
        let external = external.filter(|state| at_start || !state.is_initial);
        let states = external.map(|state| self.is_in(of, state.component, state.state, false));
        let not_started = term.not_started.iter().flat_map(|id| self.done_by(instance, *id));
        let not_started = not_started.filter(|other| *other != of && !self.operations[*other].is_left_out);
        let not_started = not_started.map(|other| Predicate::Has(other, Mark::Started).negated());
        let instances = 0..self.products.len();
        let ongoing =
            instances.flat_map(|instance| term.not_ongoing.iter().flat_map(move |id| self.done_by(instance, *id)));
        let not_ongoing = ongoing.filter(|other| *other != of && !self.operations[*other].is_left_out);
        let not_ongoing = not_ongoing.map(|other| Predicate::executing(other).negated());
        all(states.chain(not_started).chain(not_ongoing))
    }

    /// Requirements that hold while an operation is going on.
    pub(super) fn requirements(&self) -> Vec<Requirement> {
        let mut requirements = Vec::new();
        for of in 0..self.operations.len() {
            for (restriction, terms) in self.interlocks(of, false) {
                let holds = any([Predicate::executing(of).negated(), terms]);
                requirements.push(Requirement { during: of, restriction, holds });
            }
        }
        requirements
    }

    /// That the states of components allow to choose an operation: those of the initial rows of its executions.
    pub(super) fn can_be_chosen(&self, of: Nth) -> Predicate {
        if self.operations[of].is_left_out {
            return Predicate::Const(true);
        }
        let ways = self.executions(of);
        if ways.is_empty() {
            return Predicate::Const(true);
        }
        any(ways.iter().map(|way| {
            let states = way.initial.states.iter().filter_map(|(component, state)| Some((*component, (*state)?)));
            all(states.map(|(component, state)| self.is_in(of, component, state, true)))
        }))
    }

    /// That a component is in a state, as far as it follows from operations other than `of`; `is_benefit`: where its first
    /// state is unknown, it may be in it.
    fn is_in(&self, of: Nth, component: ComponentRef, state: ComponentState, is_benefit: bool) -> Predicate {
        let changers = self.changers(of, component, state);
        let finished = |changer: &Changer| Predicate::Has(changer.of, Mark::Finished);
        let first = match home_state(self.relations, self.products, component) {
            Some(first) => first == state,
            None => is_benefit || changers.is_empty(),
        };
        let begin = match first {
            true => Predicate::Const(true),
            false => any(changers.iter().filter(|changer| changer.is_safe).map(finished)),
        };
        let since = changers.iter().filter(|changer| changer.is_unsafe).map(|changer| {
            let back = changers.iter().filter(|other| {
                other.is_safe && (other.of == changer.of || self.before[other.of].contains(&changer.of))
            });
            let not_started = Predicate::Has(changer.of, Mark::Started).negated();
            any(std::iter::once(not_started).chain(back.map(finished)))
        });
        all(std::iter::once(begin).chain(since))
    }

    fn changers(&self, of: Nth, component: ComponentRef, state: ComponentState) -> Vec<Changer> {
        let mut changers = Vec::new();
        for other in (0..self.operations.len()).filter(|other| *other != of) {
            let (mut is_safe, mut is_unsafe) = (false, false);
            for way in self.executions(other) {
                let states: Vec<_> = way.steps().filter_map(|step| step.state(component)).collect();
                let changes = states.windows(2).any(|pair| pair[0] != pair[1]);
                is_safe |= changes && way.last_state(component) == Some(state);
                is_unsafe |= changes && states.iter().any(|known| *known != Some(state));
            }
            if is_safe || is_unsafe {
                changers.push(Changer { of: other, is_safe, is_unsafe });
            }
        }
        changers
    }
}

/// Whether a step orders a component into a state that it was not in before.
fn orders(pair: &[&ExecutionStep], component: ComponentRef, to: ComponentState) -> bool {
    pair[1].state(component) == Some(Some(to)) && pair[0].state(component) != Some(Some(to))
}

/// Whether a row has the states of its machine that a term asks for.
fn has_internal(term: &InterlockTerm, before: &ExecutionStep, own: MachineId) -> bool {
    let internal = term.states.iter().filter(|state| state.component.machine == own);
    internal.into_iter().all(|state| before.state(state.component) == Some(Some(state.state)))
}

/// The state of a component at home; none where any will do.
fn home_state(relations: &Relations, products: &[ConditionId], component: ComponentRef) -> Option<ComponentState> {
    let sequence = relations.sequence(*products.first()?, component.machine)?;
    let home = relations.ways(sequence.elements[0].alternatives[0].operation).next()?;
    home.initial.state(component).flatten()
}
