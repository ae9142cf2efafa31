//! Relations written out again as `relations.toml` and tables.

use std::fmt::Write as _;
use std::time::Duration;

use crate::parse::{executions, interlocks, operations, sequences};
use crate::{
    ComponentKind, ComponentRef, ComponentState, InterlockedAction, OperationId, Relations, SequenceElement, ZoneId,
};

/// A file: its name, and its text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrittenFile {
    pub name: &'static str,
    pub text: String,
}

/// Writes relations as `relations.toml` and one table of each kind that is not empty. Read again they are the same, except for
/// the places that rows come from.
pub fn write(relations: &Relations) -> Vec<WrittenFile> {
    let tables = [
        ("operations.csv", operations_table(relations)),
        ("relations.csv", relations_table(relations)),
        ("executions.csv", executions_table(relations)),
        ("interlocks.csv", interlocks_table(relations)),
    ];
    let tables = tables.into_iter().filter(|(_, rows)| rows.len() > 1);
    let tables = tables.map(|(name, rows)| WrittenFile { name, text: csv_text(&rows) });
    std::iter::once(WrittenFile { name: crate::DESCRIPTION, text: description(relations) }).chain(tables).collect()
}

/// Rows as CSV, the first of them the names of the columns.
pub fn csv_text(rows: &[Vec<String>]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        // Into memory, rows of one length: neither can fail.
        let _ = writer.write_record(row);
    }
    writer.into_inner().ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default()
}

/// A text in TOML.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for sign in text.chars() {
        match sign {
            '"' | '\\' => quoted.extend(['\\', sign]),
            sign if sign.is_control() => {
                let _ = write!(quoted, "\\u{:04X}", u32::from(sign));
            }
            sign => quoted.push(sign),
        }
    }
    quoted + "\""
}

fn quoted_list(texts: &[String]) -> String {
    let texts: Vec<String> = texts.iter().map(|text| quoted(text)).collect();
    format!("[{}]", texts.join(", "))
}

fn description(relations: &Relations) -> String {
    let mut out = String::new();
    let head = |header: &str, name: &str, title: &str| {
        let title = if title == name { String::new() } else { format!("title = {}\n", quoted(title)) };
        let header = if header.is_empty() { String::new() } else { format!("\n[[{header}]]\n") };
        format!("{header}name = {}\n{title}", quoted(name))
    };
    out += &head("", &relations.name, &relations.title);
    out += &format!("products_max = {}\n", relations.products_max);
    for machine in &relations.machines {
        out += &head("machine", &machine.name, &machine.title);
        for component in &machine.components {
            out += &head("machine.component", &component.name, &component.title);
            let kind = ComponentKind::ALL.iter().find(|(_, kind)| *kind == component.kind).map_or("", |(word, _)| word);
            out += &format!("kind = \"{kind}\"\nstates = {}\n", quoted_list(&component.states));
            if !component.subcomponents.is_empty() {
                out += &format!("subcomponents = {}\n", quoted_list(&component.subcomponents));
            }
            out += &component.block.as_ref().map_or_else(String::new, |block| format!("block = {}\n", quoted(block)));
        }
    }
    for zone in &relations.zones {
        out += &head("zone", &zone.name, &zone.title);
    }
    for condition in &relations.conditions {
        out += &head("condition", &condition.name, &condition.title);
        let product = condition.product.as_ref();
        out += &product.map_or_else(String::new, |product| format!("product = {}\n", quoted(product)));
        out += &format!("cycle = {}\n", condition.cycle);
        let state = |(of, state): &(ComponentRef, ComponentState)| {
            format!("{} = {}", quoted(&relations.component_name(*of)), quoted(relations.state_name(*of, *state)))
        };
        let states: Vec<String> = condition.states.iter().map(state).collect();
        if !states.is_empty() {
            out += &format!("states = {{ {} }}\n", states.join(", "));
        }
    }
    for function in &relations.functions {
        out += &head("function", &function.name, &function.title);
        out += &format!("block = {}\n", quoted(&function.block));
    }
    out
}

fn zone_names(relations: &Relations, zones: &[ZoneId]) -> String {
    zones.iter().map(|zone| relations.zone(*zone).name.as_str()).collect::<Vec<_>>().join(" ")
}

fn operation_names(relations: &Relations, operations: &[OperationId]) -> String {
    operations.iter().map(|operation| relations.operation(*operation).id.as_str()).collect::<Vec<_>>().join(" ")
}

fn seconds(duration: Option<Duration>) -> String {
    duration.map_or_else(String::new, |duration| duration.as_secs_f64().to_string())
}

fn header(columns: &[&str]) -> Vec<String> {
    columns.iter().map(|column| (*column).to_owned()).collect()
}

fn operations_table(relations: &Relations) -> Vec<Vec<String>> {
    let rows = relations.operations.iter().map(|operation| {
        let conditions = operation.conditions.iter().map(|condition| relations.conditions[condition.0].name.as_str());
        vec![
            operation.id.clone(),
            relations.machine(operation.machine).name.clone(),
            conditions.collect::<Vec<_>>().join(" "),
            operation.comment.clone(),
            // `-` is no zone; nothing is not stated.
            operation.zones.as_ref().map_or_else(String::new, |zones| match zones.is_empty() {
                true => "-".to_owned(),
                false => zone_names(relations, zones),
            }),
            seconds(operation.duration),
            operation.every.to_string(),
        ]
    });
    std::iter::once(header(&operations::COLUMNS)).chain(rows).collect()
}

fn relations_table(relations: &Relations) -> Vec<Vec<String>> {
    let name = |operation: OperationId| relations.operation(operation).id.clone();
    let rows = relations.sequences.iter().flat_map(|sequence| {
        let rows = sequence.elements.iter().flat_map(|SequenceElement { alternatives }| alternatives);
        rows.map(move |row| {
            vec![
                relations.machine(sequence.machine).name.clone(),
                name(row.operation),
                row.after.text(&name),
                relations.conditions[sequence.condition.0].name.clone(),
                row.kind.word().to_owned(),
                row.group.clone().unwrap_or_default(),
                zone_names(relations, &row.zones_before),
                zone_names(relations, &row.zones_after),
                row.comment.clone(),
            ]
        })
    });
    std::iter::once(header(&sequences::COLUMNS)).chain(rows).collect()
}

/// The components that occur, in their order.
fn components(of: impl Iterator<Item = ComponentRef>) -> Vec<ComponentRef> {
    let mut components: Vec<ComponentRef> = of.collect();
    components.sort_unstable();
    components.dedup();
    components
}

fn executions_table(relations: &Relations) -> Vec<Vec<String>> {
    let steps = relations.executions.iter().flat_map(|execution| execution.steps());
    let columns = components(steps.flat_map(|step| step.states.iter().map(|(of, _)| *of)));
    let mut head = header(&executions::COLUMNS);
    head.extend(columns.iter().map(|of| relations.component_name(*of)));
    let mut rows = vec![head];
    for execution in &relations.executions {
        for (nth, step) in execution.steps().enumerate() {
            let marks = [("b", &step.booked), ("u", &step.released)];
            let marks = marks.iter().filter(|(_, zones)| !zones.is_empty());
            let marks: Vec<String> =
                marks.map(|(mark, zones)| format!("{mark}({})", zone_names(relations, zones))).collect();
            let mut row = vec![
                relations.operation(execution.operation).id.clone(),
                if nth == 0 { executions::INITIAL.to_owned() } else { nth.to_string() },
                execution.way.clone().unwrap_or_default(),
                marks.join(" "),
                step.alarm.map_or_else(String::new, |alarm| alarm.to_string()),
                seconds(step.delay),
                step.comment.clone(),
            ];
            row.extend(columns.iter().map(|of| match step.state(*of) {
                None => String::new(),
                Some(None) => "*".to_owned(),
                Some(Some(state)) => relations.state_name(*of, state).to_owned(),
            }));
            rows.push(row);
        }
    }
    rows
}

fn interlocks_table(relations: &Relations) -> Vec<Vec<String>> {
    let terms = relations.interlocks.iter().flat_map(|interlock| &interlock.terms);
    let columns = components(terms.flat_map(|term| term.states.iter().map(|state| state.component)));
    let mut head = header(&interlocks::COLUMNS);
    head.extend(columns.iter().map(|of| relations.component_name(*of)));
    let mut rows = vec![head];
    for interlock in &relations.interlocks {
        let (action, to, way) = match &interlock.action {
            InterlockedAction::State { component, to } => {
                (relations.component_name(*component), relations.state_name(*component, *to).to_owned(), String::new())
            }
            InterlockedAction::Operation { operation, way } => {
                (relations.operation(*operation).id.clone(), String::new(), way.clone().unwrap_or_default())
            }
        };
        for term in &interlock.terms {
            let mut row = vec![
                action.clone(),
                if term.is_automatic { "yes" } else { "no" }.to_owned(),
                to.clone(),
                way.clone(),
                zone_names(relations, &term.zones_before),
                zone_names(relations, &term.zones_after),
                operation_names(relations, &term.not_started),
                operation_names(relations, &term.not_ongoing),
                term.product.clone().unwrap_or_default(),
                term.comment.clone(),
            ];
            row.extend(columns.iter().map(|of| {
                let state = term.states.iter().find(|state| state.component == *of);
                state.map_or_else(String::new, |state| {
                    let begin = if state.is_initial { interlocks::INITIALLY } else { "" };
                    format!("{begin}{}", relations.state_name(*of, state.state))
                })
            }));
            rows.push(row);
        }
    }
    rows
}
