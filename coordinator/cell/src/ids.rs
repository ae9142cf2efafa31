//! Numbers of the player, each kind with a type of its own.
//!
//! Cells and modes are numbered by the table and mean nothing beside another. Parts, firings and orders are numbered as
//! they come, by counters that are folded from the records and never go back: no number is ever used twice.

use std::fmt;

pub use linewright_orders::OrderKey;
use serde::{Deserialize, Serialize};

macro_rules! number {
    ($(#[$doc:meta])* $name:ident($of:ty), $word:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(pub $of);

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, concat!($word, " {}"), self.0)
            }
        }
    };
}

number! {
    /// One colour on one place: a place of the unfolded net, by its position there.
    CellId(u32), "cell"
}
number! {
    /// One way in which an activity can happen: a transition of the unfolded net, by its position there.
    ModeId(u32), "mode"
}
number! {
    /// A part, from its entering to its leaving.
    PartId(u64), "part"
}
number! {
    /// A production order, from its being accepted on.
    ProductionId(u64), "production order"
}
number! {
    /// An activity that was started, until it has ended.
    FiringId(u64), "firing"
}

number! {
    /// A resource, by its position in [`super::RecoveryPolicy`].
    ResourceId(u32), "resource"
}
number! {
    /// Something that a person has to look at.
    AlarmId(u64), "alarm"
}

impl CellId {
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

impl ModeId {
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

impl ResourceId {
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// A token demand or gift: so many of a cell.
pub type TokenDemand = (CellId, u32);

/// Counters stay below this, so that counting on from forged values never overflows.
pub(crate) const NUMBER_MAX: u64 = 1 << 62;
