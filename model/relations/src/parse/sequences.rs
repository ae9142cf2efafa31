//! The relations of operations (ROP): the order of each machine, and what is finished first.

use linewright_text::{Located, Problem, suggestion};

use super::findings::TableFindings;
use super::{row, table};
use crate::{
    ConditionId, MachineId, MachineSequence, OperationId, OperationKind, Precondition, RelatedOperation, Relations,
    SequenceElement, ZoneId,
};

/// Its columns, those that must be there first.
pub(crate) const COLUMNS: [&str; 9] =
    ["machine", "operation", "after", "conditions", "kind", "group", "zones_before", "zones_after", "comment"];

/// Reads a table of relations. The order of its rows is the order of the work of each machine.
pub(super) fn read(file: usize, relations: &mut Relations, findings: &mut TableFindings<'_>) {
    let table = table::read(findings.sources[file].text, &COLUMNS, 3, false, &mut findings.reports[file]);
    let [Some(machine), Some(operation), Some(after)] = [0, 1, 2].map(|nth| table.column(COLUMNS[nth])) else { return };
    let machines: Vec<String> = relations.machines.iter().map(|machine| machine.name.clone()).collect();
    let operations: Vec<String> = relations.operations.iter().map(|operation| operation.id.clone()).collect();
    let conditions: Vec<String> = relations.conditions.iter().map(|condition| condition.name.clone()).collect();
    let zones: Vec<String> = relations.zones.iter().map(|zone| zone.name.clone()).collect();
    for written in &table.rows {
        let row = row(file, written.line);
        findings.note_row(row, &table, written);
        let cell =
            |column: &str| table.column(column).map(|column| &written.cells[column]).filter(|c| !c.value.is_empty());
        let machine = findings.find(file, &written.cells[machine], "machine", machines.iter().map(String::as_str));
        let operation =
            findings.find(file, &written.cells[operation], "operation", operations.iter().map(String::as_str));
        let (text, begin) = findings.written(file, &written.cells[after]);
        let mut unknown = Vec::new();
        let text = if text.trim() == "-" { "" } else { text };
        let read = Precondition::read(text, &mut |name, at| {
            let found = operations.iter().position(|id| id == name);
            if found.is_none() {
                unknown.push(Located::new(name.to_owned(), begin + at.start..begin + at.end));
            }
            found.map(OperationId)
        });
        for name in unknown {
            let hint = suggestion(&name.value, operations.iter().map(String::as_str));
            findings.unknown(file, name, "operation", hint);
        }
        let after = read.unwrap_or_else(|wrong| {
            let at = begin + wrong.at.start..begin + wrong.at.end;
            let hint = "operations joined by `and`, `or` and brackets (rule 4), as in `63 and (98 or 99)`";
            findings.reports[file].add(Problem::error(at, wrong.message).hint(hint));
            Precondition::Always
        });
        let kind = match cell("kind") {
            None => Some(OperationKind::Basic),
            Some(cell) => findings
                .find(file, cell, "kind", OperationKind::ALL.iter().map(|(word, _)| *word))
                .map(|nth| OperationKind::ALL[nth].1),
        };
        let all = |findings: &mut TableFindings<'_>, column: &str, what: &str, known: &[String]| {
            cell(column)
                .map_or_else(Vec::new, |cell| findings.find_all(file, cell, what, known.iter().map(String::as_str)))
        };
        let before = all(findings, "zones_before", "zone", &zones);
        let kept = all(findings, "zones_after", "zone", &zones);
        let is_everywhere = cell("conditions").is_none_or(|cell| cell.value == "all");
        let named = if is_everywhere { Vec::new() } else { all(findings, "conditions", "condition", &conditions) };
        let (Some(machine), Some(operation), Some(kind)) = (machine, operation, kind) else { continue };
        let declared = &relations.operations[operation];
        let of = if is_everywhere { declared.conditions.clone() } else { named.into_iter().map(ConditionId).collect() };
        let related = RelatedOperation {
            operation: OperationId(operation),
            kind,
            group: cell("group").map(|cell| cell.value.clone()),
            after,
            zones_before: before.into_iter().map(ZoneId).collect(),
            zones_after: kept.into_iter().map(ZoneId).collect(),
            comment: cell("comment").map_or_else(String::new, |cell| cell.value.clone()),
            row,
        };
        for condition in of {
            add(relations, condition, MachineId(machine), related.clone());
        }
    }
}

/// Adds a row at the end of a sequence: to the element before it, where both are alternatives of one group.
fn add(relations: &mut Relations, condition: ConditionId, machine: MachineId, related: RelatedOperation) {
    let known = relations.sequences.iter().position(|of| of.condition == condition && of.machine == machine);
    let sequence = match known {
        Some(nth) => &mut relations.sequences[nth],
        None => {
            relations.sequences.push(MachineSequence { condition, machine, elements: Vec::new() });
            relations.sequences.last_mut().expect("one was added")
        }
    };
    let is_choice = |kind| matches!(kind, OperationKind::Alternative | OperationKind::Exception);
    if let Some(last) = sequence.elements.last_mut()
        && is_choice(related.kind)
        && related.group.is_some()
        && last.alternatives.iter().all(|other| is_choice(other.kind) && other.group == related.group)
    {
        last.alternatives.push(related);
        return;
    }
    sequence.elements.push(SequenceElement { alternatives: vec![related] });
}
