//! Conditions that a scenario may wait for or expect, and their evaluation.

use std::cmp::Ordering;

use linewright_line::net::ControlMode;
use linewright_line::{OpId, StationId};

use crate::sim::LineSim;

/// A comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compare {
    Less,
    AtMost,
    Equal,
    AtLeast,
    More,
}

/// Condition of a station, or every station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StationCondition {
    /// At its home place.
    Home,
    /// Nothing of it is driven.
    Stopped,
    /// Some operation is driven.
    Moving,
    /// Some operation was stopped before its end.
    Incomplete,
    /// It stands, and reports what it waits for.
    Blocked,
    /// Its process runs.
    Up,
    /// Its process does not run.
    Down,
    /// Its process runs, has its devices and is received by the coordinator.
    Heard,
    /// It acts on a mode.
    Obeys(ControlMode),
}

/// Condition of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OperationCondition {
    /// Under way, forward or back.
    Operating,
    /// Stopped before its end.
    Incomplete,
    /// Complete, and nothing of its station has started since.
    Done,
    /// Undone, and nothing of its station has started since.
    Undone,
}

#[derive(Clone, Debug, PartialEq)]
pub enum ScenarioCondition {
    /// Cycles of the line that have ended.
    Cycles(Compare, i64),
    Mode(ControlMode),
    Station(StationId, StationCondition),
    Every(StationCondition),
    Operation((StationId, OpId), OperationCondition),
    /// The cycle in which an operation was last done.
    Count((StationId, OpId), Compare, i64),
    /// Every one of these holds.
    All(Vec<ScenarioCondition>),
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

impl ScenarioCondition {
    /// Whether it holds now.
    pub fn holds(&self, sim: &LineSim) -> bool {
        match self {
            ScenarioCondition::Cycles(compare, number) => compare.holds(sim.record().cycles() as i64, *number),
            ScenarioCondition::Mode(mode) => sim.mode() == *mode,
            ScenarioCondition::Station(id, state) => state.holds(sim, *id),
            ScenarioCondition::Every(state) => sim.line().station_ids().all(|id| state.holds(sim, id)),
            ScenarioCondition::Operation(op, state) => state.holds(sim, *op),
            ScenarioCondition::Count((id, op), compare, number) => {
                compare.holds(i64::from(sim.done(*id, *op)), *number)
            }
            ScenarioCondition::All(conditions) => conditions.iter().all(|condition| condition.holds(sim)),
        }
    }
}

impl StationCondition {
    fn holds(self, sim: &LineSim, id: StationId) -> bool {
        let Some(controller) = sim.controller(id) else { return self == StationCondition::Down };
        match self {
            StationCondition::Home => controller.is_at_home(),
            StationCondition::Stopped => controller.report().stopped,
            StationCondition::Moving => !controller.report().stopped,
            StationCondition::Incomplete => controller.marking().any(|place| place.is_incomplete()),
            StationCondition::Blocked => !controller.blocked_by(sim.line(), sim.now()).is_empty(),
            StationCondition::Up => true,
            StationCondition::Down => false,
            StationCondition::Heard => sim.hears(id),
            StationCondition::Obeys(mode) => controller.mode() == mode,
        }
    }
}

impl OperationCondition {
    fn holds(self, sim: &LineSim, (id, op): (StationId, OpId)) -> bool {
        use linewright_line::net::{Block, MotionStage};
        let Some(controller) = sim.controller(id) else { return false };
        controller.marking().filter(|place| place.op == op).any(|place| match self {
            OperationCondition::Operating => place.is_operating(),
            OperationCondition::Incomplete => place.is_incomplete(),
            OperationCondition::Done => (place.block, place.stage) == (Block::Normal, MotionStage::Completed),
            OperationCondition::Undone => (place.block, place.stage) == (Block::Recovery, MotionStage::Completed),
        })
    }
}
