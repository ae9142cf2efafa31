//! A station's report of its orders, as the token player reads it.
//!
//! The crates do not depend on each other. In a plant messages stand between the two; where both are in one process, as in a
//! simulation and under a checker, this does.

use linewright_coordinator_cell::TaskReport;
use linewright_station_logic::TaskOrderReport;

/// The part of a station's report that the token player takes.
pub fn heard(report: &TaskOrderReport) -> TaskReport {
    TaskReport {
        memory: report.memory,
        epoch: report.epoch,
        slot: report.slot.map(|slot| slot.key),
        results: report.results.clone(),
        is_held: report.slot.is_none() && report.rest.is_none(),
        rest: report.rest,
        ..TaskReport::default()
    }
}
