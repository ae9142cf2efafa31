//! Result of a simulation of a cell, from its records: parts, activities, and utilisation of resources.

use linewright_cell::Cell;
use linewright_coordinator_cell::Record;
use linewright_coordinator_cell::compile::{CompiledCell, sheet};
use linewright_coordinator_cell::tracking::{Activities, CellSummary, FinishedActivity, PartHistory, Tracking};
use linewright_line::Tick;

/// Result of a simulated production.
pub struct ProductionResult {
    /// In the order in which they came.
    pub parts: Vec<PartHistory>,
    /// In the order in which they started, without those that take no time: they are no bar in a chart.
    pub activities: Vec<FinishedActivity>,
    /// Summary of the same.
    pub report: CellSummary,
    /// When the last part left, or the last thing happened.
    pub end: Tick,
}

impl ProductionResult {
    /// Result from records.
    pub fn new(cell: &Cell, played: &CompiledCell, records: &[Record]) -> Self {
        let end = records.last().map_or(Tick::ZERO, |record| record.at);
        let (mut tracking, mut activities) = (Tracking::new(sheet(cell, played)), Activities::default());
        for record in records {
            tracking.take(record);
            activities.take(record);
        }
        let mut parts: Vec<PartHistory> = tracking.passages().copied().collect();
        parts.sort_unstable_by_key(|part| part.part);
        let timed = activities.all().iter().filter(|done| done.ended != Some(done.began));
        ProductionResult { parts, activities: timed.cloned().collect(), report: tracking.report(end), end }
    }
}
