//! Positions of a plant, by names: what a machine keeps while its power is off.
//!
//! Axes stand where they stood, parts are where they were, and what a motion had done is done. Outputs are off, devices boot,
//! and faults that were injected are gone.

use std::collections::BTreeMap;

use linewright_line::Tick;
use serde::{Deserialize, Serialize};

/// Position of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisPosition {
    /// In its own unit.
    pub at: f64,
    /// Of an endless axis: places left behind.
    #[serde(default)]
    pub left: i64,
}

/// Position of a part. Neither in a nest nor in a hand: it has fallen down.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartPosition {
    pub number: u64,
    /// Name of the nest, and the position in it.
    pub nest: Option<(String, u16)>,
    /// Name of the hand.
    pub hand: Option<String>,
}

/// Positions of everything on one bus.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RackPositions {
    /// By station, by axis.
    pub axes: BTreeMap<String, BTreeMap<String, AxisPosition>>,
    pub parts: Vec<PartPosition>,
    /// By hand's reach of the description: the position in a nest at which it is.
    pub reached: Vec<Option<u16>>,
}

/// Why kept positions are not those of a plant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PositionsMisfit(pub String);

impl std::fmt::Display for PositionsMisfit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for PositionsMisfit {}

/// A misfit with these words.
pub(crate) fn misfit<T>(why: impl Into<String>) -> Result<T, PositionsMisfit> {
    Err(PositionsMisfit(why.into()))
}

/// When positions are looked at, so that they are kept a few times a second at most.
#[derive(Clone, Debug)]
pub struct PositionsWatch {
    every: std::time::Duration,
    looked: Tick,
    kept: Option<RackPositions>,
    /// Time of the next look; none while nothing has moved since the last.
    due: Option<Tick>,
}

impl PositionsWatch {
    /// Positions are looked at no more often than this.
    pub fn new(now: Tick, every: std::time::Duration) -> Self {
        PositionsWatch { every, looked: now, kept: None, due: Some(now) }
    }

    /// Time of the next look, whatever happens.
    pub fn due(&self) -> Option<Tick> {
        self.due
    }

    /// Something may have moved. True if it is time to look.
    pub fn stir(&mut self, now: Tick) -> bool {
        let due = *self.due.get_or_insert(self.looked + self.every);
        due <= now
    }

    /// These are the positions now. Gives them if they have changed.
    pub fn look(&mut self, now: Tick, positions: RackPositions) -> Option<RackPositions> {
        self.looked = now;
        let has_changed = self.kept.as_ref() != Some(&positions);
        // What moves goes on.
        self.due = has_changed.then(|| now + self.every);
        has_changed.then(|| self.kept.insert(positions).clone())
    }
}
