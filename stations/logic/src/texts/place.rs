//! Present operations of a station, and the names of its operations.

use linewright_line::net::{Block, MotionStage, StationPlace};
use linewright_line::{Line, RestId, StationId};

/// A marked place, e.g. `advance clamp` or `undoing 1st lift (stopped)`.
pub(crate) fn place_text(line: &Line, station: StationId, place: StationPlace) -> String {
    let name = &line.operation((station, place.op)).name;
    match (place.block, place.stage) {
        (Block::Normal, MotionStage::Operating) => name.clone(),
        (Block::Normal, MotionStage::Incomplete) => format!("{name} (stopped)"),
        (Block::Normal, MotionStage::Completed) => format!("{name} (done)"),
        (Block::Recovery, MotionStage::Operating) => format!("undoing {name}"),
        (Block::Recovery, MotionStage::Incomplete) => format!("undoing {name} (stopped)"),
        (Block::Recovery, MotionStage::Completed) => format!("{name} (undone)"),
    }
}

/// A rest of a task-driven station, e.g. `at rest "home"`.
pub(crate) fn rest_text(line: &Line, station: StationId, rest: RestId) -> String {
    format!("at rest \"{}\"", line.station(station).rests[rest.index()].name)
}

/// The names of operations, given as a bit each.
pub(crate) fn op_names(line: &Line, station: StationId, ops: u64) -> String {
    let described = line.station(station);
    let named = described.op_ids().filter(|op| ops & (1 << op.0) != 0);
    let names: Vec<&str> = named.map(|op| described.operations[op.index()].name.as_str()).collect();
    names.join(", ")
}
