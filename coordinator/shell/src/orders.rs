//! A station's report of its orders, as the token player reads it.
//!
//! Neither crate knows the other. In a plant messages stand between the two; where both are in one process, as in a simulation
//! and under a checker, this does.

use linewright_coordinator_cell::TaskReport;
use linewright_station_logic::TaskOrderReport;

/// What the token player takes from a station's report.
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
