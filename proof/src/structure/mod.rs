//! Properties of a line by its structure, without playing it: of each station's net, of the mode decision, and of the
//! timing bar chart as an event graph. It takes time linear in the size of the line, or nearly, so it is what scales.
//!
//! It covers each station, and the forward motion of all of them. Effects of faults, operators and delayed messages on
//! the composed line are for [`crate::explore`].

pub mod chart;
mod modes;
mod station;

use linewright_line::{Line, OperationModule, Station, StationId};
use serde::Serialize;

/// Findings on one station.
#[derive(Clone, Debug, Serialize)]
pub struct StructureReport {
    /// Name of the station.
    pub name: String,
    /// Reversible operations, j.
    pub reversible: usize,
    /// Irreversible operations, k.
    pub irreversible: usize,
    /// Places of its net.
    pub places: usize,
    /// Transitions of its net.
    pub transitions: usize,
    pub checks: Vec<Check>,
}

/// One property, and why it holds or does not.
#[derive(Clone, Debug, Serialize)]
pub struct Check {
    /// Name of the check.
    pub name: String,
    /// Whether it holds.
    pub ok: bool,
    /// Why, or why not.
    pub reason: String,
    /// The arrows that the reason names, by their place in the line.
    #[serde(skip)]
    pub arrows: Vec<usize>,
}

impl Check {
    /// A property with what decided it: `Ok` is why it holds, `Err` why it does not.
    pub fn of(name: impl Into<String>, found: Result<String, String>) -> Self {
        let ok = found.is_ok();
        Check { name: name.into(), ok, reason: found.unwrap_or_else(|why_not| why_not), arrows: Vec::new() }
    }
}

impl StructureReport {
    /// An empty report on a station.
    fn of(station: &Station, places: usize, transitions: usize) -> Self {
        let is_reversible = |module: &OperationModule| matches!(module, OperationModule::Reversible { .. });
        let reversible = station.operations.iter().filter(|op| is_reversible(&op.module)).count();
        StructureReport {
            name: station.name.clone(),
            reversible,
            irreversible: station.operations.len() - reversible,
            places,
            transitions,
            checks: Vec::new(),
        }
    }

    /// Whether all its checks hold.
    pub fn ok(&self) -> bool {
        self.checks.iter().all(|check| check.ok)
    }
}

/// Stations that are worth a thread of their own.
const SHARE_MIN: usize = 32;
/// At most so many threads.
const SHARES_MAX: usize = 4;

/// Checks the net of each station, and its tables. What one is found to be has nothing to do with the others, so
/// those of a long line are shared out.
pub fn judge_stations(line: &Line) -> Vec<StructureReport> {
    let ids: Vec<StationId> = line.station_ids().collect();
    let shares = (ids.len() / SHARE_MIN).clamp(1, SHARES_MAX);
    let judge = |ids: &[StationId]| ids.iter().map(|&id| station::judge(line, id)).collect::<Vec<_>>();
    std::thread::scope(|scope| {
        let mut shares = ids.chunks(ids.len().div_ceil(shares).max(1));
        let first = shares.next().unwrap_or_default();
        let others: Vec<_> = shares.map(|share| scope.spawn(move || judge(share))).collect();
        let mut reports = judge(first);
        for other in others {
            match other.join() {
                Ok(found) => reports.extend(found),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        reports
    })
}

/// Checks what concerns the whole line: home, the event graph, the mode decision, and each conflict in forward motion.
pub fn judge_line(line: &Line) -> Vec<Check> {
    let mut checks = vec![
        Check::of("home", chart::home_is_consistent(line)),
        Check::of("operation causality", chart::every_circuit_has_a_token(line)),
        Check::of("mode decision net", modes::verdict()),
        Check::of("mode decision exclusive", modes::at_most_one_arc()),
        Check::of("manual from every mode", modes::manual_from_everywhere()),
    ];
    // Tasks are kept apart by orders, which are not in the chart.
    let line = &line.without_conflicts_of_tasks();
    let separated = line.conflicts.iter().zip(chart::all_separated(line));
    checks.extend(separated.map(|(conflict, found)| {
        let arrows = found.as_ref().err().map(|gap| gap.arrows().to_vec()).unwrap_or_default();
        let check = Check::of(format!("separated: {}", conflict.why), found.map_err(|gap| gap.to_string()));
        Check { arrows, ..check }
    }));
    checks
}

/// An operation's full name.
fn full_name(line: &Line, (station, op): (StationId, linewright_line::OpId)) -> String {
    format!("{}: {}", line.station(station).name, line.operation((station, op)).name)
}
