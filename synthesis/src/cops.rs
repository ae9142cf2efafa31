//! Coordinated operations (COP): the order of each machine for each product, with what a supervisor adds.

use linewright_relations::{ConditionId, MachineId, OperationId, Precondition, Relations, TableRow};

use crate::guard::AddedGuard;
use crate::model::Composition;
use crate::supervisor::AddedPredecessor;

/// The coordinated operations of a machine for one product.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CoordinatedSequence {
    /// The product, from 0 for the one that came first.
    pub instance: usize,
    pub machine: MachineId,
    pub steps: Vec<CoordinatedStep>,
}

/// An operation of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CoordinatedStep {
    /// Alternatives of the same place have the same number.
    pub place: usize,
    pub operation: OperationId,
    /// Predecessors of the relations, on the same product.
    pub after: Precondition,
    /// What the supervisor adds, for each way of the operation that it adds anything to.
    pub added: Vec<(Option<String>, AddedGuard)>,
    pub row: TableRow,
}

/// The coordinated operations of every machine for every product. Operations that were taken apart for the synthesis are whole
/// again: ways are one operation, and those done at once are one of each machine.
pub(crate) fn coordinated(
    relations: &Relations,
    products: &[ConditionId],
    composition: &Composition,
    added: &[AddedPredecessor],
) -> Vec<CoordinatedSequence> {
    let mut all = Vec::new();
    for (instance, condition) in products.iter().enumerate() {
        for machine in (0..relations.machines.len()).map(MachineId) {
            let Some(sequence) = relations.sequence(*condition, machine) else { continue };
            let places = sequence.elements.iter().enumerate();
            let rows = places.flat_map(|(place, element)| element.alternatives.iter().map(move |row| (place, row)));
            let steps = rows.map(|(place, row)| {
                let own = added.iter().filter(|added| {
                    let operation = &composition.operations[added.of];
                    operation.instance == instance && operation.operations.contains(&row.operation)
                });
                let own = own.map(|added| (composition.operations[added.of].way.clone(), added.guard.clone()));
                let (operation, after) = (row.operation, row.after.clone());
                CoordinatedStep { place, operation, after, added: own.collect(), row: row.row }
            });
            all.push(CoordinatedSequence { instance, machine, steps: steps.collect() });
        }
    }
    all
}
