//! The names a description defines: are they well formed and unique, and what does each one stand for?
//!
//! This pass comes first because every later one looks names up. A malformed name is noted in its table, so that it is
//! reported once and not at every use.

use linewright_text::{LocatedName, NameTable, Problem, Report, phrase, ros_name, tag, unique};

use super::raw::{RawLine, RawStation};

/// Names of nodes that every line has; a station of that name would take their place in the ROS graph.
const RESERVED_STATIONS: [&str; 1] = ["coordinator"];

/// The names defined inside one station.
#[derive(Default)]
pub(super) struct StationNames<'a> {
    pub operations: NameTable<'a>,
    pub axes: NameTable<'a>,
    pub rests: NameTable<'a>,
    pub tasks: NameTable<'a>,
}

/// The names of the whole line, but for its signals, which belong to devices.
pub(super) struct LineNames<'a> {
    pub stations: NameTable<'a>,
    /// By station, in the order of the description.
    pub inside: Vec<StationNames<'a>>,
    pub buttons: NameTable<'a>,
}

/// Collects and checks all names.
pub(super) fn names<'a>(raw: &'a RawLine, report: &mut Report) -> LineNames<'a> {
    if let Some(name) = &raw.name {
        ros_name(name, "line", report);
    }
    let mut names = LineNames { stations: NameTable::default(), inside: Vec::new(), buttons: NameTable::default() };
    for (id, station) in raw.stations.iter().enumerate() {
        if let Some(name) = &station.name {
            names.stations.note(name, station_name(name, report));
            unique(&mut names.stations, name, id, "station", report);
        }
        names.inside.push(inside(station, report));
    }
    for (id, button) in raw.buttons.iter().enumerate() {
        names.buttons.note(button, tag(button, "button", report));
        unique(&mut names.buttons, button, id, "button", report);
    }
    device_names(raw, report);
    names
}

fn inside<'a>(station: &'a RawStation, report: &mut Report) -> StationNames<'a> {
    let mut names = StationNames::default();
    for (id, operation) in station.operations.iter().enumerate() {
        if let Some(name) = &operation.name {
            names.operations.note(name, phrase(name, "operation", report));
            unique(&mut names.operations, name, id, "operation of this station", report);
        }
    }
    for (id, (name, _)) in station.axes.iter().enumerate() {
        names.axes.note(name, tag(name, "axis", report));
        unique(&mut names.axes, name, id, "axis", report);
    }
    for (id, rest) in station.rests.iter().enumerate() {
        if let Some(name) = &rest.name {
            names.rests.note(name, phrase(name, "rest", report));
            unique(&mut names.rests, name, id, "rest of this station", report);
        }
    }
    for (id, task) in station.tasks.iter().enumerate() {
        if let Some(name) = &task.name {
            names.tasks.note(name, phrase(name, "task", report));
            unique(&mut names.tasks, name, id, "task of this station", report);
        }
        task.parameters.iter().for_each(|(name, _)| _ = tag(name, "parameter", report));
    }
    names
}

fn device_names(raw: &RawLine, report: &mut Report) {
    let mut devices = NameTable::default();
    for (id, device) in raw.devices.iter().enumerate() {
        if let Some(name) = &device.name {
            phrase(name, "device", report);
            unique(&mut devices, name, id, "device", report);
        }
    }
}

fn station_name(name: &LocatedName, report: &mut Report) -> bool {
    let is_reserved = RESERVED_STATIONS.contains(&name.value.as_str());
    if is_reserved {
        report.add(
            Problem::error(name.at.clone(), format!("a station cannot be called `{}`", name.value))
                .label("reserved")
                .hint("this is the name of a node that every line has"),
        );
    }
    ros_name(name, "station", report) && !is_reserved
}
