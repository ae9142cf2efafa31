//! The executions of operations (EOP): the states that a machine passes through.

use linewright_text::{LocatedName, Problem};

use super::findings::TableFindings;
use super::table::{WrittenRow, WrittenTable};
use super::{operations, parts, row, table};
use crate::{ComponentRef, ComponentState, Execution, ExecutionStep, MachineId, OperationId, Relations, ZoneId};

/// Its columns, those that must be there first; others are components.
pub(crate) const COLUMNS: [&str; 7] = ["operation", "step", "way", "zones", "alarm", "delay_s", "comment"];
/// Types of alarms.
const ALARMS_MAX: u32 = 99;
/// The word of the first row.
pub(crate) const INITIAL: &str = "initial";

/// Reads a table of executions.
pub(super) fn read(file: usize, relations: &mut Relations, findings: &mut TableFindings<'_>) {
    let table = table::read(findings.sources[file].text, &COLUMNS, 2, true, &mut findings.reports[file]);
    let [Some(operation), Some(step)] = [0, 1].map(|nth| table.column(COLUMNS[nth])) else { return };
    let ids: Vec<String> = relations.operations.iter().map(|operation| operation.id.clone()).collect();
    for written in &table.rows {
        let row = row(file, written.line);
        findings.note_row(row, &table, written);
        let cell =
            |column: &str| table.column(column).map(|column| &written.cells[column]).filter(|c| !c.value.is_empty());
        let Some(id) = findings.find(file, &written.cells[operation], "operation", ids.iter().map(String::as_str))
        else {
            continue;
        };
        let machine = relations.operations[id].machine;
        let way = cell("way").and_then(|cell| parts::name(findings, file, cell, "a way"));
        let (booked, released) =
            cell("zones").map_or_else(Default::default, |cell| zones(file, cell, relations, findings));
        let read = ExecutionStep {
            states: states(&table, written, file, machine, relations, findings),
            booked,
            released,
            alarm: cell("alarm").and_then(|cell| operations::number(file, cell, 1, ALARMS_MAX, findings)),
            delay: cell("delay_s").and_then(|cell| operations::seconds(file, cell, findings)),
            comment: cell("comment").map_or_else(String::new, |cell| cell.value.clone()),
            row,
        };
        let known = relations.executions.iter().position(|of| of.operation.0 == id && of.way == way);
        let step = &written.cells[step];
        match (step.value.as_str(), known) {
            (INITIAL, None) => {
                let operation = OperationId(id);
                relations.executions.push(Execution { operation, way, initial: read, actions: Vec::new() });
            }
            (INITIAL, Some(known)) => {
                let first = relations.place(relations.executions[known].initial.row);
                let hint = format!("the first is in {first}; ways of one operation differ in the column `way`");
                findings.error(row, "step", format!("a second initial row of operation `{}`", ids[id]), hint);
            }
            (number, Some(known)) => {
                let next = relations.executions[known].actions.len() + 1;
                if number.parse() != Ok(next) {
                    let message = format!("step `{number}` where step {next} follows");
                    findings.error(row, "step", message, "steps are `initial`, 1, 2 and so on, in this order");
                }
                relations.executions[known].actions.push(read);
            }
            (_, None) => {
                let message = format!("operation `{}` has no initial row", ids[id]);
                findings.error(row, "step", message, format!("the first step of each way is `{INITIAL}`"));
            }
        }
    }
}

/// The states in the columns of components. `*` is any; nothing and `-` leave the component out.
fn states(
    table: &WrittenTable,
    written: &WrittenRow,
    file: usize,
    own: MachineId,
    relations: &Relations,
    findings: &mut TableFindings<'_>,
) -> Vec<(ComponentRef, Option<ComponentState>)> {
    let mut states: Vec<(ComponentRef, Option<ComponentState>)> = Vec::new();
    for (column, cell) in table.columns.iter().zip(&written.cells) {
        if COLUMNS.contains(&column.value.as_str()) || matches!(cell.value.as_str(), "" | "-") {
            continue;
        }
        let Some(of) = findings.component(relations, file, column, Some(own)) else { continue };
        let state = match cell.value.as_str() {
            "*" => None,
            _ => match parts::component_state(relations, of, cell, file, findings) {
                Some(state) => Some(state),
                None => continue,
            },
        };
        if states.iter().any(|(other, _)| *other == of) {
            let message = format!("a second state of {}", relations.component_name(of));
            findings.reports[file].add(Problem::error(cell.at.clone(), message));
        } else {
            states.push((of, state));
        }
    }
    states.sort_by_key(|(of, _)| *of);
    states
}

/// Marks of zones as in `b(2 4 6) u(8)`: booked, and unbooked.
fn zones(
    file: usize,
    cell: &LocatedName,
    relations: &Relations,
    findings: &mut TableFindings<'_>,
) -> (Vec<ZoneId>, Vec<ZoneId>) {
    let names: Vec<&str> = relations.zones.iter().map(|zone| zone.name.as_str()).collect();
    let (mut booked, mut released) = (Vec::new(), Vec::new());
    let (text, begin) = findings.written(file, cell);
    let mut rest = text;
    while !matches!(rest.trim(), "" | "-") {
        let mark = rest.split_once('(').and_then(|(mark, after)| Some((mark, after.split_once(')')?)));
        rest = match mark {
            Some((mark, (list, after))) => {
                let zones = match mark.trim_matches([' ', ',', ';']) {
                    "b" => &mut booked,
                    "u" => &mut released,
                    _ => return wrong_zones(file, cell, findings),
                };
                let at = begin + (list.as_ptr() as usize - text.as_ptr() as usize);
                let list = LocatedName::new(list.to_owned(), at..at + list.len());
                let found = findings.find_all(file, &list, "zone", names.iter().copied());
                zones.extend(found.into_iter().map(ZoneId));
                after
            }
            None => return wrong_zones(file, cell, findings),
        };
    }
    (booked, released)
}

fn wrong_zones(file: usize, cell: &LocatedName, findings: &mut TableFindings<'_>) -> (Vec<ZoneId>, Vec<ZoneId>) {
    let hint = "`b(…)` for zones that are booked and `u(…)` for zones that are free again, as in `b(2 4) u(8)`";
    let message = format!("`{}` are no marks of zones", cell.value.escape_debug());
    findings.reports[file].add(Problem::error(cell.at.clone(), message).hint(hint));
    (Vec::new(), Vec::new())
}
