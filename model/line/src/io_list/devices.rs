//! The devices of a description and their bits, read from the text and written back into it.

use std::collections::BTreeMap;

use toml_edit::{Array, DocumentMut, Item, Table, TableLike, Value};

use super::IoDirection;

/// A device with its bits, as it is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct WrittenDevice {
    pub name: String,
    /// Its station, or `console`.
    pub owner: String,
    pub inputs: Vec<String>,
    pub outputs: Vec<String>,
    /// By signal.
    pub comments: BTreeMap<String, String>,
    /// Its number among the devices of the text; `None` for one that is written in a station type.
    place: Option<usize>,
}

impl WrittenDevice {
    pub fn bits(&self, direction: IoDirection) -> &[String] {
        match direction {
            IoDirection::Input => &self.inputs,
            IoDirection::Output => &self.outputs,
        }
    }

    pub fn bits_mut(&mut self, direction: IoDirection) -> &mut Vec<String> {
        match direction {
            IoDirection::Input => &mut self.inputs,
            IoDirection::Output => &mut self.outputs,
        }
    }

    /// Whether a signal is connected to it.
    pub fn carries(&self, name: &str) -> bool {
        self.inputs.iter().chain(&self.outputs).any(|bit| bit == name)
    }

    /// Whether it is written in a station type.
    pub fn is_of_a_type(&self) -> bool {
        self.place.is_none()
    }
}

/// The devices of the written out description `all`; those of `own`, the text itself, have their places.
pub(super) fn read(own: &DocumentMut, all: &DocumentMut) -> Vec<WrittenDevice> {
    let places: BTreeMap<String, usize> =
        tables(own).iter().enumerate().filter_map(|(place, table)| Some((text(*table, "name")?, place))).collect();
    let read = tables(all).into_iter().filter_map(|table| {
        // Neither a drive nor frames have bits.
        if table.contains_key("drive") || table.contains_key("dbc") {
            return None;
        }
        let name = text(table, "name")?;
        let is_console = table.get("console").and_then(Item::as_bool) == Some(true);
        let owner = if is_console { "console".to_owned() } else { text(table, "station")? };
        let comments = table.get("comments").and_then(Item::as_table_like);
        let comments = comments.into_iter().flat_map(|comments| {
            comments.iter().filter_map(|(name, comment)| Some((name.to_owned(), comment.as_str()?.to_owned())))
        });
        Some(WrittenDevice {
            owner,
            inputs: list(table, "inputs"),
            outputs: list(table, "outputs"),
            comments: comments.collect(),
            place: places.get(&name).copied(),
            name,
        })
    });
    read.collect()
}

fn tables(document: &DocumentMut) -> Vec<&dyn TableLike> {
    match document.get("device") {
        Some(Item::ArrayOfTables(tables)) => tables.iter().map(|table| table as &dyn TableLike).collect(),
        Some(Item::Value(Value::Array(list))) => {
            list.iter().filter_map(|value| Some(value.as_inline_table()? as &dyn TableLike)).collect()
        }
        _ => Vec::new(),
    }
}

fn text(table: &dyn TableLike, key: &str) -> Option<String> {
    table.get(key)?.as_str().map(str::to_owned)
}

fn list(table: &dyn TableLike, key: &str) -> Vec<String> {
    let entries = table.get(key).and_then(Item::as_array).into_iter().flatten();
    entries.map(|entry| entry.as_str().unwrap_or_default().to_owned()).collect()
}

/// The text with the devices as they are in `after`; what has not changed stays as it is written.
pub(super) fn write(text: &str, before: &[WrittenDevice], after: &[WrittenDevice]) -> String {
    let Ok(mut document) = text.parse::<DocumentMut>() else { return text.to_owned() };
    for (before, after) in before.iter().zip(after).filter(|(before, after)| before != after) {
        let Some(place) = after.place else { continue };
        let table: Option<&mut dyn TableLike> = match document.get_mut("device") {
            Some(Item::ArrayOfTables(tables)) => tables.get_mut(place).map(|table| table as &mut dyn TableLike),
            Some(Item::Value(Value::Array(list))) => {
                let table = list.get_mut(place).and_then(Value::as_inline_table_mut);
                table.map(|table| table as &mut dyn TableLike)
            }
            _ => continue,
        };
        let Some(table) = table else { continue };
        for (key, direction) in [("inputs", IoDirection::Input), ("outputs", IoDirection::Output)] {
            if before.bits(direction) != after.bits(direction) {
                write_bits(table, key, after.bits(direction));
            }
        }
        if before.comments != after.comments {
            write_comments(table, &after.comments);
        }
    }
    document.to_string()
}

fn write_bits(table: &mut dyn TableLike, key: &str, bits: &[String]) {
    if table.get(key).and_then(Item::as_array).is_none() {
        table.insert(key, Item::Value(Value::Array(Array::new())));
    }
    let Some(array) = table.get_mut(key).and_then(Item::as_array_mut) else { return };
    while array.len() > bits.len() {
        array.remove(array.len() - 1);
    }
    for (bit, name) in bits.iter().enumerate() {
        match array.get(bit).map(|entry| entry.as_str() == Some(name)) {
            Some(true) => {}
            // What stands around it stays.
            Some(false) => {
                array.replace(bit, name.as_str());
            }
            None => array.push(name.as_str()),
        }
    }
}

fn write_comments(table: &mut dyn TableLike, comments: &BTreeMap<String, String>) {
    if comments.is_empty() {
        table.remove("comments");
        return;
    }
    if table.get("comments").and_then(Item::as_table_like).is_none() {
        // Within braces it becomes one within braces.
        table.insert("comments", Item::Table(Table::new()));
    }
    let Some(written) = table.get_mut("comments").and_then(Item::as_table_like_mut) else { return };
    let gone: Vec<String> =
        written.iter().map(|(name, _)| name.to_owned()).filter(|name| !comments.contains_key(name)).collect();
    for name in gone {
        written.remove(&name);
    }
    for (name, comment) in comments {
        if written.get(name).and_then(Item::as_str) != Some(comment) {
            written.insert(name, toml_edit::value(comment.as_str()));
        }
    }
}
