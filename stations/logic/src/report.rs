//! A station's whole state, as it publishes it and as it keeps it.
//!
//! The whole state goes out each time, never a difference: a lost message then costs one period and nothing else.

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{InputId, OpId, StationId};
use std::time::Duration;

use crate::event::StopCause;
use crate::order::{OrderMemory, TaskOrderReport};

/// A station's state for others to read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StationReport {
    /// Boot id of the station: different after every start.
    pub boot_id: u64,
    /// The newest mode epoch it has received, and so acknowledged.
    pub mode_epoch: u64,
    /// The mode it acts on.
    pub mode: Option<ControlMode>,
    /// The generation its counts belong to; 0 for none. See `generation`.
    pub generation: u64,
    pub cycle: i32,
    /// For each operation, the cycle in which it was last completed.
    pub done: Vec<i32>,
    /// For each operation, the cycle in which it was last started and not undone.
    pub started: Vec<i32>,
    /// For each operation, the seed's number of its marked place, 0 for none.
    pub places: Vec<u8>,
    /// On its way home from a fault in an irreversible operation.
    pub recovering_home: bool,
    /// At its home place; if task-driven, at any rest.
    pub at_home: bool,
    /// The round it is in, or at the end of which it stands at home: how often it has come home since the line first
    /// stood at home together, plus one while it is away. No meaning at a task-driven station.
    pub round: i32,
    /// Nothing moves.
    pub stopped: bool,
    /// Its selector stands at station-manual.
    pub selector_manual: bool,
    /// Its devices are received and operational.
    pub devices_valid: bool,
    /// Its input image, whose limit switches measure its mechanisms. It means nothing without valid devices.
    pub measured: u128,
    /// Age of that image at the time of the report.
    pub measured_age: Duration,
    /// An axis that stands still by the chart and is not measured there: the operation at whose place, and the switch.
    pub position_lost: Option<(OpId, InputId)>,
    /// Where its mechanisms stand is known: confirmed, read off the switches, or following from such. Not after a start with a
    /// record that may be older than they are.
    pub placed: bool,
    /// The numbered place at which the endless axis of a drive stood last, or from which its index under way began; 0 for none.
    pub place: u16,
    /// Operations stopped before their end, with the cause.
    pub incomplete: Vec<(OpId, StopCause)>,
    /// The request that is open.
    pub request: Option<AgreementRequest>,
    /// Its answers to the requests of others.
    pub answers: Vec<AgreementAnswer>,
    /// Its orders, if it is task-driven.
    pub order: Option<TaskOrderReport>,
}

/// A request to other stations: to take back the counts of some operations, or to start a motion by measured positions alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AgreementRequest {
    /// Never used again by this station; an agreement counts for this number alone.
    pub number: u64,
    /// The operations whose counts are taken back, a bit each.
    pub ops: u64,
}

/// An answer to a request of another station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AgreementAnswer {
    /// Station that made the request.
    pub to: StationId,
    /// Its boot id.
    pub boot_id: u64,
    /// The number of the request.
    pub number: u64,
    /// The operation that is in the way; `None` is agreement.
    pub in_the_way: Option<OpId>,
}

/// Record from which a station is restarted where it was.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StationSnapshot {
    pub marking: Vec<StationPlace>,
    /// The generation of the counts; 0 for none. The node restores 0 when the record was written before the last start of the
    /// host, as it may be older than what was reported.
    pub generation: u64,
    /// The marking is where the mechanisms stand. The node restores false with a generation of 0 for the same reason.
    pub placed: bool,
    pub cycle: i32,
    /// Counts of completion, per operation.
    pub done: Vec<i32>,
    /// Counts of starts, per operation.
    pub started: Vec<i32>,
    /// The irreversible operation whose recovery path it is on.
    pub path: Option<OpId>,
    /// The index of which it is not certain whether it is done.
    pub doubtful: Option<OpId>,
    /// The place at which the endless axis of a drive stood last, or from which its index under way began; 0 for none.
    pub place: u16,
    /// The next number for a request.
    pub next_request: u64,
    /// Its task orders, if it is task-driven.
    pub order: Option<OrderMemory>,
}

/// Start of a controller.
#[expect(clippy::large_enum_variant, reason = "there is one, at the start of a station")]
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Restore {
    /// For the first time: at home, if the devices confirm it.
    Fresh,
    /// From a snapshot.
    From(StationSnapshot),
}
