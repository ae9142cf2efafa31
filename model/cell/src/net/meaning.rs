//! Meaning of the places of a cell's net, from which a marking is put into words.
//!
//! Names of places are for people and for other tools; programs use this. The meaning of a place is set where the place
//! is made.

use crate::{ActivityId, ResourceId};

/// Meaning of the tokens of a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaceMeaning {
    /// Parts that a resource has.
    Held(ResourceId, ResourcePosition),
    /// Number of parts it has room for, not reserved.
    Room(ResourceId),
    /// Number of parts it can still carry; of a human, one token for all work.
    Free(ResourceId),
    /// A free position of a row. They are counted from 1, from where parts come in.
    Position(ResourceId, u32),
    /// The first free level of a stack.
    Top(ResourceId),
    /// Parts that have not come yet.
    Waiting,
    /// Number of parts that may still come in.
    Admission,
    /// Parts that an activity has, while it is in progress.
    Busy {
        /// Activity that keeps the resource busy.
        activity: ActivityId,
        /// The carrier has grasped the part and not begun to put it.
        is_held: bool,
    },
    /// An activity is not in progress for a stage.
    Idle(ActivityId),
}

/// Place of parts in a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResourcePosition {
    /// In a store, or a stack.
    Stored,
    /// In a machine, before its work.
    Loaded,
    /// In a machine, after it.
    Ready,
    /// In a row, at this position from where parts come in.
    Position(u32),
}

impl PlaceMeaning {
    /// Whether its tokens are parts that have come in.
    pub fn holds_parts_inside(self) -> bool {
        match self {
            PlaceMeaning::Held(..) | PlaceMeaning::Busy { .. } => true,
            PlaceMeaning::Room(_)
            | PlaceMeaning::Free(_)
            | PlaceMeaning::Position(..)
            | PlaceMeaning::Top(_)
            | PlaceMeaning::Waiting
            | PlaceMeaning::Admission
            | PlaceMeaning::Idle(_) => false,
        }
    }

    /// Resource of the place; none for the outside and for activities in progress.
    pub fn resource(self) -> Option<ResourceId> {
        match self {
            PlaceMeaning::Held(of, _)
            | PlaceMeaning::Room(of)
            | PlaceMeaning::Free(of)
            | PlaceMeaning::Position(of, _)
            | PlaceMeaning::Top(of) => Some(of),
            PlaceMeaning::Waiting | PlaceMeaning::Admission | PlaceMeaning::Busy { .. } | PlaceMeaning::Idle(_) => None,
        }
    }
}
