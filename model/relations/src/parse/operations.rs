//! The declarations of operations (DOP).

use std::time::Duration;

use linewright_text::{LocatedName, Problem};

use super::findings::TableFindings;
use super::{parts, row, table};
use crate::{ConditionId, DeclaredOperation, MachineId, Relations, ZoneId};

/// Its columns, those that must be there first.
pub(crate) const COLUMNS: [&str; 7] = ["id", "machine", "conditions", "comment", "zones", "duration_s", "every"];
/// The longest operation, in seconds: a day.
const DURATION_MAX_S: f64 = 86_400.0;
/// At most this many operations.
const OPERATIONS_MAX: usize = 2000;

/// Reads a table of operations.
pub(super) fn read(file: usize, relations: &mut Relations, findings: &mut TableFindings<'_>) {
    let table = table::read(findings.sources[file].text, &COLUMNS, 3, false, &mut findings.reports[file]);
    let [Some(id), Some(machine), Some(conditions)] = [0, 1, 2].map(|nth| table.column(COLUMNS[nth])) else { return };
    for written in &table.rows {
        let row = row(file, written.line);
        findings.note_row(row, &table, written);
        let cell =
            |column: &str| table.column(column).map(|column| &written.cells[column]).filter(|c| !c.value.is_empty());
        if relations.operations.len() == OPERATIONS_MAX {
            findings.error(row, "id", format!("more than {OPERATIONS_MAX} operations"), "is this the right file?");
            return;
        }
        let Some(id) = parts::name(findings, file, &written.cells[id], "an operation") else { continue };
        if let Some(first) = relations.operations.iter().find(|operation| operation.id == id) {
            let message = format!("operation `{id}` is declared twice");
            findings.error(row, "id", message, format!("the first is in {}", relations.place(first.row)));
            continue;
        }
        // One machine does it (rule 2).
        if written.cells[machine].value.is_empty() {
            let hint = "each operation is done by one machine (rule 2); for several at once declare one for each";
            findings.error(row, "machine", format!("operation `{id}` has no machine"), hint);
            findings.note_misread(id);
            continue;
        }
        let machines: Vec<String> = relations.machines.iter().map(|machine| machine.name.clone()).collect();
        let found = findings.find_all(file, &written.cells[machine], "machine", machines.iter().map(String::as_str));
        if found.len() > 1 {
            let hint = "declare one for each machine (rule 2), and relate them as `parallel` in a group";
            findings.error(row, "machine", format!("operation `{id}` has {} machines", found.len()), hint);
        }
        let known: Vec<String> = relations.conditions.iter().map(|condition| condition.name.clone()).collect();
        let conditions = match written.cells[conditions].value.as_str() {
            "all" | "" => (0..known.len()).collect(),
            _ => findings.find_all(file, &written.cells[conditions], "condition", known.iter().map(String::as_str)),
        };
        let names: Vec<String> = relations.zones.iter().map(|zone| zone.name.clone()).collect();
        let zones = cell("zones").map(|cell| findings.find_all(file, cell, "zone", names.iter().map(String::as_str)));
        let Some(&machine) = found.first() else {
            findings.note_misread(id);
            continue;
        };
        relations.operations.push(DeclaredOperation {
            id,
            comment: cell("comment").map_or_else(String::new, |cell| cell.value.clone()),
            machine: MachineId(machine),
            conditions: conditions.into_iter().map(ConditionId).collect(),
            zones: zones.map(|zones| zones.into_iter().map(ZoneId).collect()),
            duration: cell("duration_s").and_then(|cell| seconds(file, cell, findings)),
            every: cell("every").and_then(|cell| number(file, cell, 1, 1000, findings)).unwrap_or(1),
            row,
        });
    }
}

/// A duration in seconds, with a decimal point or comma.
pub(super) fn seconds(file: usize, cell: &LocatedName, findings: &mut TableFindings<'_>) -> Option<Duration> {
    let seconds = cell.value.replace(',', ".").parse::<f64>().ok();
    let seconds = seconds.filter(|seconds| (0.0..=DURATION_MAX_S).contains(seconds));
    if seconds.is_none() {
        let message = format!("`{}` is no number of seconds", cell.value);
        let hint = format!("a number from 0 to {DURATION_MAX_S}, without its unit");
        findings.reports[file].add(Problem::error(cell.at.clone(), message).hint(hint));
    }
    seconds.map(Duration::from_secs_f64)
}

/// A whole number within bounds.
pub(super) fn number(
    file: usize,
    cell: &LocatedName,
    low: u32,
    high: u32,
    findings: &mut TableFindings<'_>,
) -> Option<u32> {
    let number = cell.value.parse::<u32>().ok().filter(|number| (low..=high).contains(number));
    if number.is_none() {
        let message = format!("`{}` is no whole number from {low} to {high}", cell.value);
        findings.reports[file].add(Problem::error(cell.at.clone(), message));
    }
    number
}
