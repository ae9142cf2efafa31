//! What a cell has done: a fold over its records, for reports.
//!
//! Records say what has happened, so everything a report wants follows from them: who was busy for how long and who was
//! down for what cause, how long parts were worked on and how long they waited. Nothing is written down for the sake of a
//! report, and a report made after a restart says the same. What records do not say is in the [`Sheet`]: which resources
//! an activity takes, and how long it should take.
//!
//! Memory: a few words for each part that has left (for the percentiles) and for each that is inside. Times are those of
//! the records; the clock is the caller's.

mod fold;
mod report;
mod spread;

use std::sync::Arc;
use std::time::Duration;

pub use fold::Tracking;
pub use report::{Causes, Report, ResourceReport};
pub use spread::Spread;

use super::ids::ModeId;

/// What a report has to know of a cell beside its records.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sheet {
    /// The resources, by what people call them.
    pub resources: Vec<Arc<str>>,
    /// The modes, in the order of the table.
    pub modes: Vec<Entry>,
}

/// What one mode is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The activity, by what people call it.
    pub activity: Arc<str>,
    /// Who takes part in it, as positions in [`Sheet::resources`].
    pub resources: Vec<usize>,
    /// Who of them works on the part; none if it is only moved.
    pub worker: Option<usize>,
    /// How long it should take.
    pub nominal: Duration,
    /// Whether its part enters the cell or leaves it.
    pub passing: Passing,
}

/// Where a part goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passing {
    /// It was inside and stays inside.
    Inside,
    /// It comes from outside.
    Enters,
    /// It goes outside.
    Leaves,
}

impl Sheet {
    pub(super) fn entry(&self, mode: ModeId) -> Option<&Entry> {
        self.modes.get(mode.index())
    }
}
