//! The interlocks (IL): terms of each action.

use linewright_text::{Located, LocatedName, Problem};

use super::findings::TableFindings;
use super::table::{WrittenRow, WrittenTable};
use super::{parts, row, table};
use crate::{
    ComponentState, Interlock, InterlockState, InterlockTerm, InterlockedAction, MachineId, OperationId, Relations,
    ZoneId,
};

/// Its columns, those that must be there first; others are components.
pub(crate) const COLUMNS: [&str; 10] = [
    "action",
    "automatic",
    "to",
    "way",
    "zones_before",
    "zones_after",
    "not_started",
    "not_ongoing",
    "product",
    "comment",
];
/// What a state begins with that is needed at the beginning alone.
pub(crate) const INITIALLY: &str = "initially ";

/// Reads a table of interlocks.
pub(super) fn read(file: usize, relations: &mut Relations, findings: &mut TableFindings<'_>) {
    let table = table::read(findings.sources[file].text, &COLUMNS, 2, true, &mut findings.reports[file]);
    let [Some(action), Some(automatic)] = [0, 1].map(|nth| table.column(COLUMNS[nth])) else { return };
    let operations: Vec<String> = relations.operations.iter().map(|operation| operation.id.clone()).collect();
    let zones: Vec<String> = relations.zones.iter().map(|zone| zone.name.clone()).collect();
    let products: Vec<String> = relations.conditions.iter().filter_map(|condition| condition.product.clone()).collect();
    for written in &table.rows {
        let row = row(file, written.line);
        findings.note_row(row, &table, written);
        let cell =
            |column: &str| table.column(column).map(|column| &written.cells[column]).filter(|c| !c.value.is_empty());
        let of = &written.cells[action];
        let Some((action, own)) = interlocked(of, cell("to"), cell("way"), file, relations, &operations, findings)
        else {
            continue;
        };
        let is_automatic = match written.cells[automatic].value.to_lowercase().as_str() {
            "yes" | "auto" | "x" | "1" => true,
            "" | "no" | "-" | "0" => false,
            other => {
                let hint = "`yes` where the term is expected in automatic mode, `no` where it is for manual mode alone";
                findings.error(row, "automatic", format!("`{other}` is neither yes nor no"), hint);
                false
            }
        };
        let all = |findings: &mut TableFindings<'_>, column: &str, what: &str, known: &[String]| {
            cell(column)
                .map_or_else(Vec::new, |cell| findings.find_all(file, cell, what, known.iter().map(String::as_str)))
        };
        let product = cell("product").filter(|cell| cell.value != "-").map(|cell| {
            findings.find(file, cell, "product", products.iter().map(String::as_str));
            cell.value.clone()
        });
        let to_zones = |ids: Vec<usize>| ids.into_iter().map(ZoneId).collect();
        let to_operations = |ids: Vec<usize>| ids.into_iter().map(OperationId).collect();
        let term = InterlockTerm {
            is_automatic,
            states: states(&table, written, file, own, relations, findings),
            zones_before: to_zones(all(findings, "zones_before", "zone", &zones)),
            zones_after: to_zones(all(findings, "zones_after", "zone", &zones)),
            not_started: to_operations(all(findings, "not_started", "operation", &operations)),
            not_ongoing: to_operations(all(findings, "not_ongoing", "operation", &operations)),
            product,
            comment: cell("comment").map_or_else(String::new, |cell| cell.value.clone()),
            row,
        };
        match relations.interlocks.iter_mut().find(|interlock| interlock.action == action) {
            Some(known) => known.terms.push(term),
            None => relations.interlocks.push(Interlock { action, terms: vec![term] }),
        }
    }
}

/// What the first columns of a term are about, and whose it is.
fn interlocked(
    of: &LocatedName,
    to: Option<&LocatedName>,
    way: Option<&LocatedName>,
    file: usize,
    relations: &Relations,
    operations: &[String],
    findings: &mut TableFindings<'_>,
) -> Option<(InterlockedAction, MachineId)> {
    if !of.value.contains('.') {
        let operation = OperationId(findings.find(file, of, "operation", operations.iter().map(String::as_str))?);
        if let Some(to) = to.filter(|to| to.value != "-") {
            let problem = Problem::error(to.at.clone(), format!("operation `{}` goes to no state", of.value));
            findings.reports[file].add(problem.hint("`to` is for a component, named as `MACHINE.component`"));
        }
        let way = way.filter(|way| way.value != "-").and_then(|way| parts::name(findings, file, way, "a way"));
        return Some((InterlockedAction::Operation { operation, way }, relations.operation(operation).machine));
    }
    let component = findings.component(relations, file, of, None)?;
    let Some(to) = to else {
        let problem = Problem::error(of.at.clone(), format!("`{}` goes to no state", of.value));
        findings.reports[file].add(problem.hint("write the state that the action leads to in the column `to`"));
        return None;
    };
    let to = parts::component_state(relations, component, to, file, findings)?;
    Some((InterlockedAction::State { component, to }, component.machine))
}

/// The states that a term asks for. `*`, `-` and nothing ask for none.
fn states(
    table: &WrittenTable,
    written: &WrittenRow,
    file: usize,
    own: MachineId,
    relations: &Relations,
    findings: &mut TableFindings<'_>,
) -> Vec<InterlockState> {
    let mut states: Vec<InterlockState> = Vec::new();
    for (column, cell) in table.columns.iter().zip(&written.cells) {
        if COLUMNS.contains(&column.value.as_str()) || matches!(cell.value.as_str(), "" | "-" | "*") {
            continue;
        }
        let Some(component) = findings.component(relations, file, column, Some(own)) else { continue };
        let after = cell.value.strip_prefix(INITIALLY);
        let (text, begin) = findings.written(file, cell);
        let word = after.unwrap_or(&cell.value).trim();
        let at = begin + text.find(word).unwrap_or(0);
        let word = Located::new(word.to_owned(), at..at + word.len());
        let state: Option<ComponentState> = parts::component_state(relations, component, &word, file, findings);
        let Some(state) = state else { continue };
        if states.iter().any(|other| other.component == component) {
            let message = format!("a second state of {}", relations.component_name(component));
            findings.reports[file].add(Problem::error(cell.at.clone(), message));
        } else {
            states.push(InterlockState { component, state, is_initial: after.is_some() });
        }
    }
    states.sort_by_key(|state| state.component);
    states
}
