//! Result of a simulation, as numbers and as text.
//!
//! Pure: it is given a simulation that has ended.

use std::fmt::Write;

use linewright_line::net::Block;
use linewright_line::{Line, OpId, StationId};
use linewright_simulation::{
    CriticalPath, LastWait, LinePlan, LineSim, MotionEnd, RecordedMotion, RunEnd, RunGoal, RunRecord, Scenario,
};

/// Start and end of an operation in the drawn cycle, in seconds after that cycle began.
pub type OperationSpan = (f64, f64);

/// One operation of the drawn cycle.
pub struct OperationRow {
    pub station: StationId,
    pub op: OpId,
    /// By the description alone.
    pub planned: Option<OperationSpan>,
    /// By the controllers.
    pub simulated: Option<OperationSpan>,
    /// It is on the critical path.
    pub is_critical: bool,
}

/// Result of a simulation.
pub struct SimulationReport {
    /// Cycles requested.
    pub asked: usize,
    /// Cycles that ended.
    pub cycles: usize,
    /// When each ended, in seconds after the first motion began.
    pub ends_s: Vec<f64>,
    /// Cycle time when the line has run in: the mean of all but the first that went undisturbed. Where the first is the
    /// only one, that one.
    pub cycle_time_s: Option<f64>,
    /// Cycle time planned from the description alone.
    pub planned_s: f64,
    /// The cycle that is drawn.
    pub drawn: i32,
    pub rows: Vec<OperationRow>,
    /// The chain that determines the cycle time.
    pub critical: Option<CriticalPath>,
    /// Waits between stations: arrow, number of starts, seconds together.
    pub waits: Vec<(usize, u64, f64)>,
    /// Why the run was no success.
    pub error: Option<String>,
    /// The scenario's title.
    pub title: Option<String>,
}

impl SimulationReport {
    pub fn new(sim: &LineSim, end: &RunEnd, goal: &RunGoal, scenario: Option<&Scenario>) -> Self {
        let (line, record) = (sim.line(), sim.record());
        let origin = record.began().map_or(0.0, |began| began.as_micros() as f64);
        let ends_s: Vec<f64> = record.cycle_ends().iter().map(|at| (at.as_micros() as f64 - origin) / 1e6).collect();
        let plan = LinePlan::of(line);
        let critical = CriticalPath::of(line, record);
        let every = line.station_ids().flat_map(|id| line.station(id).op_ids().map(move |op| (id, op)));
        let drawn = every.map(|(id, op)| record.count(id, op)).min().unwrap_or(0);
        let mut waits: Vec<(usize, u64, f64)> = record
            .waits()
            .iter()
            .enumerate()
            .filter(|(_, wait)| wait.starts > 0)
            .map(|(arrow, wait)| (arrow, wait.starts, micros(wait.total.as_secs_f64())))
            .collect();
        // By the mean, which is what is shown.
        let mean = |wait: &(usize, u64, f64)| wait.2 / wait.1 as f64;
        waits.sort_by(|a, b| mean(b).total_cmp(&mean(a)));
        SimulationReport {
            asked: goal.cycles,
            cycles: record.cycles(),
            cycle_time_s: cycle_time(&ends_s, record),
            ends_s,
            planned_s: plan.cycle_time() / 1e6,
            drawn,
            rows: rows(sim, &plan, drawn, critical.as_ref()),
            critical,
            waits,
            error: end_text(sim, end),
            title: scenario.and_then(|scenario| scenario.title.clone()),
        }
    }

    /// The report as text, with the bar chart as text in it.
    pub fn text(&self, line: &Line, chart: &str) -> String {
        let mut text = String::new();
        let _ = writeln!(text, "{}", line.title);
        if let Some(title) = &self.title {
            let _ = writeln!(text, "{title}");
        }
        let total = self.ends_s.last().map_or(String::new(), |end| format!(" in {end:.3} s"));
        let _ = writeln!(text, "{} of {} cycles done{total}", self.cycles, self.asked);
        if let Some(time) = self.cycle_time_s {
            let _ = writeln!(text, "cycle time {time:.3} s simulated, {:.3} s planned", self.planned_s);
        }
        if self.rows.iter().any(|row| row.simulated.is_some()) {
            let _ = writeln!(text, "\ncycle {}:  ▀ planned  ▄ simulated  █ both  ! critical", self.drawn);
            text.push_str(chart);
        }
        if let Some(path) = &self.critical {
            text.push_str(&critical_text(line, path));
        }
        if !self.waits.is_empty() {
            text.push_str("\nwaiting times at arrows, after the waiting station was ready:\n");
            for (arrow, starts, seconds) in &self.waits {
                let arrow = &line.arrows[*arrow];
                let mean = seconds / *starts as f64;
                let _ = writeln!(text, "  {mean:8.3} s  {} for {}", op_text(line, arrow.to), op_text(line, arrow.from));
            }
        }
        text
    }
}

/// An operation with its station.
pub fn op_text(line: &Line, (id, op): (StationId, OpId)) -> String {
    format!("{}: {}", line.station(id).name, line.operation((id, op)).name)
}

fn cycle_time(ends: &[f64], record: &RunRecord) -> Option<f64> {
    if let ([only], []) = (ends, record.faults()) {
        return Some(*only);
    }
    let went = record.undisturbed().iter().skip(1);
    let times: Vec<f64> =
        ends.windows(2).zip(went).filter(|(_, went)| **went).map(|(pair, _)| pair[1] - pair[0]).collect();
    (!times.is_empty()).then(|| times.iter().sum::<f64>() / times.len() as f64)
}

/// Seconds to the microsecond: a difference of two moments has more digits than are significant.
pub fn micros(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e6
}

fn rows(sim: &LineSim, plan: &LinePlan, cycle: i32, critical: Option<&CriticalPath>) -> Vec<OperationRow> {
    let line = sim.line();
    // Far enough to be steady, and no further: a long run's plan repeats itself.
    let shown = cycle.clamp(0, 200);
    let schedule = plan.schedule(usize::try_from(shown).unwrap_or(0) + 1);
    let drawn = |motion: &&RecordedMotion| {
        motion.cycle == cycle && motion.block == Block::Normal && motion.ended == MotionEnd::Done
    };
    let mut rows = Vec::new();
    for id in line.station_ids() {
        for op in line.station(id).op_ids() {
            let of = |motion: &&RecordedMotion| (motion.station, motion.op) == (id, op);
            let motion = sim.record().motions().iter().rev().filter(drawn).find(of);
            let planned = plan.planned(&schedule, (id, op), shown);
            let is_critical =
                critical.is_some_and(|path| path.links.iter().any(|l| (l.motion.station, l.motion.op) == (id, op)));
            rows.push(OperationRow {
                station: id,
                op,
                planned: planned.map(|p| (p.start as f64 / 1e6, p.end as f64 / 1e6)),
                simulated: motion.map(|m| (m.start.as_secs_f64(), m.end.as_secs_f64())),
                is_critical,
            });
        }
    }
    // Both charts begin where their first operation does.
    let first = |bars: &mut dyn Iterator<Item = OperationSpan>| bars.map(|bar| bar.0).fold(f64::INFINITY, f64::min);
    let planned = first(&mut rows.iter().filter_map(|row| row.planned));
    let simulated = first(&mut rows.iter().filter_map(|row| row.simulated));
    for row in &mut rows {
        row.planned = row.planned.map(|(start, end)| (micros(start - planned), micros(end - planned)));
        row.simulated = row.simulated.map(|(start, end)| (micros(start - simulated), micros(end - simulated)));
    }
    rows
}

fn critical_text(line: &Line, path: &CriticalPath) -> String {
    let cycles = if path.cycles == 1 { String::new() } else { format!(" over {} cycles", path.cycles) };
    let mut text = format!("\ncritical path, {:.3} s{cycles}:\n", path.time.as_secs_f64());
    for link in &path.links {
        let motion = &link.motion;
        let how = if let LastWait::Arrow(_) = motion.by {
            format!("arrow, {:.1} ms", link.late.as_secs_f64() * 1e3)
        } else {
            String::new()
        };
        let seconds = motion.end.since(motion.start).as_secs_f64();
        let _ = writeln!(text, "  {:13} {seconds:6.3} s  {}", how, op_text(line, (motion.station, motion.op)));
    }
    text
}

/// Why a run was no success; `None` if it was one.
pub fn end_text(sim: &LineSim, end: &RunEnd) -> Option<String> {
    let line = sim.line();
    match end {
        RunEnd::Done => None,
        RunEnd::Conflict => {
            let conflicts = sim.conflicts().iter().map(|seen| {
                let conflict = &line.conflicts[seen.conflict];
                format!("conflict at {}: {} ({})", seen.at, conflict.why, seen.positions)
            });
            let alarms = (sim.alarms() > 0).then(|| "both actuators of one axis were on at once".to_owned());
            Some(conflicts.chain(alarms).collect::<Vec<_>>().join("\n"))
        }
        RunEnd::Miscounted => Some(sim.record().errors().join("\n")),
        RunEnd::Stuck(reasons) => {
            Some(format!("nothing happens any more after {}:\n  {}", sim.now(), reasons.join("\n  ")))
        }
        RunEnd::Failed { step: None, why } => Some(format!("the line does not start: {why}")),
        RunEnd::Failed { step: Some(step), why } => Some(format!("step {} of the scenario: {why}", step + 1)),
        RunEnd::Spins => Some(format!("no time passes any more at {}; this is a mistake of the program", sim.now())),
    }
}
