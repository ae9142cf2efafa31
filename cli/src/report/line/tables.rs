//! The report of a line as one JSON object and as tables in CSV. Times are as the report shows them, durations seconds.

use std::path::Path;

use linewright_coordinator_cell::tracking::Spread;
use linewright_history::MotionOutcome;
use linewright_history::line::{Figure, LineState, LineStationReport, LineStopCause, PlannedRow, Stretch, TrendPart};
use miette::{IntoDiagnostic, WrapErr};
use serde::Serialize;

use super::{LineSource, figures, legend, mean};
use crate::report::csv::{events, table};
use crate::report::json::JsonGap;
use crate::report::rows::in_seconds;

/// Everything that is reported.
#[derive(Serialize)]
pub struct LineReportJson {
    line: String,
    title: String,
    from: String,
    to: String,
    observed_s: f64,
    produced_s: f64,
    /// From the coordinator's beginning until the line has produced.
    start_up_s: f64,
    unrecorded_s: f64,
    /// Times in which no coordinator ran.
    unrecorded: Vec<JsonUnrecorded>,
    /// Spans of notes that could not be written.
    gaps: Vec<JsonGap>,
    cycles: JsonCycles,
    stops: Vec<JsonStop>,
    stations: Vec<JsonStation>,
    /// ISO 22400-2.
    figures: JsonFigures,
    /// Null if no operation has been done.
    chart: Option<JsonChart>,
}

#[derive(Serialize)]
struct JsonUnrecorded {
    from: String,
    to: String,
    duration_s: f64,
}

#[derive(Serialize)]
struct JsonCycles {
    planned_s: Option<f64>,
    /// Cycles whose beginning or end may have passed unheard; `time_s` has the others.
    without_time: usize,
    time_s: JsonSpread,
    trend: Vec<JsonTrend>,
}

/// Null where there is nothing to count.
#[derive(Serialize)]
struct JsonSpread {
    count: usize,
    least: Option<f64>,
    mean: Option<f64>,
    median: Option<f64>,
    p90: Option<f64>,
    p99: Option<f64>,
    most: Option<f64>,
}

#[derive(Serialize)]
struct JsonTrend {
    from: String,
    to: String,
    time_s: JsonSpread,
}

#[derive(Serialize)]
struct JsonStop {
    kind: &'static str,
    cause: String,
    times: u64,
    total_s: f64,
    longest_s: f64,
}

#[derive(Serialize)]
struct JsonStation {
    name: String,
    busy_s: f64,
    waits: Vec<JsonWait>,
    other_s: f64,
    motions: u64,
    stopped: u64,
    unseen: u64,
    faults: u64,
}

#[derive(Serialize)]
struct JsonWait {
    why: String,
    times: usize,
    total_s: f64,
}

#[derive(Serialize)]
struct JsonFigures {
    pri_s: Option<f64>,
    pq: u64,
    apt_s: f64,
    adet_s: f64,
    aubt_s: f64,
    list: Vec<JsonFigure>,
}

/// A figure, or why it is left out.
#[derive(Serialize)]
struct JsonFigure {
    name: &'static str,
    formula: &'static str,
    meaning: Option<&'static str>,
    value: Option<f64>,
    left_out: Option<String>,
}

#[derive(Serialize)]
struct JsonChart {
    cycle: i32,
    began: String,
    rows: Vec<JsonChartRow>,
}

#[derive(Serialize)]
struct JsonChartRow {
    station: String,
    operation: String,
    planned_s: Option<(f64, f64)>,
    measured_s: Vec<(f64, f64)>,
}

impl From<&Spread> for JsonSpread {
    fn from(of: &Spread) -> Self {
        let [least, median, p90, p99, most] =
            [of.least, of.median, of.p90, of.p99, of.most].map(|time| (of.count > 0).then_some(in_seconds(time)));
        JsonSpread { count: of.count, least, mean: mean(of).map(in_seconds), median, p90, p99, most }
    }
}

impl LineReportJson {
    /// Of what was read.
    pub fn new(source: &LineSource) -> Self {
        let report = &source.report;
        let trend = |part: &TrendPart| JsonTrend {
            from: source.show(part.span.0),
            to: source.show(part.span.1),
            time_s: (&part.times).into(),
        };
        let gaps = report.gaps.iter().map(|gap| JsonGap {
            from: source.show(gap.span.0),
            to: source.show(gap.span.1),
            lost: gap.lost,
        });
        let unrecorded = source.unrecorded().into_iter().map(|(from, to)| JsonUnrecorded {
            from: source.show(from),
            to: source.show(to),
            duration_s: in_seconds(to.since(from)),
        });
        let stops = report.stops.iter().map(|stop| JsonStop {
            kind: stop.cause.kind.name(),
            cause: stop.cause.text.clone(),
            times: stop.times,
            total_s: in_seconds(stop.total),
            longest_s: in_seconds(stop.longest),
        });
        LineReportJson {
            line: source.about.line.clone(),
            title: source.about.title.clone(),
            from: source.show(report.span.0),
            to: source.show(report.span.1),
            observed_s: in_seconds(report.observed()),
            produced_s: in_seconds(report.producing),
            start_up_s: in_seconds(report.start_up),
            unrecorded_s: in_seconds(report.unrecorded),
            unrecorded: unrecorded.collect(),
            gaps: gaps.collect(),
            cycles: JsonCycles {
                planned_s: report.figures.planned_run_time.map(in_seconds),
                without_time: report.without_time(),
                time_s: (&report.cycle_time).into(),
                trend: report.trend.iter().map(trend).collect(),
            },
            stops: stops.collect(),
            stations: report.stations.iter().map(station).collect(),
            figures: key_figures(source),
            chart: source.chart.as_ref().map(|chart| JsonChart {
                cycle: chart.cycle,
                began: source.show(chart.began),
                rows: chart.rows.iter().map(|row| chart_row(source, row)).collect(),
            }),
        }
    }
}

fn station(of: &LineStationReport) -> JsonStation {
    let wait = |of: &linewright_history::line::WaitTotal| JsonWait {
        why: of.why.clone(),
        times: of.times,
        total_s: in_seconds(of.total),
    };
    JsonStation {
        name: of.name.clone(),
        busy_s: in_seconds(of.busy),
        waits: of.waits.iter().map(wait).collect(),
        other_s: in_seconds(of.other),
        motions: of.motions,
        stopped: of.stopped,
        unseen: of.unseen,
        faults: of.faults,
    }
}

fn key_figures(source: &LineSource) -> JsonFigures {
    let of = &source.report.figures;
    let figure = |(name, formula, figure): (&'static str, &'static str, &Figure)| JsonFigure {
        name,
        formula,
        meaning: legend::meaning(name),
        value: figure.as_ref().ok().copied(),
        left_out: figure.as_ref().err().cloned(),
    };
    JsonFigures {
        pri_s: of.planned_run_time.map(in_seconds),
        pq: of.produced,
        apt_s: in_seconds(of.production),
        adet_s: in_seconds(of.delay),
        aubt_s: in_seconds(of.busy()),
        list: figures(of).into_iter().map(figure).collect(),
    }
}

fn chart_row(source: &LineSource, row: &PlannedRow) -> JsonChartRow {
    let station = &source.about.stations[row.station];
    JsonChartRow {
        station: station.name.clone(),
        operation: station.operations[row.operation].name.clone(),
        planned_s: row.planned,
        measured_s: row.measured.iter().map(|&(from, to, _)| (from, to)).collect(),
    }
}

/// A motion.
#[derive(Default, Serialize)]
struct MotionRow {
    station: String,
    operation: String,
    cycle: i32,
    start: String,
    end: String,
    start_us: u64,
    end_us: u64,
    duration_s: f64,
    how: &'static str,
}

#[derive(Default, Serialize)]
struct WaitRow {
    station: String,
    why: String,
    start: String,
    end: String,
    start_us: u64,
    end_us: u64,
    duration_s: f64,
}

/// A stretch in which the line did not produce.
#[derive(Default, Serialize)]
struct StopRow {
    kind: &'static str,
    cause: String,
    start: String,
    end: String,
    start_us: u64,
    end_us: u64,
    duration_s: f64,
}

#[derive(Default, Serialize)]
struct CycleRow {
    number: i32,
    ended: String,
    ended_us: u64,
    /// Empty where its beginning or its end may have passed unheard.
    duration_s: Option<f64>,
    planned_s: Option<f64>,
}

/// Writes all tables into a directory, which is made if there is none: what ended within the span.
pub fn csv(source: &LineSource, dir: &Path) -> miette::Result<()> {
    std::fs::create_dir_all(dir).into_diagnostic().wrap_err_with(|| format!("cannot make {}", dir.display()))?;
    let (from, to) = source.report.span;
    let stations = || std::iter::zip(&source.about.stations, source.tracking.stations());
    let span = |(start, end): Stretch| (source.show(start), source.show(end), start.as_micros(), end.as_micros());
    let motions = stations().flat_map(|(of, track)| track.motions.iter().map(move |motion| (of, motion)));
    let motions = motions.filter(|(_, motion)| motion.to >= from).map(|(of, motion)| {
        let (start, end, start_us, end_us) = span((motion.from, motion.to));
        MotionRow {
            station: of.name.clone(),
            operation: of.operations.get(motion.operation).map(|of| of.name.clone()).unwrap_or_default(),
            cycle: motion.cycle,
            start,
            end,
            start_us,
            end_us,
            duration_s: in_seconds(motion.to.since(motion.from)),
            how: how(motion.end),
        }
    });
    table(dir, "motion.csv", motions)?;
    let waits = stations().flat_map(|(of, track)| track.waits.iter().map(move |wait| (of, wait)));
    let waits = waits.filter(|(_, wait)| wait.to >= from).map(|(of, wait)| {
        let (start, end, start_us, end_us) = span((wait.from, wait.to));
        let (station, why) = (of.name.clone(), wait.why.clone());
        WaitRow { station, why, start, end, start_us, end_us, duration_s: in_seconds(wait.to.since(wait.from)) }
    });
    table(dir, "wait.csv", waits)?;
    let stops = source.tracking.states(to).filter(|(stretch, _)| stretch.1 >= from);
    let stops = stops.filter_map(|(stretch, state)| {
        // What is not recorded, and a start-up, are no stops.
        let LineState::Stopped(LineStopCause { kind, text: cause }) = state else { return None };
        let kind = kind.name();
        let (start, end, start_us, end_us) = span(stretch);
        let duration_s = in_seconds(stretch.1.since(stretch.0));
        Some(StopRow { kind, cause: cause.clone(), start, end, start_us, end_us, duration_s })
    });
    table(dir, "stop.csv", stops)?;
    let planned_s = source.report.figures.planned_run_time.map(in_seconds);
    let cycles = source.report.cycles.iter().map(|cycle| CycleRow {
        number: cycle.number,
        ended: source.show(cycle.ended),
        ended_us: cycle.ended.as_micros(),
        duration_s: cycle.took.map(in_seconds),
        planned_s,
    });
    table(dir, "cycle.csv", cycles)?;
    events(&source.reader, source.report.span, dir, |event| super::mcap::row(source, event))
}

fn how(end: MotionOutcome) -> &'static str {
    match end {
        MotionOutcome::Done => "done",
        MotionOutcome::Undone => "undone",
        MotionOutcome::Stopped => "stopped",
        MotionOutcome::Unseen => "unseen",
    }
}
