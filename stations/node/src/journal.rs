//! The station's snapshot as a journal record.
//!
//! Text, so that a person can read a station's memory (`strings`). A record that does not fit the description — another
//! line, an edited one — gives no snapshot but the reason; the station then comes up without memory, and without a
//! generation.

use linewright_line::net::StationPlace;
use linewright_line::{Line, OpId, StationId, TaskId};
use linewright_station_logic::{
    CompileError, Controller, OrderKey, OrderMemory, Restore, StationSnapshot, TaskFailure, TaskOutcome, TaskRefusal,
    TaskReply,
};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Reason why a record cannot be used.
#[derive(Debug, Error)]
pub enum RecordError {
    /// Not a record at all.
    #[error("the journal of {station} cannot be read: {error}")]
    Unreadable {
        station: String,
        /// Error in it.
        error: serde_json::Error,
    },
    /// It belongs to another description.
    #[error("the journal of {station} belongs to another description ({what})")]
    OtherDescription {
        station: String,
        /// Difference.
        what: &'static str,
    },
    /// Its contents contradict each other.
    #[error("the journal of {station} cannot be used: {error}")]
    Contradicts {
        station: String,
        /// Error in it.
        error: CompileError,
    },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StationRecord {
    station: String,
    operations: Vec<String>,
    marking: Vec<(u16, u8)>,
    cycle: i32,
    done: Vec<i32>,
    started: Vec<i32>,
    path: Option<u16>,
    /// The index that is in doubt; a station without one has the record that it had before there were any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    doubtful: Option<u16>,
    /// The place of an endless axis that a drive turns; a station without one has the record that it had before there were any.
    #[serde(default, skip_serializing_if = "is_none")]
    place: u16,
    next_request: u64,
    /// The generation of the counts; 0 for none.
    #[serde(default)]
    generation: u64,
    /// The marking is where the mechanisms stand.
    #[serde(default)]
    placed: bool,
    /// Start of the host that it was written in.
    #[serde(default)]
    host: String,
    /// Task-driven stations alone have it, so that the records of all others have their old form.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    order: Option<OrderRecord>,
}

fn is_none(place: &u16) -> bool {
    *place == 0
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct OrderRecord {
    memory: u64,
    epoch: u64,
    last: u64,
    slot: Option<(u64, u64)>,
    /// Epoch, id, and how it ended: `done`, a code, or why it was refused.
    results: Vec<(u64, u64, String)>,
    #[serde(default)]
    secured: Option<(u64, u64)>,
    /// Number of the task, and the outputs that carry its parameters, the higher half first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    parameters: Option<(u16, u64, u64)>,
}

/// Reason why an order was refused for good, in the words of the record.
const REFUSALS: [(&str, TaskRefusal); 5] = [
    ("late", TaskRefusal::Late),
    ("not-there", TaskRefusal::NotThere),
    ("devices", TaskRefusal::Devices),
    ("unknown", TaskRefusal::Unknown),
    ("incomplete", TaskRefusal::Incomplete),
];

impl OrderRecord {
    fn of(memory: &OrderMemory) -> Self {
        OrderRecord {
            memory: memory.memory,
            epoch: memory.epoch,
            last: memory.last,
            slot: memory.slot.map(|key| (key.epoch, key.id)),
            results: memory.results.iter().filter_map(|&(key, r)| Some((key.epoch, key.id, word(r)?))).collect(),
            secured: memory.secured.map(|key| (key.epoch, key.id)),
            parameters: memory.parameters.map(|(task, image)| (task.0, (image >> 64) as u64, image as u64)),
        }
    }

    fn memory(&self) -> Option<OrderMemory> {
        let result = |(epoch, id, word): &(u64, u64, String)| Some((OrderKey { epoch: *epoch, id: *id }, reply(word)?));
        Some(OrderMemory {
            memory: self.memory,
            epoch: self.epoch,
            last: self.last,
            slot: self.slot.map(|(epoch, id)| OrderKey { epoch, id }),
            results: self.results.iter().map(result).collect::<Option<_>>()?,
            secured: self.secured.map(|(epoch, id)| OrderKey { epoch, id }),
            parameters: self
                .parameters
                .map(|(task, high, low)| (TaskId(task), u128::from(high) << 64 | u128::from(low))),
        })
    }
}

/// The word for a reply that a station remembers; none for others.
fn word(reply: TaskReply) -> Option<String> {
    match reply {
        TaskReply::Ended(TaskOutcome::Done) => Some("done".to_owned()),
        TaskReply::Ended(TaskOutcome::Failed(failure)) => Some(failure.code().to_string()),
        TaskReply::Refused(refusal) => {
            REFUSALS.iter().find(|(_, known)| *known == refusal).map(|(word, _)| (*word).to_owned())
        }
        TaskReply::Running => None,
    }
}

fn reply(word: &str) -> Option<TaskReply> {
    if word == "done" {
        return Some(TaskReply::Ended(TaskOutcome::Done));
    }
    if let Some((_, refusal)) = REFUSALS.iter().find(|(known, _)| *known == word) {
        return Some(TaskReply::Refused(*refusal));
    }
    match TaskFailure::from_code(word.parse().ok()?) {
        // No station writes that.
        TaskFailure::Other(_) => None,
        failure => Some(TaskReply::Ended(TaskOutcome::Failed(failure))),
    }
}

/// The record of a snapshot, written in this start of the host.
pub fn to_record(line: &Line, station: StationId, snapshot: &StationSnapshot, host: &str) -> Vec<u8> {
    let described = line.station(station);
    let record = StationRecord {
        station: described.name.clone(),
        operations: described.operations.iter().map(|o| o.name.clone()).collect(),
        marking: snapshot.marking.iter().map(|place| (place.op.0, place.number())).collect(),
        cycle: snapshot.cycle,
        done: snapshot.done.clone(),
        started: snapshot.started.clone(),
        path: snapshot.path.map(|op| op.0),
        doubtful: snapshot.doubtful.map(|op| op.0),
        place: snapshot.place,
        next_request: snapshot.next_request,
        generation: snapshot.generation,
        placed: snapshot.placed,
        host: host.to_owned(),
        order: snapshot.order.as_ref().map(OrderRecord::of),
    };
    serde_json::to_vec(&record).unwrap_or_default()
}

/// The snapshot in a record.
///
/// # Errors
/// When the record cannot be read or belongs to another description.
pub fn from_record(line: &Line, station: StationId, record: &[u8], host: &str) -> Result<StationSnapshot, RecordError> {
    let described = line.station(station);
    let name = || described.name.clone();
    let record: StationRecord =
        serde_json::from_slice(record).map_err(|error| RecordError::Unreadable { station: name(), error })?;
    let other = |what| RecordError::OtherDescription { station: name(), what };
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
        let place = StationPlace::from_number(OpId(op), number)?;
        net.place_index(place).map(|_| place)
    };
    let marking: Option<Vec<StationPlace>> = record.marking.iter().map(place).collect();
    let marking = marking.filter(|m| is_one_step(described, m)).ok_or_else(|| other("marking"))?;
    let path = match record.path {
        Some(op) if usize::from(op) >= operations => return Err(other("recovery path")),
        path => path.map(OpId),
    };
    // A record is not flushed: from before the host's last start it may be older than what the station has reported since.
    let is_newest = record.host == host && !host.is_empty();
    let generation = if is_newest { record.generation } else { 0 };
    let mut order = record.order.map(|order| order.memory().ok_or_else(|| other("orders"))).transpose()?;
    // The numbers may be those of the order before.
    order.iter_mut().filter(|_| !is_newest).for_each(|order| order.parameters = None);
    if order.is_some() != described.is_task_driven() {
        return Err(other("orders"));
    }
    let snapshot = StationSnapshot {
        marking,
        cycle: record.cycle,
        done: record.done,
        started: record.started,
        path,
        doubtful: record.doubtful.map(OpId),
        place: record.place,
        next_request: record.next_request,
        generation,
        placed: is_newest && record.placed,
        order,
    };
    // A record that the controller refuses must not keep the node from starting.
    Controller::new(line, station, 1, Restore::From(snapshot.clone()))
        .map_err(|error| RecordError::Contradicts { station: name(), error })?;
    Ok(snapshot)
}

/// The marking holds one token for each operation of exactly one step.
fn is_one_step(station: &linewright_line::Station, marking: &[StationPlace]) -> bool {
    let Some(first) = marking.first() else { return false };
    let step = &station.steps[station.step_of(first.op)];
    step.len() == marking.len() && step.iter().all(|op| marking.iter().any(|place| place.op == *op))
}
