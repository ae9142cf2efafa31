//! Report of a line, as numbers.
//!
//! Names and formulas are those of ISO 22400-2 (key performance indicators for manufacturing operations management). The work
//! unit is the line, an item a cycle of it. A figure that needs what no note contains is left out, with the reason.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::time::Duration;

use linewright_coordinator_cell::tracking::Spread;
use linewright_line::Tick;

use super::{LineCycle, LineGap, LineState, LineStopCause, LineTracking, Spans, StationTrack, StopKind, Stretch};
use crate::MotionOutcome;

/// In so many parts of the span a trend is shown.
const TREND_PARTS_MAX: usize = 10;

/// Parameters of a report that no note contains.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReportParameters {
    /// PBT, the planned busy time in the span: a shift calendar is nowhere recorded.
    pub planned_busy: Option<Duration>,
    /// Items that were not good.
    pub rejected: Option<u64>,
}

/// A figure, or why it is left out.
pub type Figure = Result<f64, String>;

/// Key figures of ISO 22400-2.
#[derive(Clone, Debug, PartialEq)]
pub struct LineFigures {
    /// PRI, planned run time per item: the cycle time by the description alone.
    pub planned_run_time: Option<Duration>,
    /// PQ, produced quantity: the cycles.
    pub produced: u64,
    /// APT, actual production time.
    pub production: Duration,
    /// ADET, actual unit delay time: stops that no operator has commanded.
    pub delay: Duration,
    /// APT / AUBT.
    pub utilization_efficiency: Figure,
    /// APT / PBT.
    pub availability: Figure,
    /// PRI · PQ / APT.
    pub effectiveness: Figure,
    /// GQ / PQ.
    pub quality_ratio: Figure,
    /// Availability · effectiveness · quality ratio.
    pub oee: Figure,
}

impl LineFigures {
    /// AUBT, actual unit busy time: APT and ADET; setup times (AUST) are not recorded.
    pub fn busy(&self) -> Duration {
        self.production + self.delay
    }
}

/// Stops of one cause.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StopTotal {
    pub cause: LineStopCause,
    pub times: u64,
    pub total: Duration,
    pub longest: Duration,
}

/// Waits of a station for one cause.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WaitTotal {
    pub why: String,
    pub times: usize,
    pub total: Duration,
}

/// One station, while the line has produced.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineStationReport {
    pub name: String,
    /// An operation was in motion.
    pub busy: Duration,
    /// By cause, the longest first.
    pub waits: Vec<WaitTotal>,
    /// Neither: between two motions, or in one that is not over yet.
    pub other: Duration,
    /// Motions that were completed.
    pub motions: u64,
    /// Motions that ended on their way.
    pub stopped: u64,
    /// Motions of which nothing but the count was seen.
    pub unseen: u64,
    pub faults: u64,
}

/// Cycle times in a part of the span.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrendPart {
    pub span: Stretch,
    pub times: Spread,
}

/// A line in a span of time.
#[derive(Clone, Debug, PartialEq)]
pub struct LineReport {
    pub span: Stretch,
    /// Time in production: APT.
    pub producing: Duration,
    /// Time from the coordinator's beginning until the line has produced.
    pub start_up: Duration,
    /// Time without a record.
    pub unrecorded: Duration,
    /// Spans of which notes could not be written; a part of the time without a record.
    pub gaps: Vec<LineGap>,
    /// By cause, the longest first.
    pub stops: Vec<StopTotal>,
    pub cycles: Vec<LineCycle>,
    pub cycle_time: Spread,
    pub trend: Vec<TrendPart>,
    pub stations: Vec<LineStationReport>,
    pub figures: LineFigures,
}

impl LineReport {
    /// Number of cycles whose beginning or end may have passed unheard.
    pub fn without_time(&self) -> usize {
        self.cycles.iter().filter(|cycle| cycle.took.is_none()).count()
    }

    pub fn observed(&self) -> Duration {
        self.span.1.since(self.span.0)
    }
}

/// One operation of a cycle, in seconds after the first operation of the cycle began.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedRow {
    pub station: usize,
    pub operation: usize,
    pub planned: Option<(f64, f64)>,
    /// From, to, and whether it was stopped on its way.
    pub measured: Vec<(f64, f64, bool)>,
}

/// A cycle as it was planned and as it was.
#[derive(Clone, Debug, PartialEq)]
pub struct CycleChart {
    pub cycle: i32,
    /// Start of its first operation.
    pub began: Tick,
    pub rows: Vec<PlannedRow>,
}

fn clipped((from, to): Stretch, (begin, end): Stretch) -> Option<Stretch> {
    let (from, to) = (from.max(begin), to.min(end));
    (from < to).then_some((from, to))
}

fn share(part: Duration, whole: Duration, why: &str) -> Figure {
    if whole.is_zero() { Err(why.to_owned()) } else { Ok(part.as_secs_f64() / whole.as_secs_f64()) }
}

impl LineTracking {
    /// Report of a span, which ends no later than the notes taken.
    pub fn report(&self, span: Stretch, asked: &ReportParameters) -> LineReport {
        let within = || self.states(span.1).filter_map(|(of, state)| Some((clipped(of, span)?, state)));
        let is = |wanted: &LineState| Spans::of(within().filter(|(_, state)| *state == wanted).map(|(of, _)| of));
        let producing = is(&LineState::Producing);
        let mut recorded = Spans::of([span]);
        recorded
            .take(&Spans::of(within().filter(|(_, state)| !matches!(state, LineState::Unrecorded)).map(|(of, _)| of)));
        let stops = stops(within());
        let cycles: Vec<LineCycle> =
            self.cycles.iter().filter(|cycle| cycle.ended > span.0 && cycle.ended <= span.1).copied().collect();
        let delays = stops.iter().filter(|stop| stop.cause.kind != StopKind::Operator);
        let delay = delays.map(|stop| stop.total).sum();
        let stations = self.about.stations.iter().zip(&self.stations);
        LineReport {
            span,
            producing: producing.total(),
            start_up: is(&LineState::StartUp).total(),
            unrecorded: recorded.total(),
            gaps: self.gaps.iter().filter(|gap| gap.span.1 >= span.0 && gap.span.0 <= span.1).copied().collect(),
            cycle_time: Spread::of(cycles.iter().filter_map(|cycle| cycle.took).collect()),
            trend: trend(span, &cycles),
            stations: stations.map(|(of, track)| station(&of.name, track, &producing, span)).collect(),
            figures: self.figures(&producing, delay, &cycles, asked),
            stops,
            cycles,
        }
    }

    fn figures(
        &self,
        producing: &Spans,
        delay: Duration,
        cycles: &[LineCycle],
        asked: &ReportParameters,
    ) -> LineFigures {
        let production = producing.total();
        let (planned_us, produced) = (self.about.cycle_us, cycles.len() as u64);
        let planned = (planned_us > 0).then(|| Duration::from_micros(planned_us));
        let never = "nothing was produced (APT is 0)";
        let effectiveness = match planned {
            None => Err("the description plans no cycle (PRI)".to_owned()),
            // Each cycle for itself: one that was faster makes up for no other.
            Some(planned) => {
                let mut rest = producing.clone();
                let mut last_end = Tick::ZERO;
                let ran = |cycle: &LineCycle| {
                    // One without a time began at the end of the one before, or is of what is not recorded.
                    let began = cycle.took.map_or(last_end, |took| cycle.ended - took);
                    last_end = cycle.ended;
                    rest.take(&Spans::of([(began, cycle.ended)]))
                };
                let ran: Duration = cycles.iter().map(ran).map(|ran: Duration| ran.min(planned)).sum();
                share(ran, production, never)
            }
        };
        let availability = match asked.planned_busy {
            None => Err("planned busy time (PBT) is not recorded; give --planned-busy".to_owned()),
            Some(planned) if planned < production => {
                Err("the planned busy time is less than the time of production (APT)".to_owned())
            }
            Some(planned) => share(production, planned, "the planned busy time is 0"),
        };
        let quality_ratio = match asked.rejected {
            None => Err("good quantity (GQ) is not recorded; give --rejected".to_owned()),
            Some(_) if produced == 0 => Err("no cycle has ended (PQ is 0)".to_owned()),
            Some(rejected) if rejected > produced => Err("more were rejected than cycles have ended (PQ)".to_owned()),
            Some(rejected) => Ok((produced - rejected) as f64 / produced as f64),
        };
        let oee = match (&availability, &effectiveness, &quality_ratio) {
            (Ok(availability), Ok(effectiveness), Ok(quality)) => Ok(availability * effectiveness * quality),
            _ => Err("one of its factors is left out".to_owned()),
        };
        LineFigures {
            planned_run_time: planned,
            produced,
            production,
            delay,
            utilization_efficiency: share(production, production + delay, "the line was not busy (AUBT is 0)"),
            availability,
            effectiveness,
            quality_ratio,
            oee,
        }
    }

    /// A cycle, planned and measured: the one of this number, or the newest in which every operation was done; none if there
    /// is none.
    pub fn chart(&self, number: Option<i32>, span: Stretch) -> Option<CycleChart> {
        let is_shown = |end: MotionOutcome| matches!(end, MotionOutcome::Done | MotionOutcome::Stopped);
        let cycle = number.or_else(|| self.newest_whole(span))?;
        let of = |track: &StationTrack| -> Vec<_> {
            track.motions.iter().filter(|of| of.cycle == cycle && is_shown(of.end)).copied().collect()
        };
        let measured: Vec<Vec<_>> = self.stations.iter().map(of).collect();
        let began = measured.iter().flatten().map(|of| of.from).min()?;
        let seconds = |tick: Tick| tick.since(began).as_secs_f64();
        let mut rows = Vec::new();
        for (station, (of, motions)) in self.about.stations.iter().zip(&measured).enumerate() {
            for (operation, planned) in of.operations.iter().enumerate() {
                let own = motions.iter().filter(|of| of.operation == operation);
                rows.push(PlannedRow {
                    station,
                    operation,
                    planned: planned.planned_us.map(|(from, to)| (from as f64 / 1e6, to as f64 / 1e6)),
                    measured: own
                        .map(|of| (seconds(of.from), seconds(of.to), of.end == MotionOutcome::Stopped))
                        .collect(),
                });
            }
        }
        Some(CycleChart { cycle, began, rows })
    }

    /// The newest cycle in which all operations were done, or of which anything is known.
    fn newest_whole(&self, span: Stretch) -> Option<i32> {
        let mut done: BTreeMap<i32, usize> = BTreeMap::new();
        for of in self.stations.iter().flat_map(|track| &track.motions) {
            if of.end == MotionOutcome::Done && of.from >= span.0 && of.to <= span.1 {
                *done.entry(of.cycle).or_default() += 1;
            }
        }
        let all: usize = self.about.stations.iter().map(|of| of.operations.len()).sum();
        done.iter().rev().find(|(_, count)| **count >= all).or(done.last_key_value()).map(|(cycle, _)| *cycle)
    }
}

fn stops<'s>(states: impl Iterator<Item = (Stretch, &'s LineState)>) -> Vec<StopTotal> {
    let mut by_cause: BTreeMap<&LineStopCause, (u64, Duration, Duration)> = BTreeMap::new();
    for ((from, to), state) in states {
        if let LineState::Stopped(cause) = state {
            let (took, entry) = (to.since(from), by_cause.entry(cause).or_default());
            *entry = (entry.0 + 1, entry.1 + took, entry.2.max(took));
        }
    }
    let total = |(cause, (times, total, longest)): (&LineStopCause, (u64, Duration, Duration))| StopTotal {
        cause: cause.clone(),
        times,
        total,
        longest,
    };
    let mut stops: Vec<StopTotal> = by_cause.into_iter().map(total).collect();
    stops.sort_by_key(|stop| Reverse(stop.total));
    stops
}

fn station(name: &str, track: &StationTrack, producing: &Spans, span: Stretch) -> LineStationReport {
    let mut rest = producing.clone();
    let is_in_span = |at: Tick| at > span.0 && at <= span.1;
    let timed = track.motions.iter().filter(|of| of.end != MotionOutcome::Unseen);
    let busy = rest.take(&Spans::of(timed.map(|of| (of.from, of.to))));
    let mut by_cause: BTreeMap<&str, Vec<Stretch>> = BTreeMap::new();
    for (of, why) in track.waits_by_last() {
        if let Some(stretch) = clipped(of, span) {
            by_cause.entry(why).or_default().push(stretch);
        }
    }
    let wait = |(why, stretches): (&str, Vec<Stretch>)| {
        let spans = Spans::of(stretches);
        WaitTotal { why: why.to_owned(), times: spans.iter().len(), total: rest.take(&spans) }
    };
    let mut waits: Vec<WaitTotal> = by_cause.into_iter().map(wait).filter(|wait| !wait.total.is_zero()).collect();
    waits.sort_by_key(|wait| Reverse(wait.total));
    let count = |end: &[MotionOutcome]| {
        track.motions.iter().filter(|of| end.contains(&of.end) && is_in_span(of.to)).count() as u64
    };
    LineStationReport {
        name: name.to_owned(),
        busy,
        waits,
        other: rest.total(),
        motions: count(&[MotionOutcome::Done, MotionOutcome::Undone]),
        stopped: count(&[MotionOutcome::Stopped]),
        unseen: count(&[MotionOutcome::Unseen]),
        faults: track.faults.iter().filter(|at| is_in_span(**at)).count() as u64,
    }
}

fn trend(span: Stretch, cycles: &[LineCycle]) -> Vec<TrendPart> {
    let timed = || cycles.iter().filter_map(|cycle| Some((cycle.ended, cycle.took?)));
    let parts = timed().count().min(TREND_PARTS_MAX) as u64;
    let micros = span.1.since(span.0).as_micros() as u64;
    if parts < 2 || micros < parts {
        return Vec::new();
    }
    let at = |part: u64| span.0 + Duration::from_micros(micros / parts * part);
    let part = |number: u64| {
        let span = (at(number), if number + 1 == parts { span.1 } else { at(number + 1) });
        let own = timed().filter(|(ended, _)| *ended > span.0 && *ended <= span.1);
        TrendPart { span, times: Spread::of(own.map(|(_, took)| took).collect()) }
    };
    (0..parts).map(part).collect()
}
