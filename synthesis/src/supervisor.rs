//! Supervisors: what they add to the relations, and the coordinated operations of each machine.

use linewright_relations::{ConditionId, Relations};
use oxidd::BooleanFunction;
use oxidd::util::OutOfMemory;

use crate::compose::compose;
use crate::conflict::{Contradiction, explain};
use crate::cops::{CoordinatedSequence, coordinated};
use crate::fixpoint::{Controlled, control};
use crate::guard::{AddedGuard, readable};
use crate::lock::{Trap, way_into_trap};
use crate::model::{Composition, Nth, Restriction};
use crate::symbolic::{Diagrams, without};

/// How far a synthesis may go.
#[derive(Clone, Copy, Debug)]
pub struct SynthesisLimits {
    /// Most nodes of decision diagrams, in each order of variables that is tried.
    pub nodes: usize,
}

impl Default for SynthesisLimits {
    fn default() -> Self {
        // About 1 GiB with its tables.
        SynthesisLimits { nodes: 1 << 24 }
    }
}

/// It is too large for its limits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TooLarge {
    pub nodes: usize,
    /// Operations, counted for each product.
    pub operations: usize,
    /// Orders of variables that were tried.
    pub orders: Vec<&'static str>,
    /// Steps of the computation in the order that came farthest.
    pub steps: u64,
}

impl std::fmt::Display for TooLarge {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let TooLarge { nodes, operations, orders, steps } = self;
        write!(
            f,
            "{operations} operations at once are too large: decision diagrams have more than {nodes} nodes, in the orders {}, after \
             {steps} steps at best",
            orders.join(", ")
        )
    }
}

impl std::error::Error for TooLarge {}

/// What synthesis has found for a number of products.
#[derive(Clone, Debug, PartialEq)]
pub enum Synthesis {
    Supervisor(Box<Supervisor>),
    Contradiction(Box<Contradiction>),
}

/// Sizes of a synthesis. Nodes and steps do not depend on the machine that it runs on.
#[derive(Clone, Debug, PartialEq)]
pub struct SynthesisSizes {
    /// Operations, counted for each product.
    pub operations: usize,
    /// Variables of the decision diagrams.
    pub variables: usize,
    /// States that the tables allow.
    pub reachable: f64,
    /// States that are reached under supervision.
    pub supervised: f64,
    /// Nodes of the largest set of states on the way.
    pub peak_nodes: usize,
    /// Images and preimages.
    pub steps: u64,
    /// The order of variables.
    pub order: &'static str,
}

/// A condition that a supervisor adds to the start of an operation, and what it prevents.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AddedPredecessor {
    /// Number in [`Composition::operations`].
    pub of: Nth,
    pub guard: AddedGuard,
    pub reason: Trap,
}

/// A supervisor: non-blocking, and as permissive as possible.
#[derive(Clone, Debug, PartialEq)]
pub struct Supervisor {
    /// The condition of each product, the first that came first.
    pub products: Vec<ConditionId>,
    pub composition: Composition,
    /// In the order of the work.
    pub added: Vec<AddedPredecessor>,
    /// For each product and machine.
    pub coordinated: Vec<CoordinatedSequence>,
    pub sizes: SynthesisSizes,
}

/// Synthesises the supervisor of a cell with these products in it, of which the first came first, or finds out why there is none.
///
/// # Errors
/// [`TooLarge`] where it is, in every order of variables.
pub fn synthesise(
    relations: &Relations,
    products: &[ConditionId],
    limits: &SynthesisLimits,
) -> Result<Synthesis, TooLarge> {
    let composition = compose(relations, products, &|_| false);
    let found = within_limits(&composition, limits, &mut |diagrams, order| {
        let controlled = control(diagrams, &composition)?;
        if !controlled.supervised.satisfiable() {
            return Ok(None);
        }
        let added = added(diagrams, &composition, &controlled)?;
        let sizes = sizes(diagrams, &composition, &controlled, order);
        Ok(Some((added, sizes)))
    })?;
    let Some((added, sizes)) = found else {
        return Ok(Synthesis::Contradiction(Box::new(explain(relations, products, &composition, limits)?)));
    };
    let coordinated = coordinated(relations, products, &composition, &added);
    let products = products.to_vec();
    Ok(Synthesis::Supervisor(Box::new(Supervisor { products, composition, added, coordinated, sizes })))
}

/// Whether there is a supervisor without some of the restrictions.
pub(crate) fn exists(
    relations: &Relations,
    products: &[ConditionId],
    is_left_out: &impl Fn(&Restriction) -> bool,
    limits: &SynthesisLimits,
) -> Result<bool, TooLarge> {
    let composition = compose(relations, products, is_left_out);
    within_limits(&composition, limits, &mut |diagrams, _| {
        Ok(control(diagrams, &composition)?.supervised.satisfiable())
    })
}

/// Computes with diagrams in several orders of variables, each with few nodes first.
pub(crate) fn within_limits<T>(
    composition: &Composition,
    limits: &SynthesisLimits,
    compute: &mut dyn FnMut(&mut Diagrams, &'static str) -> Result<T, OutOfMemory>,
) -> Result<T, TooLarge> {
    let orders = orders(composition);
    let mut steps = 0;
    // Eight times as many each time: what fits in few is found soon, in whichever order.
    let variables = 2 * composition.operations.len();
    let mut nodes = (NODES_FIRST * variables).clamp(1 << 14, 1 << 20).min(limits.nodes);
    loop {
        for (name, order) in &orders {
            let Ok(mut diagrams) = Diagrams::new(composition, order, nodes) else { continue };
            if let Ok(found) = compute(&mut diagrams, name) {
                return Ok(found);
            }
            steps = steps.max(diagrams.steps);
        }
        if nodes == limits.nodes {
            let orders = orders.iter().map(|(name, _)| *name).collect();
            return Err(TooLarge { nodes, operations: composition.operations.len(), orders, steps });
        }
        nodes = (8 * nodes).min(limits.nodes);
    }
}

/// Up to so many states are looked at for the shortest way from a start into a deadlock.
const STATES_MAX: usize = 500;

/// Nodes for each variable that every order has first.
const NODES_FIRST: usize = 1 << 12;

/// Orders of variables that are worth trying: which is best depends on the cell.
fn orders(composition: &Composition) -> Vec<(&'static str, Vec<Nth>)> {
    let machine = |of: Nth| composition.operations[of].machines[0];
    let sorted = |key: &dyn Fn(Nth) -> (usize, usize, usize)| {
        let mut order: Vec<Nth> = (0..composition.operations.len()).collect();
        order.sort_by_key(|of| key(*of));
        order
    };
    let operation = |of: Nth| &composition.operations[of];
    vec![
        ("machine, product", sorted(&|of| (machine(of).0, operation(of).instance, operation(of).depth))),
        ("product, work", sorted(&|of| (operation(of).instance, operation(of).depth, machine(of).0))),
        ("product, machine", sorted(&|of| (operation(of).instance, machine(of).0, operation(of).depth))),
        ("work", sorted(&|of| (operation(of).depth, operation(of).instance, machine(of).0))),
    ]
}

/// The events that a supervisor restricts.
fn added(
    diagrams: &mut Diagrams,
    composition: &Composition,
    controlled: &Controlled<'_>,
) -> Result<Vec<AddedPredecessor>, OutOfMemory> {
    let mut added = Vec::new();
    for event in controlled.events.iter().filter(|event| event.event.is_controllable) {
        let enabled = controlled.supervised.and(&event.enabled)?;
        let good = diagrams.preimage(event, &controlled.good)?;
        let (allow, forbid) = (enabled.and(&good)?, without(&enabled, &good)?);
        let Some(mut state) = diagrams.pick(&forbid) else { continue };
        let guard = readable(diagrams, composition, &allow, &forbid)?;
        state.insert((event.event.of, event.event.mark));
        let is_lost = |state: &_| !diagrams.has(&controlled.good, state);
        let nothing = Trap { way: Vec::new(), is_shortest: false, locked: Vec::new(), violated: None };
        let reason = way_into_trap(composition, &state, &is_lost, STATES_MAX).unwrap_or(nothing);
        added.push(AddedPredecessor { of: event.event.of, guard, reason });
    }
    Ok(added)
}

fn sizes(
    diagrams: &Diagrams,
    composition: &Composition,
    controlled: &Controlled<'_>,
    order: &'static str,
) -> SynthesisSizes {
    SynthesisSizes {
        operations: composition.operations.len(),
        variables: diagrams.variables(),
        reachable: diagrams.count(&controlled.reachable),
        supervised: diagrams.count(&controlled.supervised),
        peak_nodes: diagrams.peak_nodes,
        steps: diagrams.steps,
        order,
    }
}

/// Products that can be in a cell at once: for each work cycle every sequence of its conditions, up to as many as fit in the cell.
/// None where there are more than `most`.
pub fn combinations(relations: &Relations, most: usize) -> Option<Vec<Vec<ConditionId>>> {
    let mut cycles: Vec<u32> = relations.conditions.iter().map(|condition| condition.cycle).collect();
    cycles.sort_unstable();
    cycles.dedup();
    let mut all: Vec<Vec<ConditionId>> = Vec::new();
    for cycle in cycles {
        let of_cycle = relations.conditions.iter().enumerate().filter(|(_, condition)| condition.cycle == cycle);
        let own: Vec<ConditionId> = of_cycle.map(|(nth, _)| ConditionId(nth)).collect();
        let mut longest: Vec<Vec<ConditionId>> = vec![Vec::new()];
        for _ in 0..relations.products_max {
            longest =
                longest.iter().flat_map(|products| own.iter().map(|next| [&products[..], &[*next]].concat())).collect();
            all.extend(longest.iter().cloned());
            if all.len() > most {
                return None;
            }
        }
    }
    Some(all)
}
