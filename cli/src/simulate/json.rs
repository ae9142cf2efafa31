//! The one object that `--json` prints.

use linewright_line::Line;
use linewright_simulation::{LastWait, LineSim};
use serde::Serialize;

use super::report::{OperationSpan, SimulationReport, micros, op_text};

/// Everything that came out. Times are seconds.
#[derive(Serialize)]
pub struct SimulationJson {
    line: String,
    ok: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    scenario: Option<String>,
    cycles: usize,
    cycle_time_s: Option<f64>,
    planned_cycle_time_s: f64,
    cycle_ends_s: Vec<f64>,
    drawn_cycle: i32,
    operations: Vec<JsonOperation>,
    critical_path: Vec<Critical>,
    waits: Vec<JsonWait>,
    conflicts: Vec<JsonConflict>,
    faults: Vec<JsonFault>,
    withdrawn: u64,
    /// Events before those that are kept.
    events_forgotten: u64,
    events: Vec<String>,
}

#[derive(Serialize)]
struct JsonOperation {
    station: String,
    operation: String,
    planned: Option<JsonSpan>,
    simulated: Option<JsonSpan>,
    critical: bool,
    done: i32,
}

#[derive(Serialize)]
struct JsonSpan {
    start_s: f64,
    end_s: f64,
}

#[derive(Serialize)]
struct Critical {
    operation: String,
    cycle: i32,
    duration_s: f64,
    /// Last wait: `step` or the arrow's tail.
    waited_for: String,
    late_s: f64,
}

#[derive(Serialize)]
struct JsonWait {
    operation: String,
    waits_for: String,
    starts: u64,
    total_s: f64,
    mean_s: f64,
}

#[derive(Serialize)]
struct JsonConflict {
    at_s: f64,
    why: String,
    positions: String,
}

#[derive(Serialize)]
struct JsonFault {
    at_s: f64,
    operation: String,
    cause: &'static str,
}

impl SimulationJson {
    /// The object of a run.
    pub fn new(line: &Line, sim: &LineSim, report: &SimulationReport) -> Self {
        let span = |bar: OperationSpan| JsonSpan { start_s: bar.0, end_s: bar.1 };
        let operations = report.rows.iter().map(|row| JsonOperation {
            station: line.station(row.station).name.clone(),
            operation: line.operation((row.station, row.op)).name.clone(),
            planned: row.planned.map(span),
            simulated: row.simulated.map(span),
            critical: row.is_critical,
            done: sim.done(row.station, row.op),
        });
        let waits = report.waits.iter().map(|&(arrow, starts, total_s)| JsonWait {
            operation: op_text(line, line.arrows[arrow].to),
            waits_for: op_text(line, line.arrows[arrow].from),
            starts,
            total_s,
            mean_s: micros(total_s / starts as f64),
        });
        SimulationJson {
            line: line.name.clone(),
            ok: report.error.is_none(),
            error: report.error.clone(),
            scenario: report.title.clone(),
            cycles: report.cycles,
            cycle_time_s: report.cycle_time_s.map(micros),
            planned_cycle_time_s: micros(report.planned_s),
            cycle_ends_s: report.ends_s.clone(),
            drawn_cycle: report.drawn,
            operations: operations.collect(),
            critical_path: critical(line, report),
            waits: waits.collect(),
            conflicts: conflicts(line, sim),
            faults: faults(line, sim),
            withdrawn: sim.record().withdrawn(),
            events_forgotten: sim.log().forgotten(),
            events: sim.log().entries().iter().map(|entry| entry.text(line)).collect(),
        }
    }
}

fn critical(line: &Line, report: &SimulationReport) -> Vec<Critical> {
    let links = report.critical.iter().flat_map(|path| &path.links);
    links
        .map(|link| Critical {
            operation: op_text(line, (link.motion.station, link.motion.op)),
            cycle: link.motion.cycle,
            duration_s: link.motion.end.since(link.motion.start).as_secs_f64(),
            waited_for: match link.motion.by {
                LastWait::Arrow(arrow) => op_text(line, line.arrows[arrow].from),
                LastWait::Previous | LastWait::Person => "step".to_owned(),
            },
            late_s: link.late.as_secs_f64(),
        })
        .collect()
}

fn conflicts(line: &Line, sim: &LineSim) -> Vec<JsonConflict> {
    let seen = sim.conflicts().iter();
    seen.map(|seen| JsonConflict {
        at_s: seen.at.as_secs_f64(),
        why: line.conflicts[seen.conflict].why.clone(),
        positions: seen.positions.clone(),
    })
    .collect()
}

fn faults(line: &Line, sim: &LineSim) -> Vec<JsonFault> {
    let faults = sim.record().faults().iter();
    faults
        .map(|fault| JsonFault {
            at_s: fault.at.as_secs_f64(),
            operation: op_text(line, (fault.station, fault.op)),
            cause: fault.cause.text(),
        })
        .collect()
}
