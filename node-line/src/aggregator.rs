//! The parameter file of `diagnostic_aggregator` for a line: a group for the coordinator and one for each station, with its devices.
//!
//! Each status is named in one group, as expected: the aggregator then shows one that is missing or late as stale, which no node can
//! report of itself.

use std::fmt::Write;

use linewright_line::{DeviceBus, Line, Owner, StationId};
use linewright_station_shell::STATION_CHECKS;

/// Time after which the aggregator shows a status as stale, in s: some of the periods that `diagnostics_period_s` is at the start.
const STALE_AFTER_S: f64 = 5.0;

/// A group of the aggregator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiagnosticGroup {
    /// The node.
    pub name: String,
    /// Names of all its statuses.
    pub expected: Vec<String>,
}

/// The groups of a line whose coordinator has these checks.
pub fn diagnostic_groups(line: &Line, of_coordinator: &[&str]) -> Vec<DiagnosticGroup> {
    // Devices of the line's bus are reported by the coordinator.
    let devices = |owner: Owner| {
        let of = line.devices_of(owner);
        of.map(move |device| match (device.bus == DeviceBus::Line, owner) {
            (false, Owner::Station(id)) => format!("{}: {}", line.station(id).name, device.name),
            _ => format!("coordinator: {}", device.name),
        })
    };
    let checks = |node: &str, checks: &[&str]| -> Vec<String> {
        checks.iter().map(|check| format!("{node}: {check}")).collect()
    };
    let of_station = |id: StationId| {
        let name = line.station(id).name.clone();
        let expected = checks(&name, &STATION_CHECKS).into_iter().chain(devices(Owner::Station(id))).collect();
        DiagnosticGroup { name, expected }
    };
    let own = checks("coordinator", of_coordinator).into_iter().chain(devices(Owner::Console)).collect();
    let coordinator = DiagnosticGroup { name: "coordinator".to_owned(), expected: own };
    std::iter::once(coordinator).chain(line.station_ids().map(of_station)).collect()
}

/// The file, in the form of ROS 2 parameters.
pub fn aggregator_file(line: &Line, of_coordinator: &[&str]) -> String {
    let mut text = format!("analyzers:\n  ros__parameters:\n    path: {}\n    pub_rate: 1.0\n", line.name);
    for DiagnosticGroup { name, expected } in diagnostic_groups(line, of_coordinator) {
        // Writing to a text does not fail.
        let _ = write!(
            text,
            "    {name}:\n      type: diagnostic_aggregator/GenericAnalyzer\n      path: {name}\n      timeout: {STALE_AFTER_S:?}\n      expected:\n"
        );
        expected.iter().for_each(|status| {
            let _ = writeln!(text, "        - '{}'", status.replace('\'', "''"));
        });
    }
    text
}
