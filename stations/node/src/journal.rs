//! The station's snapshot as a journal record.
//!
//! Text, so that a person can read what a station remembers (`strings`). A record that does not fit the description —
//! another line, an edited one — is refused with the reason; the station then starts afresh only if told to.

use linewright_line::net::Place;
use linewright_line::{Line, OpId, StationId};
use linewright_station_logic::Snapshot;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Why a record cannot be used.
#[derive(Debug, Error)]
pub enum RecordError {
    /// Not a record at all.
    #[error("the journal of {station} cannot be read: {error}")]
    Unreadable {
        /// The station.
        station: String,
        /// What is wrong.
        error: serde_json::Error,
    },
    /// It belongs to another description.
    #[error("the journal of {station} belongs to another description ({what}); remove {hint} to start afresh")]
    OtherDescription {
        /// The station.
        station: String,
        /// What differs.
        what: &'static str,
        /// What to remove.
        hint: String,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Record {
    station: String,
    operations: Vec<String>,
    marking: Vec<(u16, u8)>,
    cycle: i32,
    done: Vec<i32>,
    started: Vec<i32>,
    path: Option<u16>,
    next_request: u64,
}

/// The record of a snapshot.
pub fn to_record(line: &Line, station: StationId, snapshot: &Snapshot) -> Vec<u8> {
    let described = line.station(station);
    let record = Record {
        station: described.name.clone(),
        operations: described.operations.iter().map(|o| o.name.clone()).collect(),
        marking: snapshot.marking.iter().map(|place| (place.op.0, place.number())).collect(),
        cycle: snapshot.cycle,
        done: snapshot.done.clone(),
        started: snapshot.started.clone(),
        path: snapshot.path.map(|op| op.0),
        next_request: snapshot.next_request,
    };
    serde_json::to_vec(&record).unwrap_or_default()
}

/// The snapshot in a record.
///
/// # Errors
/// When the record cannot be read or belongs to another description.
pub fn from_record(line: &Line, station: StationId, record: &[u8], path: &str) -> Result<Snapshot, RecordError> {
    let described = line.station(station);
    let name = || described.name.clone();
    let record: Record =
        serde_json::from_slice(record).map_err(|error| RecordError::Unreadable { station: name(), error })?;
    let other = |what| RecordError::OtherDescription { station: name(), what, hint: path.to_owned() };
    let operations = described.operations.len();
    if record.station != described.name {
        return Err(other("station"));
    }
    if record.operations.len() != operations
        || record.operations.iter().zip(&described.operations).any(|(a, b)| *a != b.name)
    {
        return Err(other("operations"));
    }
    if record.done.len() != operations || record.started.len() != operations {
        return Err(other("counts"));
    }
    let net = linewright_line::net::StationNet::of(line, station);
    let place = |&(op, number): &(u16, u8)| {
        let place = Place::from_number(OpId(op), number)?;
        net.place_index(place).map(|_| place)
    };
    let marking: Option<Vec<Place>> = record.marking.iter().map(place).collect();
    let marking = marking.filter(|m| is_one_step(described, m)).ok_or_else(|| other("marking"))?;
    let path = match record.path {
        Some(op) if usize::from(op) >= operations => return Err(other("recovery path")),
        path => path.map(OpId),
    };
    Ok(Snapshot {
        marking,
        cycle: record.cycle,
        done: record.done,
        started: record.started,
        path,
        next_request: record.next_request,
    })
}

/// The marking holds one token for each operation of exactly one step.
fn is_one_step(station: &linewright_line::Station, marking: &[Place]) -> bool {
    let Some(first) = marking.first() else { return false };
    let step = &station.steps[station.step_of(first.op)];
    step.len() == marking.len() && step.iter().all(|op| marking.iter().any(|place| place.op == *op))
}
