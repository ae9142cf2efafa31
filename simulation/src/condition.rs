//! What a scenario may wait for or expect, and whether it holds.

use std::cmp::Ordering;

use linewright_line::net::ControlMode;
use linewright_line::{OpId, StationId};

use crate::sim::Sim;

/// A comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compare {
    /// `<`
    Less,
    /// `<=`
    AtMost,
    /// `==`
    Equal,
    /// `>=`
    AtLeast,
    /// `>`
    More,
}

/// What a station, or every station, may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StationState {
    /// At its home place.
    Home,
    /// Nothing of it is driven.
    Stopped,
    /// Some operation is driven.
    Moving,
    /// Some operation was stopped before its end.
    Incomplete,
    /// It stands, and says what for.
    Blocked,
    /// Its process runs.
    Up,
    /// Its process does not run.
    Down,
    /// Its process runs, has its devices and is heard by the coordinator.
    Heard,
    /// It acts on a mode.
    Obeys(ControlMode),
}

/// What an operation may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OperationState {
    /// Under way, forward or back.
    Operating,
    /// Stopped before its end.
    Incomplete,
    /// Complete, and nothing of its station has started since.
    Done,
    /// Undone, and nothing of its station has started since.
    Undone,
}

/// A condition.
#[derive(Clone, Debug, PartialEq)]
pub enum Condition {
    /// Cycles of the line that have ended.
    Cycles(Compare, i64),
    /// The mode of the line.
    Mode(ControlMode),
    /// A station.
    Station(StationId, StationState),
    /// Every station.
    Every(StationState),
    /// An operation.
    Operation((StationId, OpId), OperationState),
    /// The cycle in which an operation was last done.
    Count((StationId, OpId), Compare, i64),
    /// All of them.
    All(Vec<Condition>),
}

impl Compare {
    fn holds(self, a: i64, b: i64) -> bool {
        match (self, a.cmp(&b)) {
            (Compare::Less, order) => order == Ordering::Less,
            (Compare::AtMost, order) => order != Ordering::Greater,
            (Compare::Equal, order) => order == Ordering::Equal,
            (Compare::AtLeast, order) => order != Ordering::Less,
            (Compare::More, order) => order == Ordering::Greater,
        }
    }
}

impl Condition {
    /// Whether it holds now.
    pub fn holds(&self, sim: &Sim) -> bool {
        match self {
            Condition::Cycles(compare, number) => compare.holds(sim.record().cycles() as i64, *number),
            Condition::Mode(mode) => sim.mode() == *mode,
            Condition::Station(id, state) => state.holds(sim, *id),
            Condition::Every(state) => sim.line().station_ids().all(|id| state.holds(sim, id)),
            Condition::Operation(op, state) => state.holds(sim, *op),
            Condition::Count((id, op), compare, number) => compare.holds(i64::from(sim.done(*id, *op)), *number),
            Condition::All(conditions) => conditions.iter().all(|condition| condition.holds(sim)),
        }
    }
}

impl StationState {
    fn holds(self, sim: &Sim, id: StationId) -> bool {
        let Some(controller) = sim.controller(id) else { return self == StationState::Down };
        match self {
            StationState::Home => controller.is_at_home(),
            StationState::Stopped => controller.report().stopped,
            StationState::Moving => !controller.report().stopped,
            StationState::Incomplete => controller.marking().any(|place| place.is_incomplete()),
            StationState::Blocked => !controller.blocked_by(sim.line(), sim.now()).is_empty(),
            StationState::Up => true,
            StationState::Down => false,
            StationState::Heard => sim.hears(id),
            StationState::Obeys(mode) => controller.mode() == mode,
        }
    }
}

impl OperationState {
    fn holds(self, sim: &Sim, (id, op): (StationId, OpId)) -> bool {
        use linewright_line::net::{Block, Stage};
        let Some(controller) = sim.controller(id) else { return false };
        controller.marking().filter(|place| place.op == op).any(|place| match self {
            OperationState::Operating => place.is_operating(),
            OperationState::Incomplete => place.is_incomplete(),
            OperationState::Done => (place.block, place.stage) == (Block::Normal, Stage::Completed),
            OperationState::Undone => (place.block, place.stage) == (Block::Recovery, Stage::Completed),
        })
    }
}
