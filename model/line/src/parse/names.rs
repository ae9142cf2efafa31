//! The names a description defines: are they well formed and unique, and what does each one stand for?
//!
//! This pass comes first because every later one looks names up. A name that is defined twice stands for its first
//! definition, and one that is malformed is kept as it is, so that one slip is reported once and not at every use.

use std::collections::HashMap;

use super::problem::{Problem, Report};
use super::raw::{Name, RawLine, RawStation, Where};
use super::suggest;

/// Longest name, in characters. ROS allows 255 for a whole topic name; ours are one part of one.
pub(super) const NAME_MAX: usize = 64;
/// Names of nodes that every line has; a station of that name would take their place in the ROS graph.
const RESERVED_STATIONS: [&str; 1] = ["coordinator"];

/// Names of one kind in one scope, each with its number and the place that defines it.
#[derive(Default)]
pub(super) struct Table<'a> {
    entries: HashMap<&'a str, (usize, &'a Where)>,
    /// In the order of the description, so that suggestions do not depend on hashing.
    order: Vec<&'a str>,
}

impl<'a> Table<'a> {
    /// Defines `name` as number `id`; gives back the place of an earlier definition, which then stands.
    pub fn define(&mut self, name: &'a Name, id: usize) -> Option<&'a Where> {
        if let Some((_, earlier)) = self.entries.get(name.value.as_str()) {
            return Some(earlier);
        }
        self.entries.insert(&name.value, (id, &name.at));
        self.order.push(&name.value);
        None
    }

    /// What `name` stands for.
    pub fn get(&self, name: &str) -> Option<usize> {
        self.entries.get(name).map(|&(id, _)| id)
    }

    /// Where `name` is defined.
    pub fn place(&self, name: &str) -> Option<&'a Where> {
        self.entries.get(name).map(|&(_, at)| at)
    }

    pub fn names(&self) -> impl Iterator<Item = &'a str> + Clone {
        self.order.iter().copied()
    }

    /// What `name` stands for, or a problem that says what it could have been.
    pub fn find(&self, name: &Name, what: &str, report: &mut Report) -> Option<usize> {
        let found = self.get(&name.value);
        if found.is_none() && !report.is_full() {
            report.add(
                Problem::error(name.at.clone(), format!("unknown {what} `{}`", name.value))
                    .maybe_hint(suggest::hint(&name.value, self.names())),
            );
        }
        found
    }
}

/// The names defined inside one station.
#[derive(Default)]
pub(super) struct StationNames<'a> {
    pub operations: Table<'a>,
    pub axes: Table<'a>,
}

/// The names of the whole line, but for its signals, which belong to devices.
pub(super) struct Names<'a> {
    pub stations: Table<'a>,
    /// By station, in the order of the description.
    pub inside: Vec<StationNames<'a>>,
    pub buttons: Table<'a>,
}

/// Collects and checks all names.
pub(super) fn names<'a>(raw: &'a RawLine, report: &mut Report) -> Names<'a> {
    if let Some(name) = &raw.name {
        ros_name(name, "line", report);
    }
    let mut names = Names { stations: Table::default(), inside: Vec::new(), buttons: Table::default() };
    for (id, station) in raw.stations.iter().enumerate() {
        if let Some(name) = &station.name {
            station_name(name, report);
            unique(&mut names.stations, name, id, "station", report);
        }
        names.inside.push(inside(station, report));
    }
    for (id, button) in raw.buttons.iter().enumerate() {
        tag(button, "button", report);
        unique(&mut names.buttons, button, id, "button", report);
    }
    device_names(raw, report);
    names
}

fn inside<'a>(station: &'a RawStation, report: &mut Report) -> StationNames<'a> {
    let mut names = StationNames::default();
    for (id, operation) in station.operations.iter().enumerate() {
        if let Some(name) = &operation.name {
            phrase(name, "operation", report);
            unique(&mut names.operations, name, id, "operation of this station", report);
        }
    }
    for (id, (name, _)) in station.axes.iter().enumerate() {
        tag(name, "axis", report);
        unique(&mut names.axes, name, id, "axis", report);
    }
    names
}

fn device_names(raw: &RawLine, report: &mut Report) {
    let mut devices = Table::default();
    for (id, device) in raw.devices.iter().enumerate() {
        if let Some(name) = &device.name {
            phrase(name, "device", report);
            unique(&mut devices, name, id, "device", report);
        }
    }
}

/// Defines `name` in `table`, and reports a second definition.
pub(super) fn unique<'a>(table: &mut Table<'a>, name: &'a Name, id: usize, what: &str, report: &mut Report) {
    if let Some(earlier) = table.define(name, id) {
        report.add(
            Problem::error(name.at.clone(), format!("a second {what} named `{}`", name.value))
                .label("again")
                .also(earlier, "first here"),
        );
    }
}

/// A name that becomes part of the ROS graph.
fn ros_name(name: &Name, what: &str, report: &mut Report) -> bool {
    let text = &name.value;
    let fits = text.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
        && text.starts_with(|c: char| c.is_ascii_lowercase())
        && !text.contains("__")
        && text.len() <= NAME_MAX;
    if !fits {
        report.add(
            Problem::error(name.at.clone(), format!("`{text}` cannot be the name of a {what}"))
                .label("not a ROS name")
                .hint(format!(
                    "lower-case letters, digits and single `_`, a letter first, at most {NAME_MAX}; `title` may be anything"
                )),
        );
    }
    fits
}

fn station_name(name: &Name, report: &mut Report) {
    if ros_name(name, "station", report) && RESERVED_STATIONS.contains(&name.value.as_str()) {
        report.add(
            Problem::error(name.at.clone(), format!("a station cannot be called `{}`", name.value))
                .label("reserved")
                .hint("this is the name of a node that every line has"),
        );
    }
}

/// A name as a chart prints it: words, with blanks between them.
fn phrase(name: &Name, what: &str, report: &mut Report) {
    let text = &name.value;
    let fits = !text.is_empty()
        && text.trim() == text
        && !text.contains(':')
        && !text.chars().any(char::is_control)
        && text.chars().count() <= NAME_MAX;
    if !fits {
        report.add(
            Problem::error(name.at.clone(), format!("`{}` cannot name this {what}", text.escape_debug()))
                .hint(format!("some words without `:`, no blank at either end, at most {NAME_MAX} characters")),
        );
    }
}

/// A name as a circuit diagram prints it: one word.
pub(super) fn tag(name: &Name, what: &str, report: &mut Report) {
    let text = &name.value;
    if text.is_empty() || text.len() > NAME_MAX || !text.chars().all(|c| c.is_ascii_graphic()) {
        report.add(
            Problem::error(name.at.clone(), format!("`{}` cannot name this {what}", text.escape_debug()))
                .hint(format!("one word of letters, digits and signs without blanks, at most {NAME_MAX}")),
        );
    }
}
