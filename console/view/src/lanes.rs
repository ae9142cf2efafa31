//! Lanes of operations over the last two minutes, from the states of stations.
//!
//! What was not received is a stretch of its own kind, from the last state on: a motion is never shown as going on where nothing is
//! known of it. A process that was started anew is not known between its last state and the first new one.

use std::time::Duration;

use linewright_line::{Line, StationId};
use linewright_msgs::StationState;
use serde::Serialize;

/// Time that lanes reach back.
pub const LANE_WINDOW: Duration = Duration::from_secs(120);

/// Most stretches of a lane. Beyond it the two oldest become one that is unknown.
pub const STRETCHES_MAX: usize = 100;

/// The lanes of a station.
#[derive(Debug, Serialize)]
pub struct StationLanes {
    pub station: String,
    /// Name and title, as people read them.
    pub label: String,
    /// In the order of the description.
    pub lanes: Vec<LaneRow>,
}

/// The lane of an operation. Between stretches it is at rest.
#[derive(Clone, Debug, Serialize)]
pub struct LaneRow {
    pub operation: String,
    /// Without overlaps, the oldest first.
    pub stretches: Vec<LaneStretch>,
}

/// One stretch of a lane.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LaneStretch {
    pub kind: StretchKind,
    /// Begin, in ms since the begin of the console.
    pub from_ms: u64,
    /// End; none as long as it goes on.
    pub to_ms: Option<u64>,
}

/// What an operation did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StretchKind {
    /// Under way.
    Moving,
    /// Under way back.
    Undoing,
    /// Begun, and nothing of its station moves.
    Halted,
    /// Stopped before its end.
    Stopped,
    /// Not received.
    Unknown,
}

impl StretchKind {
    /// What an operation does by a state of its station; none at rest.
    fn of(state: &StationState, op: usize) -> Option<Self> {
        let moves = |kind| if state.stopped { StretchKind::Halted } else { kind };
        match state.places.get(op).copied() {
            Some(StationState::PLACE_OPERATING) => Some(moves(StretchKind::Moving)),
            Some(StationState::PLACE_UNDOING) => Some(moves(StretchKind::Undoing)),
            Some(StationState::PLACE_INCOMPLETE | StationState::PLACE_UNDO_INCOMPLETE) => Some(StretchKind::Stopped),
            Some(StationState::PLACE_NONE | StationState::PLACE_COMPLETED | StationState::PLACE_UNDONE) => None,
            // Of another version, or of another description.
            Some(_) | None => Some(StretchKind::Unknown),
        }
    }
}

impl LaneRow {
    fn set(&mut self, at: u64, kind: Option<StretchKind>) {
        let open = self.stretches.last_mut().filter(|last| last.to_ms.is_none());
        if open.as_ref().map(|open| open.kind) == kind {
            return;
        }
        let mut at = at;
        if let Some(open) = open {
            at = at.max(open.from_ms);
            open.to_ms = Some(at);
            if open.from_ms == at {
                self.stretches.pop();
            }
        }
        self.stretches.extend(kind.map(|kind| LaneStretch { kind, from_ms: at, to_ms: None }));
        if self.stretches.len() > STRETCHES_MAX {
            self.stretches[1].kind = StretchKind::Unknown;
            self.stretches[1].from_ms = self.stretches[0].from_ms;
            self.stretches.remove(0);
        }
    }

    fn forget_before(&mut self, at: u64) {
        self.stretches.retain(|stretch| stretch.to_ms.is_none_or(|to| to >= at));
    }
}

/// The newest state of a station that the lanes have.
#[derive(Clone, Copy, Debug)]
struct LastReceived {
    boot_id: u64,
    at: u64,
}

/// The lanes of all stations.
#[derive(Debug)]
pub(crate) struct LaneRecorder {
    rows: Vec<Vec<LaneRow>>,
    last: Vec<Option<LastReceived>>,
}

/// Time since the begin of the console, in ms.
pub(crate) fn ms(of: Duration) -> u64 {
    u64::try_from(of.as_millis()).unwrap_or(u64::MAX)
}

impl LaneRecorder {
    /// Nothing is known yet.
    pub fn new(line: &Line) -> Self {
        let unknown = LaneStretch { kind: StretchKind::Unknown, from_ms: 0, to_ms: None };
        let row = |name: &str| LaneRow { operation: name.to_owned(), stretches: vec![unknown.clone()] };
        let rows = line.stations.iter().map(|of| of.operations.iter().map(|op| row(&op.name)).collect()).collect();
        LaneRecorder { rows, last: vec![None; line.stations.len()] }
    }

    /// Takes a state that was received at this time.
    pub fn take(&mut self, at: Duration, station: StationId, state: &StationState) {
        let at = ms(at);
        if let Some(last) = self.last[station.index()].filter(|last| last.boot_id != state.boot_id) {
            self.set(last.at, station, |_| Some(StretchKind::Unknown));
        }
        self.last[station.index()] = Some(LastReceived { boot_id: state.boot_id, at });
        self.set(at, station, |op| StretchKind::of(state, op));
    }

    /// A station is not received any more: what it did since its last state is not known.
    pub fn lost(&mut self, station: StationId) {
        let since = self.last[station.index()].map_or(0, |last| last.at);
        self.set(since, station, |_| Some(StretchKind::Unknown));
    }

    fn set(&mut self, at: u64, station: StationId, kind: impl Fn(usize) -> Option<StretchKind>) {
        for (op, row) in self.rows[station.index()].iter_mut().enumerate() {
            row.set(at, kind(op));
        }
    }

    /// The lanes as they are at this time.
    pub fn at(&mut self, now: Duration, line: &Line) -> Vec<StationLanes> {
        let begin = ms(now.saturating_sub(LANE_WINDOW));
        self.rows.iter_mut().flatten().for_each(|row| row.forget_before(begin));
        let of = |(station, lanes): (&linewright_line::Station, &Vec<LaneRow>)| StationLanes {
            station: station.name.clone(),
            label: station.label(),
            lanes: lanes.clone(),
        };
        line.stations.iter().zip(&self.rows).map(of).collect()
    }
}
