//! History of a cell: a fold over its records, for reports.
//!
//! Everything in a report follows from the records: how long resources were busy, or down and for what cause, how long parts
//! were worked on and how long they waited. Nothing is written down for the sake of a report, and a report made after a restart
//! is the same. What is not in records is in the [`ReportMetadata`]: which resources an activity takes, and how long it should
//! take. A report may be about a span of time: what lay before is folded as well, since what was going on at its beginning
//! follows from that, but not counted.
//!
//! Memory: a few words for each part that has left (for the percentiles) and for each that is inside. Times are those of
//! the records; the clock is the caller's.

mod activities;
mod fold;
mod orders;
mod report;
mod spread;

use std::time::Duration;

use linewright_cell::Prototype;

pub use activities::{Activities, ActivityFailed, FinishedActivity};
pub use fold::{PartHistory, Tracking};
pub use orders::OrdersReport;
pub use report::{Causes, CellSummary, Effectiveness, ResourceReport};
pub use spread::Spread;

use serde::{Deserialize, Serialize};

use super::ids::ModeId;

/// Data of a cell that a report needs beside its records. It is written down beside them, so that a report needs no
/// description.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReportMetadata {
    pub resources: Vec<ResourceEntry>,
    /// Operators' names of the products.
    pub products: Vec<String>,
    /// The modes, in the order of the table.
    pub modes: Vec<ModeEntry>,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResourceEntry {
    pub name: String,
    /// Its kind: a machine, a robot, a store.
    pub prototype: String,
    /// Most parts that it holds, or carries at a time.
    pub capacity: u32,
}

impl ResourceEntry {
    /// Whether it stores parts: a failed activity keeps a part of its own there, and the others come and go as before.
    pub fn stores(&self) -> bool {
        Prototype::ALL.iter().any(|prototype| prototype.stores() && prototype.name() == self.prototype)
    }
}

/// Data of one mode.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModeEntry {
    /// The mode, by its name in the net.
    pub name: String,
    /// The activity, by its operators' name.
    pub activity: String,
    /// Product of its part, as a position in [`ReportMetadata::products`]; none if there is no part.
    pub product: Option<usize>,
    /// Resources of the activity, as positions in [`ReportMetadata::resources`].
    pub resources: Vec<usize>,
    /// The one that works on the part; none if it is only moved.
    pub worker: Option<usize>,
    /// The one that carries it.
    pub carrier: Option<usize>,
    /// The one that holds the part before, and not afterwards.
    pub source: Option<usize>,
    /// The one that holds it afterwards; its room is taken from the start on.
    pub target: Option<usize>,
    /// Nominal time.
    pub nominal: Duration,
    /// Whether its part enters the cell or leaves it.
    pub passing: PartFlow,
}

/// Destination of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PartFlow {
    /// It was inside and stays inside.
    Inside,
    /// It comes from outside.
    Enters,
    /// It goes outside.
    Leaves,
}

impl ReportMetadata {
    /// Data of a mode; none for one that does not exist.
    pub fn entry(&self, mode: ModeId) -> Option<&ModeEntry> {
        self.modes.get(mode.index())
    }

    /// The resources that a failed activity of a mode keeps down: all of its own but stores.
    pub fn kept_down(&self, entry: &ModeEntry) -> impl Iterator<Item = usize> {
        entry.resources.iter().copied().filter(|&at| self.resources.get(at).is_none_or(|of| !of.stores()))
    }
}
