//! Times of the orders of an activity, by distributions: each activity draws from a stream of its own.

use std::collections::BTreeMap;

use linewright_coordinator_cell::{FiringId, ModeId};

use super::distribution::Distribution;
use crate::rng::Rng;

/// Activities that can be in progress before those that are over are removed.
const DRAWN_MAX: usize = 10_000;

/// Factors on described times.
#[derive(Clone, Debug, Default)]
pub struct TaskTimes {
    /// Of each mode the stream, if its time is drawn.
    of_mode: Vec<Option<usize>>,
    streams: Vec<(Distribution, Rng)>,
    /// All orders of one activity take the time that was drawn for it, however often they are sent.
    drawn: BTreeMap<FiringId, f64>,
}

impl TaskTimes {
    /// Streams, and of each mode of the table which of them it draws from.
    pub fn new(of_mode: Vec<Option<usize>>, streams: Vec<(Distribution, Rng)>) -> Self {
        TaskTimes { of_mode, streams, drawn: BTreeMap::new() }
    }

    /// Factor on the described time of an activity in progress; none if it is as described.
    pub(super) fn factor(&mut self, firing: FiringId, mode: ModeId) -> Option<f64> {
        let stream = (*self.of_mode.get(mode.index())?)?;
        if let Some(&drawn) = self.drawn.get(&firing) {
            return Some(drawn);
        }
        let (distribution, rng) = self.streams.get_mut(stream)?;
        let drawn = distribution.draw(rng);
        self.drawn.insert(firing, drawn);
        // Those that began long ago have been sent for the last time.
        while self.drawn.len() > DRAWN_MAX {
            self.drawn.pop_first();
        }
        Some(drawn)
    }
}
