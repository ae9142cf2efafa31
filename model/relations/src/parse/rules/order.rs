//! The order of operations: sequences, groups, predecessors.

use std::collections::{BTreeMap, BTreeSet};

use super::listed;
use crate::parse::findings::TableFindings;
use crate::{ConditionId, MachineSequence, OperationId, OperationKind, RelatedOperation, Relations};

/// An operation stands once in a sequence, whose order is fixed (rule 3a).
pub(super) fn each_operation_stands_once(relations: &Relations, findings: &mut TableFindings<'_>) {
    for sequence in &relations.sequences {
        let mut known: BTreeMap<OperationId, &RelatedOperation> = BTreeMap::new();
        for row in sequence.rows() {
            if let Some(first) = known.insert(row.operation, row) {
                let name = &relations.operation(row.operation).id;
                let message = format!("operation `{name}` stands twice in one sequence");
                let hint =
                    format!("the first is in {}; declare an operation of its own (rule 3)", relations.place(first.row));
                findings.error(row.row, "operation", message, hint);
            }
        }
    }
}

/// Alternatives stand beside each other and are at least two (rule 3c); parallel operations are of several machines (rule 11).
pub(super) fn groups_are_whole(relations: &Relations, findings: &mut TableFindings<'_>) {
    for sequence in &relations.sequences {
        let mut ended: BTreeSet<&str> = BTreeSet::new();
        for element in &sequence.elements {
            let first = &element.alternatives[0];
            let group = first.group.as_deref();
            match first.kind {
                OperationKind::Alternative => {
                    if element.alternatives.iter().filter(|row| row.kind == OperationKind::Alternative).count() < 2 {
                        let message =
                            format!("operation `{}` has no alternative", relations.operation(first.operation).id);
                        let hint = "alternatives follow each other in rows with the same `group`, and one of them is done (rule 3)";
                        findings.error(first.row, "kind", message, hint);
                    }
                }
                OperationKind::Exception if element.alternatives.len() > 1 || group.is_none() => {}
                OperationKind::Exception => {
                    let message =
                        format!("no operation stands beside exception `{}`", relations.operation(first.operation).id);
                    let hint = "leave `group` empty where it is not scheduled; otherwise it follows an alternative of its group";
                    findings.error(first.row, "group", message, hint);
                }
                _ => continue,
            }
            if let Some(group) = group.filter(|group| !ended.insert(group)) {
                let message = format!("alternatives of group {group} do not follow each other");
                findings.error(first.row, "group", message, "put their rows below each other (rule 3)");
            }
        }
    }
    for condition in 0..relations.conditions.len() {
        parallel_groups(relations, ConditionId(condition), findings);
    }
}

fn parallel_groups(relations: &Relations, condition: ConditionId, findings: &mut TableFindings<'_>) {
    let mut groups: BTreeMap<Option<&str>, Vec<_>> = BTreeMap::new();
    for (machine, row) in relations.related(condition).filter(|(_, row)| row.kind == OperationKind::Parallel) {
        groups.entry(row.group.as_deref()).or_default().push((machine, row));
    }
    for (group, rows) in groups {
        let mut machines: Vec<_> = rows.iter().map(|(machine, _)| *machine).collect();
        machines.sort_unstable();
        machines.dedup();
        let (_, first) = rows[0];
        let name = &relations.operation(first.operation).id;
        if group.is_none() {
            let hint = "operations that are done at once have the same `group` (rule 11)";
            findings.error(first.row, "kind", format!("parallel operation `{name}` has no group"), hint);
        } else if machines.len() < rows.len() {
            let (machine, _) = rows[0];
            let message = format!("{} has two operations of one parallel group", relations.machine(machine).name);
            findings.error(first.row, "group", message, "a machine does one operation at a time (rule 2)");
        } else if rows.len() < 2 {
            let message = format!("no operation of another machine is parallel to `{name}`");
            findings.error(
                first.row,
                "group",
                message,
                "operations that are done at once have the same `group` (rule 11)",
            );
        }
    }
}

/// Predecessors are operations of the same condition that can be finished before (rule 4).
pub(super) fn predecessors_can_be_finished(relations: &Relations, findings: &mut TableFindings<'_>) {
    for condition in 0..relations.conditions.len() {
        let condition = ConditionId(condition);
        let name = &relations.conditions[condition.0].name;
        let order = Order::of(relations, condition);
        let mut is_possible = true;
        for sequence in relations.sequences.iter().filter(|sequence| sequence.condition == condition) {
            for row in sequence.rows() {
                let own = &relations.operation(row.operation).id;
                for other in row.after.operations() {
                    let id = &relations.operation(other).id;
                    if !relations.related(condition).any(|(_, row)| row.operation == other) {
                        let message = format!("operation `{id}` is not done in condition {name}");
                        let hint =
                            format!("`{own}` would wait for ever (rule 4): write its predecessors for each condition");
                        findings.error(row.row, "after", message, hint);
                    } else if is_later(sequence, row.operation, other) {
                        let machine = &relations.machine(sequence.machine).name;
                        let message =
                            format!("operation `{id}` does not come before `{own}` in the sequence of {machine}");
                        findings.error(row.row, "after", message, "a predecessor is finished before (rule 4)");
                        is_possible = false;
                    }
                }
            }
        }
        if is_possible {
            no_ring(relations, condition, &order, findings);
        }
    }
}

/// No operation waits for itself, directly or through others; each ring is reported once.
fn no_ring(relations: &Relations, condition: ConditionId, order: &Order, findings: &mut TableFindings<'_>) {
    for (_, row) in relations.related(condition) {
        let own = row.operation;
        let ring: Vec<_> = order.before(own).iter().filter(|other| order.before(**other).contains(&own)).collect();
        if ring.first() == Some(&&own) {
            let id = &relations.operation(own).id;
            let names = listed(ring.iter().map(|other| relations.operation(**other).id.as_str()));
            let hint =
                format!("{names} wait for each other, by their predecessors and the order of their machines (rule 4)");
            findings.error(row.row, "after", format!("operation `{id}` waits for itself"), hint);
        }
    }
}

/// Whether `other` stands at the place of `own` or behind it.
fn is_later(sequence: &MachineSequence, own: OperationId, other: OperationId) -> bool {
    let place = |of: OperationId| {
        sequence.elements.iter().position(|element| element.alternatives.iter().any(|row| row.operation == of))
    };
    matches!((place(own), place(other)), (Some(own), Some(other)) if other >= own)
}

/// What is certainly finished before each operation of a condition.
pub(super) struct Order {
    before: BTreeMap<OperationId, BTreeSet<OperationId>>,
}

impl Order {
    pub fn of(relations: &Relations, condition: ConditionId) -> Self {
        let mut before: BTreeMap<OperationId, BTreeSet<OperationId>> = BTreeMap::new();
        for sequence in relations.sequences.iter().filter(|sequence| sequence.condition == condition) {
            let mut earlier: BTreeSet<OperationId> = BTreeSet::new();
            for element in &sequence.elements {
                for row in &element.alternatives {
                    let own = before.entry(row.operation).or_default();
                    own.extend(&earlier);
                    own.extend(row.after.required());
                }
                if let [row] = &element.alternatives[..] {
                    earlier.insert(row.operation);
                }
            }
        }
        let operations: Vec<OperationId> = before.keys().copied().collect();
        // Warshall's: what is before what is before.
        for middle in &operations {
            let through = before[middle].clone();
            for of in before.values_mut().filter(|of| of.contains(middle)) {
                of.extend(&through);
            }
        }
        Order { before }
    }

    /// What is certainly finished before an operation.
    pub fn before(&self, operation: OperationId) -> &BTreeSet<OperationId> {
        static NONE: BTreeSet<OperationId> = BTreeSet::new();
        self.before.get(&operation).unwrap_or(&NONE)
    }
}
