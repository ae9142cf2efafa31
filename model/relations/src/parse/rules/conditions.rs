//! Conditions, and what is to be done in each.

use super::listed;
use crate::parse::findings::{DescribedPart, TableFindings};
use crate::{ConditionId, MachineId, Relations};

/// Every operation of a condition is in the relations of that condition, and no other (rule 3b).
pub(super) fn operations_are_related(relations: &Relations, findings: &mut TableFindings<'_>) {
    for (nth, operation) in relations.operations.iter().enumerate() {
        for condition in &operation.conditions {
            if !relations.related(*condition).any(|(_, row)| row.operation.0 == nth) {
                let name = &relations.conditions[condition.0].name;
                let message = format!("operation `{}` has no row in the relations of condition {name}", operation.id);
                let hint =
                    "all operations of a condition are done in it (rule 3): add a row, or take the condition away here";
                findings.error(operation.row, "id", message, hint);
            }
        }
    }
    for sequence in &relations.sequences {
        let name = &relations.conditions[sequence.condition.0].name;
        for row in sequence.rows() {
            let operation = relations.operation(row.operation);
            if !operation.conditions.contains(&sequence.condition) {
                let of = operation.conditions.iter().map(|condition| relations.conditions[condition.0].name.as_str());
                let message = format!("operation `{}` is not declared for condition {name}", operation.id);
                let hint = format!("{} declares it for {}", relations.place(operation.row), listed(of));
                findings.error(row.row, "conditions", message, hint);
            }
        }
    }
}

/// Every machine has a sequence in every condition: it completes one before the next begins (rule 7).
pub(super) fn every_machine_has_a_sequence(relations: &Relations, findings: &mut TableFindings<'_>) {
    for (nth, machine) in relations.machines.iter().enumerate() {
        let id = MachineId(nth);
        let without = (0..relations.conditions.len())
            .filter(|condition| relations.sequence(ConditionId(*condition), id).is_none());
        let without: Vec<&str> = without.map(|condition| relations.conditions[condition].name.as_str()).collect();
        if !without.is_empty() {
            let message = format!("{} has nothing to do in condition {}", machine.name, listed(without));
            let hint = "every machine completes a sequence before the next begins (rule 7), so that products keep their order: give \
                        it an operation without an action";
            findings.error_at(DescribedPart::Machine(id), message, hint);
        }
    }
}

/// Of two conditions of a work cycle at most one is valid at a time (rule 3e).
pub(super) fn start_conditions_differ(relations: &Relations, findings: &mut TableFindings<'_>) {
    for (nth, condition) in relations.conditions.iter().enumerate() {
        for other in &relations.conditions[..nth] {
            let differs = condition
                .states
                .iter()
                .any(|(of, state)| other.states.iter().any(|(component, known)| component == of && known != state));
            let has_product = condition.product.is_some() && other.product.is_some();
            let differs = differs || (has_product && condition.product != other.product);
            if !differs && condition.cycle == other.cycle {
                let message = format!("conditions {} and {} can be valid at once", other.name, condition.name);
                let hint = "each has states, or a product, that the other has not (rule 3)";
                findings.error_at(DescribedPart::Condition(ConditionId(nth)), message, hint);
            }
        }
    }
}

/// A machine has operations of its own alone (rule 2).
pub(super) fn rows_are_of_their_machine(relations: &Relations, findings: &mut TableFindings<'_>) {
    for sequence in &relations.sequences {
        for row in sequence.rows() {
            let operation = relations.operation(row.operation);
            if operation.machine != sequence.machine {
                let of = &relations.machine(operation.machine).name;
                let message = format!("operation `{}` is one of {of}", operation.id);
                let hint = format!(
                    "an operation is done by one machine (rule 2); {} declares it",
                    relations.place(operation.row)
                );
                findings.error(row.row, "machine", message, hint);
            }
        }
    }
}
