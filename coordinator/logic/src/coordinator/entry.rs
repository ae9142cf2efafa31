//! A station, as the mode decision knows it.

use linewright_lifecycle::LifecycleState;
use linewright_line::{Line, StationId, Tick};

use super::single::Single;
use super::{ManualPermit, StationView};

#[derive(Clone, Debug, Default)]
pub(super) struct StationEntry {
    pub heard: StationView,
    pub known_until: Tick,
    /// It has reported last that its node is not active: the state of that, and until when this counts.
    pub inactive: Option<(LifecycleState, Tick)>,
    /// Its devices have been operational since it, or the coordinator, was started.
    pub had_devices: bool,
    /// Came up anew while the line was in auto or hand, and no operator has acknowledged it since.
    pub restarted: bool,
    /// Its counts are compared with others'.
    pub compares: bool,
    /// Not received when auto or hand was left, nor since.
    pub missed: bool,
    /// Task-driven: it has no rounds, and is at home at any rest.
    pub task_driven: bool,
    /// Its fault is an exception of its order (see [`super::Coordinator::isolate`]).
    pub isolated: bool,
    /// Between two rests, at no order (see [`super::Coordinator::hold`]).
    pub held: bool,
    /// In emergency stop by itself (see [`super::Coordinator::stop_alone`]).
    pub stopped: bool,
    /// The epoch in which it was reset from that last.
    pub reset_in: u64,
    /// What its cell permits (see [`super::Coordinator::permit_manual`]).
    pub permit: Option<ManualPermit>,
    pub single: Single,
}

impl StationEntry {
    pub fn of(line: &Line, id: StationId) -> Self {
        let compares = line.arrows.iter().any(|arrow| arrow.from.0 == id || arrow.to.0 == id);
        StationEntry { task_driven: line.station(id).is_task_driven(), compares, ..StationEntry::default() }
    }

    /// Whether it is not in the latest round, or at the end of it.
    pub fn is_behind(&self, latest_round: i32) -> bool {
        !self.task_driven && self.heard.round != latest_round
    }
}
