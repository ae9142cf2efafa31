//! A station's report of its orders, as the token player reads it.
//!
//! The crates do not depend on each other. In a plant messages stand between the two; where both are in one process, as in a
//! simulation and under a checker, this does.

use linewright_coordinator_cell::exception::Participation;
use linewright_coordinator_cell::{Coordination, TaskReport};
use linewright_coordinator_logic::ManualPermit;
use linewright_line::{Line, StationId, Tick};
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
        is_in_handshake: report.is_in_handshake,
        ..TaskReport::default()
    }
}

/// What the cell permits at a station while the others are in auto.
pub fn manual_permit(coordination: &Coordination, line: &Line, now: Tick, station: StationId) -> ManualPermit {
    match coordination.participation(now, station) {
        Participation::InService => ManualPermit::InService,
        Participation::Securing => ManualPermit::Securing,
        Participation::LeftOut { tasks, kept_in } => {
            let known = line.station(station).tasks.iter().take(64).enumerate();
            let its = known.filter(|(_, task)| tasks.iter().any(|name| **name == *task.name));
            ManualPermit::LeftOut { tasks: its.fold(0, |bits, (at, _)| bits | 1 << at), kept_in }
        }
    }
}
