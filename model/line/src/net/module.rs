//! Operation modules: the places an operation contributes (seed 002 §4.2 and §4.5.2).
//!
//! An R-module has two blocks of three places, N for the normal motion and F for the one that takes it back; an
//! I-module has N alone. A place is named by operation, block and stage and nothing else, so that the number of
//! places is 6 for every reversible and 3 for every irreversible operation by construction.

use std::fmt;

use crate::{OpId, Station};

/// One of an operation's two motions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Block {
    /// N: the normal motion.
    Normal,
    /// F: the recovery motion, back to where the normal one started.
    Recovery,
}

/// Stage of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MotionStage {
    /// O: the actuator is driven.
    Operating,
    /// IC: stopped before it was complete, by a fault, a released button or the emergency stop.
    Incomplete,
    /// C: complete.
    Completed,
}

/// One place of a station's net.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StationPlace {
    /// The operation.
    pub op: OpId,
    /// One of its motions.
    pub block: Block,
    pub stage: MotionStage,
}

impl StationPlace {
    /// p1, O of the normal motion.
    pub const fn operating(op: OpId) -> Self {
        StationPlace { op, block: Block::Normal, stage: MotionStage::Operating }
    }

    /// p2, IC of the normal motion.
    pub const fn incomplete(op: OpId) -> Self {
        StationPlace { op, block: Block::Normal, stage: MotionStage::Incomplete }
    }

    /// p3, C of the normal motion.
    pub const fn completed(op: OpId) -> Self {
        StationPlace { op, block: Block::Normal, stage: MotionStage::Completed }
    }

    /// p4, O of the recovery motion.
    pub const fn undoing(op: OpId) -> Self {
        StationPlace { op, block: Block::Recovery, stage: MotionStage::Operating }
    }

    /// p5, IC of the recovery motion.
    pub const fn undo_incomplete(op: OpId) -> Self {
        StationPlace { op, block: Block::Recovery, stage: MotionStage::Incomplete }
    }

    /// p6, C of the recovery motion: the operation has been undone.
    pub const fn undone(op: OpId) -> Self {
        StationPlace { op, block: Block::Recovery, stage: MotionStage::Completed }
    }

    /// The seed's number of the place within its module, 1 to 6 (Figure 12).
    pub const fn number(self) -> u8 {
        let stage = match self.stage {
            MotionStage::Operating => 1,
            MotionStage::Incomplete => 2,
            MotionStage::Completed => 3,
        };
        match self.block {
            Block::Normal => stage,
            Block::Recovery => stage + 3,
        }
    }

    /// The place with the seed's `number` within the module of `op`; `None` outside 1 to 6.
    pub const fn from_number(op: OpId, number: u8) -> Option<Self> {
        Some(match number {
            1 => StationPlace::operating(op),
            2 => StationPlace::incomplete(op),
            3 => StationPlace::completed(op),
            4 => StationPlace::undoing(op),
            5 => StationPlace::undo_incomplete(op),
            6 => StationPlace::undone(op),
            _ => return None,
        })
    }

    /// The same motion, stopped: where a fault, a released button or the emergency stop takes an operating place.
    pub const fn stopped(self) -> Self {
        StationPlace { stage: MotionStage::Incomplete, ..self }
    }

    /// Whether the actuator is driven here.
    pub const fn is_operating(self) -> bool {
        matches!(self.stage, MotionStage::Operating)
    }

    /// Whether a motion was stopped before its end here.
    pub const fn is_incomplete(self) -> bool {
        matches!(self.stage, MotionStage::Incomplete)
    }
}

impl fmt::Display for StationPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "p{} of operation {}", self.number(), self.op.index() + 1)
    }
}

/// All places of a station, operation by operation in chart order.
pub(super) fn places_of(station: &Station) -> Vec<StationPlace> {
    let mut places = Vec::new();
    for op in station.op_ids() {
        let reversible = is_reversible(station, op);
        places.extend((1..=if reversible { 6 } else { 3 }).filter_map(|n| StationPlace::from_number(op, n)));
    }
    places
}

/// Whether the operation has a recovery block.
pub(super) fn is_reversible(station: &Station, op: OpId) -> bool {
    matches!(station.operations[op.index()].module, crate::OperationModule::Reversible { .. })
}
