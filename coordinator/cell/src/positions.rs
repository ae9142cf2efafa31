//! Positions of a store that are taken.
//!
//! The net has the number of parts in a store, not their positions, since those enable nothing. A part gets the lowest
//! free position of the store it goes to when it sets out, so that it can be sent to the robot, and keeps the one it comes
//! from until it has arrived: the net returns the room of where it was at the same moment. So there are never more
//! positions in use than the store has.

use std::collections::BTreeSet;

/// Positions of a store, from 1. Equal sets are equal values.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Positions {
    /// No position above is taken.
    most: u32,
    /// Those below that are not.
    free: BTreeSet<u32>,
}

impl Positions {
    /// The lowest that is free is not any more.
    pub fn take_lowest(&mut self) -> u32 {
        self.free.pop_first().unwrap_or_else(|| {
            self.most += 1;
            self.most
        })
    }

    /// Marks one as taken; false if it was not free before, or there is no such position.
    pub fn take(&mut self, position: u32) -> bool {
        if position > self.most {
            self.free.extend(self.most + 1..position);
            self.most = position;
            return true;
        }
        self.free.remove(&position)
    }

    /// It is free again.
    pub fn give(&mut self, position: u32) {
        self.free.insert(position);
        while self.most > 0 && self.free.remove(&self.most) {
            self.most -= 1;
        }
    }
}
