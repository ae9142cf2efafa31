//! Resources one by one, and their stations.

use std::collections::HashMap;

use linewright_line::{Grip, InputId, Line, Operation, OperationModule, Sensor, Sign, Station, StationId};
use linewright_text::{LocatedName, Problem, Report, suggestion};

use crate::parse::draft::{DraftCell, DraftResource};

const NO_PART: &str = "shows where an axis stands, and no part";
const NAME_A_SENSOR: &str = "name the input of a sensor that is on while a part is there, or leave `presence` out";

pub(super) fn capacity_is_possible(resource: &DraftResource<'_>, report: &mut Report) {
    let Some(prototype) = resource.prototype else { return };
    let (name, what) = (resource.name, prototype.name());
    match (&resource.raw.capacity, prototype.capacity_max()) {
        (None, _) if prototype.usual_capacity().is_none() => {
            report.add(
                Problem::error(resource.place(), format!("`{name}` ({what}) needs `capacity`"))
                    .hint("how many parts there is room for"),
            );
        }
        (Some(capacity), None) => {
            report.add(
                Problem::error(capacity.at.clone(), format!("`{name}` ({what}) has no capacity to give"))
                    .hint("a robot carries one part; what carries several is a `conveyor`"),
            );
        }
        (Some(capacity), Some(most)) if !(1..=i64::from(most)).contains(&capacity.value) => {
            report.add(
                Problem::error(capacity.at.clone(), format!("a capacity of {}", capacity.value))
                    .hint(format!("a {what} has room for 1 to {most} parts")),
            );
        }
        (None, _) | (Some(_), Some(_)) => {}
    }
}

pub(super) fn presence_has_a_station(resource: &DraftResource<'_>, report: &mut Report) {
    if let (Some(presence), None) = (&resource.raw.presence, &resource.raw.station) {
        report.add(
            Problem::error(presence.at.clone(), format!("`{}` has no station with an input", resource.name))
                .hint("`presence` is an input of the resource's own `station`"),
        );
    }
}

pub(super) fn presence_is_an_input(draft: &DraftCell<'_>, resource: &DraftResource<'_>, report: &mut Report) {
    let (Some(line), Some(presence), Some(station)) = (draft.line, &resource.raw.presence, &resource.raw.station)
    else {
        return;
    };
    let Some(id) = line.station_named(&station.value) else { return };
    let inputs = &line.station(id).inputs;
    if let Some(operation) = limited_by(line.station(id), &presence.value) {
        report.add(
            Problem::warning(presence.at.clone(), format!("`{}` is the limit switch of `{operation}`", presence.value))
                .label(NO_PART)
                .hint(NAME_A_SENSOR),
        );
    } else if inputs.iter().position(|input| *input == presence.value).is_some_and(|at| sees_axes_alone(line, id, at)) {
        let message = format!("the `[[sensor]]` of `{}` sees no part", presence.value);
        report.add(Problem::warning(presence.at.clone(), message).label(NO_PART).hint(NAME_A_SENSOR));
    }
    if !inputs.contains(&presence.value) {
        report.add(
            Problem::error(
                presence.at.clone(),
                format!("station `{}` has no input `{}`", station.value, presence.value),
            )
            .maybe_hint(suggestion(&presence.value, inputs.iter().map(String::as_str))),
        );
    }
}

/// A sensor that sees a part where the resource has it, and that neither an operation nor the cell reads: a part that is missing there is noticed only by what does not come later. The rules of the line warn of hands.
pub(super) fn part_sensors_are_looked_at(draft: &DraftCell<'_>, resource: &DraftResource<'_>, report: &mut Report) {
    let (Some(line), Some(station), None) = (draft.line, &resource.raw.station, &resource.raw.presence) else { return };
    let Some(id) = line.station_named(&station.value) else { return };
    let of = line.station(id);
    let reads = |input: InputId| {
        let in_operation = |operation: &Operation| {
            operation.waits.contains(&input) || operation.result.is_some_and(|result| result.input == input)
        };
        of.operations.iter().any(in_operation) || limited_by(of, &of.inputs[input.index()]).is_some()
    };
    for sensor in line.handling.sensors.iter().filter(|sensor| sensor.station == id && !reads(sensor.input)) {
        let [Sign::Part(holder)] = sensor.when[..] else { continue };
        let holder = line.handling.holder(holder);
        let owner = holder.name.split_once('.').map_or(holder.name.as_str(), |(owner, _)| owner);
        if (owner != station.value && owner != resource.name) || matches!(holder.grip, Grip::Hand(_)) {
            continue;
        }
        let input = &of.inputs[sensor.input.index()];
        let message =
            format!("`{input}` of `{}` sees a part in `{}`, and nothing looks at it", station.value, holder.name);
        report.add(Problem::warning(resource.place(), message).hint(format!(
            "`presence = \"{input}\"` compares it with where the cell believes its parts to be: one that is missing is noticed at once"
        )));
    }
}

/// Whether an input has sensors, and all of them see axes.
fn sees_axes_alone(line: &Line, station: StationId, input: usize) -> bool {
    let of_input = |sensor: &&Sensor| sensor.station == station && sensor.input.index() == input;
    let mut sensors = line.handling.sensors.iter().filter(of_input).peekable();
    let is_axis = |sign: &Sign| matches!(sign, Sign::Stands(_));
    sensors.peek().is_some() && sensors.all(|sensor| sensor.when.iter().all(is_axis))
}

/// The operation that an input completes, on or back.
fn limited_by<'l>(station: &'l Station, input: &str) -> Option<&'l str> {
    let is_limit = |operation: &&Operation| {
        let recovery = match &operation.module {
            OperationModule::Reversible { recovery, .. } => Some(recovery.complete),
            OperationModule::Irreversible { .. } => None,
        };
        std::iter::once(operation.normal.complete).chain(recovery).any(|of| station.inputs[of.index()] == input)
    };
    station.operations.iter().find(is_limit).map(|operation| operation.name.as_str())
}

pub(super) fn stations_belong_to_one(draft: &DraftCell<'_>, report: &mut Report) {
    let mut owners = HashMap::new();
    for resource in &draft.resources {
        let Some(station) = &resource.raw.station else { continue };
        if let Some((owner, at)) = owners.insert(station.value.as_str(), (resource.name, &station.at)) {
            report.add(
                Problem::error(
                    station.at.clone(),
                    format!("station `{}` belongs to `{owner}` and to `{}`", station.value, resource.name),
                )
                .label("again")
                .also(at, "first here")
                .hint("a station is one resource's, and does one thing at a time"),
            );
        }
    }
}

pub(super) fn stations_exist(draft: &DraftCell<'_>, report: &mut Report) {
    let Some(line) = draft.line else { return };
    for station in draft.resources.iter().filter_map(|resource| resource.raw.station.as_ref()) {
        station_exists(line, station, report);
    }
}

pub(super) fn station_exists(line: &Line, station: &LocatedName, report: &mut Report) {
    if line.station_named(&station.value).is_none() {
        let names = line.stations.iter().map(|station| station.name.as_str());
        report.add(
            Problem::error(station.at.clone(), format!("the line has no station `{}`", station.value))
                .maybe_hint(suggestion(&station.value, names)),
        );
    }
}
