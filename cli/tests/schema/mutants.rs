//! Mutants of a description: copies with one change at one key. The key is misspelt, has a value of another type, has an
//! extreme number, or is missing.

use std::collections::BTreeSet;

use serde_json::{Map, Value, json};

/// A description with one change.
pub struct DescriptionMutant {
    /// Path of the key, and the change.
    pub what: String,
    pub description: Value,
    pub change: Change,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    Misspelt,
    /// A value of a type that no key has.
    WrongType,
    /// An extreme number: the reader decides whether it is out of range.
    Number,
    LeftOut,
}

/// One step of the path to a value.
#[derive(Clone)]
enum Step {
    Key(String),
    Index(usize),
}

/// All mutants of the first occurrence of each key. Keys in `seen` occurred in earlier descriptions; they are only left out,
/// since whether a key is required depends on its neighbours.
pub fn of(description: &Value, seen: &mut BTreeSet<String>) -> Vec<DescriptionMutant> {
    let mut places = Vec::new();
    walk(description, &mut Vec::new(), &mut places);
    let mut here = BTreeSet::new();
    let mut mutants = Vec::new();
    for place in places {
        let name: Vec<&str> = place.iter().map(|step| if let Step::Key(key) = step { key } else { "*" }).collect();
        let name = name.join(".");
        if !here.insert(name.clone()) {
            continue;
        }
        let is_new = seen.insert(name.clone());
        let (Some(Step::Key(key)), before) = (place.last(), &place[..place.len() - 1]) else { continue };
        let mut add = |change, edit: &dyn Fn(&mut Map<String, Value>)| {
            let mut description = description.clone();
            edit(table(&mut description, before));
            mutants.push(DescriptionMutant { what: format!("{name}: {change:?}"), description, change });
        };
        add(Change::LeftOut, &|table| _ = table.remove(key));
        if !is_new {
            continue;
        }
        if !names_are_free(before) {
            add(Change::Misspelt, &|table| {
                let value = table.remove(key).expect("it was there");
                table.insert(format!("{key}x"), value);
            });
        }
        add(Change::WrongType, &|table| table[key] = json!([[true]]));
        for number in [json!(-1), json!(0), json!(1_000_000), json!(-4e12), json!(4e12)] {
            add(Change::Number, &|table| {
                if table[key].is_number() {
                    table[key] = number.clone();
                }
            });
        }
    }
    mutants
}

/// Whether a table's keys are the user's own names.
fn names_are_free(place: &[Step]) -> bool {
    let keys: Vec<&str> =
        place.iter().filter_map(|step| if let Step::Key(key) = step { Some(key.as_str()) } else { None }).collect();
    matches!(keys[..], [.., "axes" | "parameters"] | [.., "rest", "at"] | [.., "reach", "when"])
}

fn walk(value: &Value, here: &mut Vec<Step>, places: &mut Vec<Vec<Step>>) {
    let mut into = |step: Step, value: &Value, is_key: bool| {
        here.push(step);
        if is_key {
            places.push(here.clone());
        }
        walk(value, here, places);
        here.pop();
    };
    match value {
        Value::Object(table) => table.iter().for_each(|(key, value)| into(Step::Key(key.clone()), value, true)),
        Value::Array(list) => list.iter().enumerate().for_each(|(index, value)| into(Step::Index(index), value, false)),
        _ => {}
    }
}

fn table<'a>(description: &'a mut Value, place: &[Step]) -> &'a mut Map<String, Value> {
    let found = place.iter().fold(description, |value, step| match step {
        Step::Key(key) => &mut value[key],
        Step::Index(index) => &mut value[*index],
    });
    found.as_object_mut().expect("a table")
}

/// A description's text as a value.
pub fn value(text: &str) -> Value {
    let document = toml_edit::Document::parse(text).expect("it is TOML");
    entries(document.as_table())
}

fn entries(table: &dyn toml_edit::TableLike) -> Value {
    table.iter().map(|(key, item)| (key.to_owned(), of_item(item))).collect::<Map<_, _>>().into()
}

fn of_item(item: &toml_edit::Item) -> Value {
    match item {
        toml_edit::Item::Value(value) => of_value(value),
        toml_edit::Item::Table(table) => entries(table),
        toml_edit::Item::ArrayOfTables(tables) => tables.iter().map(|table| entries(table)).collect(),
        toml_edit::Item::None => Value::Null,
    }
}

fn of_value(value: &toml_edit::Value) -> Value {
    match value {
        toml_edit::Value::String(text) => json!(text.value()),
        toml_edit::Value::Integer(number) => json!(number.value()),
        toml_edit::Value::Float(number) => json!(number.value()),
        toml_edit::Value::Boolean(flag) => json!(flag.value()),
        toml_edit::Value::Array(list) => list.iter().map(of_value).collect(),
        toml_edit::Value::InlineTable(table) => entries(table),
        toml_edit::Value::Datetime(_) => panic!("no description has dates"),
    }
}

/// A value as a description's text, each key of the outermost table in a line.
pub fn text(description: &Value) -> String {
    let table = description.as_object().expect("a table");
    table.iter().map(|(key, value)| format!("{key} = {}\n", inline(value))).collect()
}

fn inline(value: &Value) -> String {
    match value {
        Value::Object(table) => {
            let entries: Vec<String> = table.iter().map(|(key, value)| format!("{key} = {}", inline(value))).collect();
            format!("{{ {} }}", entries.join(", "))
        }
        Value::Array(list) => format!("[{}]", list.iter().map(inline).collect::<Vec<_>>().join(", ")),
        other => other.to_string(),
    }
}
