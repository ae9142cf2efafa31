//! The report of a line: cycle times, stops and waits by cause, key figures of ISO 22400-2, and a cycle as a bar chart.

mod chart;
mod legend;
mod mcap;
mod tables;

use std::fmt::Write as _;
use std::process::ExitCode;
use std::time::Duration;

use linewright_coordinator_cell::tracking::Spread;
use linewright_history::line::{
    CycleChart, Figure, LineReport, LineState, LineStationReport, LineStopCause, LineTracking, ReportParameters,
    Stretch,
};
use linewright_history::{HistoryReader, LineAbout};
use linewright_line::Tick;
use miette::{IntoDiagnostic, WrapErr, miette};

use super::Args;
use super::story::{failed, removed_text};
use super::when::{self, Zone};
use crate::out::{self, say};

/// So many causes of waits are listed for a station; JSON and CSV have all.
const WAITS_MAX: usize = 5;
/// So many times without a record are listed; JSON has all.
const SILENT_MAX: usize = 5;

/// Data of a line's database for a span.
pub struct LineSource {
    pub reader: HistoryReader,
    pub about: LineAbout,
    pub zone: Zone,
    pub tracking: LineTracking,
    pub report: LineReport,
    /// The cycle that is drawn; none if no operation has been done.
    pub chart: Option<CycleChart>,
}

impl LineSource {
    /// Reads the database.
    ///
    /// # Errors
    /// A fault of the database, or of the arguments.
    pub fn read(
        reader: HistoryReader,
        about: LineAbout,
        span: (Tick, Tick),
        zone: Zone,
        args: &Args,
    ) -> miette::Result<Self> {
        let mut tracking = LineTracking::new(about.clone());
        reader.each(span.1, |event| tracking.take(&event)).map_err(failed)?;
        let report =
            tracking.report(span, &ReportParameters { planned_busy: planned_busy(args)?, rejected: args.rejected });
        let chart = tracking.chart(args.cycle, span);
        if let Some(number) = args.cycle.filter(|_| chart.is_none()) {
            let known = tracking.stations().iter().flat_map(|of| &of.motions).map(|of| of.cycle);
            let known = known.clone().min().zip(known.max());
            let has = known.map_or_else(|| "none".to_owned(), |(least, most)| format!("{least} to {most}"));
            return Err(miette!("no motion of cycle {number} until {}; cycles: {has}", show(&about, zone, span.1)));
        }
        Ok(LineSource { reader, about, zone, tracking, report, chart })
    }

    /// A time, as people read it.
    pub fn show(&self, tick: Tick) -> String {
        show(&self.about, self.zone, tick)
    }

    fn text(&self) -> String {
        let (report, mut text) = (&self.report, String::new());
        let (from, to) = report.span;
        let stopped: Duration = report.stops.iter().map(|stop| stop.total).sum();
        // Writing to a string does not fail.
        let _ = writeln!(text, "{}, {} to {}", self.about.title, self.show(from), self.show(to));
        text.push_str(&removed_text(&self.reader, |at| self.show(at)));
        let _ = write!(text, "{} s observed: produced {} s", seconds(report.observed()), seconds(report.producing));
        let (start_up, unrecorded) = (seconds(report.start_up), seconds(report.unrecorded));
        let _ = writeln!(text, ", stopped {} s, start-up {start_up} s, not recorded {unrecorded} s", seconds(stopped));
        for gap in &report.gaps {
            let (from, to) = (self.show(gap.span.0), self.show(gap.span.1));
            let _ = writeln!(text, "not recorded: {} notes from {from} to {to} could not be written", gap.lost);
        }
        let silent = self.unrecorded();
        for &(from, to) in silent.iter().take(SILENT_MAX) {
            let took = seconds(to.since(from));
            let _ = writeln!(
                text,
                "not recorded: {took} s from {} to {}: no coordinator ran",
                self.show(from),
                self.show(to)
            );
        }
        if silent.len() > SILENT_MAX {
            let _ =
                writeln!(text, "not recorded: and {} other times; --json has all of them", silent.len() - SILENT_MAX);
        }
        self.cycles(&mut text);
        self.figures(&mut text);
        if !report.stops.is_empty() {
            let _ = writeln!(text, "\n{:>5} {:>9} {:>9}  stops, in s", "times", "total", "longest");
            for stop in &report.stops {
                let (total, longest) = (seconds(stop.total), seconds(stop.longest));
                let _ = writeln!(text, "{:>5} {total:>9} {longest:>9}  {}", stop.times, cause(&stop.cause));
            }
        }
        self.stations(&mut text);
        text + &legend::text()
    }

    /// Times without a record in the span, but for those of notes that could not be written.
    pub fn unrecorded(&self) -> Vec<Stretch> {
        let (begin, end) = self.report.span;
        let silent = self.tracking.states(end).filter(|(_, state)| **state == LineState::Unrecorded);
        let within = silent.map(|((from, to), _)| (from.max(begin), to.min(end))).filter(|(from, to)| from < to);
        let is_gap = |&(from, to): &Stretch| self.report.gaps.iter().any(|gap| gap.span.0 < to && from < gap.span.1);
        within.filter(|stretch| !is_gap(stretch)).collect()
    }

    fn cycles(&self, text: &mut String) {
        let (report, planned) = (&self.report, self.report.figures.planned_run_time);
        let planned =
            planned.map_or_else(String::new, |planned| format!("; planned: {:.3} s each", planned.as_secs_f64()));
        let without = match report.without_time() {
            0 => String::new(),
            count => format!(", {count} of them without a time"),
        };
        let _ = writeln!(text, "{} cycles have ended{without}{planned}", report.cycles.len());
        if report.cycle_time.count == 0 {
            return;
        }
        let _ = writeln!(
            text,
            "\n{:<34} {:>6} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}",
            "a cycle, in s", "count", "least", "mean", "median", "90 %", "99 %", "most"
        );
        let mut row = |name: &str, of: &Spread| {
            let times = [of.least, mean(of).unwrap_or_default(), of.median, of.p90, of.p99, of.most];
            // Of no cycle there is no time.
            let times = times.iter().map(|time| match of.count {
                0 => format!("{:>9}", "-"),
                _ => format!("{:>9.3}", time.as_secs_f64()),
            });
            let _ = writeln!(text, "{name:<34} {:>6} {}", of.count, times.collect::<Vec<_>>().join(" "));
        };
        row("all", &report.cycle_time);
        for part in &report.trend {
            row(&format!("from {}", self.show(part.span.0)), &part.times);
        }
    }

    fn figures(&self, text: &mut String) {
        let of = &self.report.figures;
        let _ = writeln!(
            text,
            "\nISO 22400-2: production time APT {} s, delays ADET {} s, busy time AUBT {} s, produced PQ {} cycles",
            seconds(of.production),
            seconds(of.delay),
            seconds(of.busy()),
            of.produced
        );
        for (name, formula, figure) in figures(of) {
            let figure = match figure {
                Ok(share) => format!("{:.1} %", share * 100.0),
                Err(why) => format!("left out: {why}"),
            };
            let _ = writeln!(text, "{name:<22} {formula:<14} {figure}");
        }
    }

    fn stations(&self, text: &mut String) {
        let _ = writeln!(
            text,
            "\n{:<16} {:>8} {:>8} {:>8} {:>8} {:>8} {:>7}",
            "while producing", "busy", "waited", "other", "motions", "stopped", "faults"
        );
        let whole = self.report.producing;
        let percent = |part: Duration| match whole.is_zero() {
            true => "-".to_owned(),
            false => format!("{:.1} %", part.as_secs_f64() / whole.as_secs_f64() * 100.0),
        };
        for of in &self.report.stations {
            let LineStationReport { name, busy, waits, other, motions, stopped, unseen, faults } = of;
            let waited = waits.iter().map(|wait| wait.total).sum();
            let [busy, waited, other] = [*busy, waited, *other].map(percent);
            let _ = writeln!(text, "{name:<16} {busy:>8} {waited:>8} {other:>8} {motions:>8} {stopped:>8} {faults:>7}");
            for wait in waits.iter().take(WAITS_MAX) {
                let _ = writeln!(text, "  {:>9} s, {}, for {}", seconds(wait.total), often(wait.times), wait.why);
            }
            if waits.len() > WAITS_MAX {
                let _ = writeln!(text, "  and {} other causes; --json has all of them", waits.len() - WAITS_MAX);
            }
            if *unseen > 0 {
                let _ = writeln!(text, "  {unseen} motions passed between two states, and have no times");
            }
        }
    }
}

/// Prints and writes the output requested.
pub fn run(args: &Args, source: LineSource) -> miette::Result<ExitCode> {
    if let Some(dir) = &args.csv {
        tables::csv(&source, dir)?;
    }
    if let Some(path) = &args.mcap {
        mcap::write(&source, path)?;
    }
    if let Some(path) = &args.gantt {
        let chart = source.chart.as_ref().ok_or_else(|| miette!("no operation has been done: there is no cycle"))?;
        let written = std::fs::write(path, chart::svg(&source, chart));
        written.into_diagnostic().wrap_err_with(|| format!("cannot write {}", path.display()))?;
    }
    if args.json {
        out::json(&tables::LineReportJson::new(&source))?;
        return Ok(ExitCode::SUCCESS);
    }
    if args.wants_text() {
        say!("{}", source.text().trim_end());
    }
    if args.chart {
        match &source.chart {
            Some(chart) => say!("\n{}", chart::text(&source, chart).trim_end()),
            None => say!("\nno operation has been done"),
        }
    }
    args.say_written();
    Ok(ExitCode::SUCCESS)
}

fn show(about: &LineAbout, zone: Zone, tick: Tick) -> String {
    when::show(tick, about.clock, zone)
}

fn planned_busy(args: &Args) -> miette::Result<Option<Duration>> {
    let Some(hours) = args.planned_busy else { return Ok(None) };
    let span = Duration::try_from_secs_f64(hours * 3600.0).ok().filter(|span| span.as_secs() < 1_000_000_000);
    span.map(Some).ok_or_else(|| miette!("--planned-busy {hours}: expected hours, from 0 on"))
}

fn seconds(time: Duration) -> String {
    format!("{:.1}", time.as_secs_f64())
}

fn often(times: usize) -> String {
    if times == 1 { "once".to_owned() } else { format!("{times} times") }
}

fn mean(of: &Spread) -> Option<Duration> {
    u32::try_from(of.count).ok().filter(|count| *count > 0).map(|count| of.total / count)
}

/// A cause of stops as text: its kind, and the recorded text if there is one.
fn cause(of: &LineStopCause) -> String {
    if of.text.is_empty() { of.kind.name().to_owned() } else { format!("{}: {}", of.kind.name(), of.text) }
}

/// The figures with their formulas.
fn figures(of: &linewright_history::line::LineFigures) -> [(&'static str, &'static str, &Figure); 5] {
    [
        ("utilization efficiency", "APT / AUBT", &of.utilization_efficiency),
        ("availability", "APT / PBT", &of.availability),
        ("effectiveness", "PRI * PQ / APT", &of.effectiveness),
        ("quality ratio", "GQ / PQ", &of.quality_ratio),
        ("OEE index", "A * E * QR", &of.oee),
    ]
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use linewright_history::{History, HistoryFeed, LineOperation, LineStation, Note, TimeBase};

    use super::*;

    #[derive(Parser)]
    struct Command {
        #[command(flatten)]
        args: Args,
    }

    /// A run, a night without a coordinator, and a run that is stopped.
    fn source(dir: &std::path::Path) -> LineSource {
        let operation = LineOperation { name: "close".to_owned(), planned_us: None };
        let about = LineAbout {
            line: "line".to_owned(),
            title: "Line".to_owned(),
            clock: TimeBase::Unix,
            stations: vec![LineStation { name: "clamp".to_owned(), operations: vec![operation] }],
            cycle_us: 2_000_000,
        };
        let mode = |name: &str, starts| Note::Mode { name: name.to_owned(), starts };
        let path = dir.join("line.db");
        let (opened, of) = (path.clone(), about.clone());
        let mut feed = HistoryFeed::of_notes(move || History::open(&opened, &of));
        for (second, note) in [
            (100, Note::Began {}),
            (100, mode("home", false)),
            (100, Note::Station { station: 0, lost: true }),
            (103, Note::Station { station: 0, lost: false }),
            (104, mode("auto", true)),
            (106, Note::Cycle { number: 1, took_us: Some(1_000_000) }),
            (110, Note::Observed {}),
            (210, Note::Began {}),
            (210, mode("auto", true)),
            (215, Note::Cycle { number: 2, took_us: None }),
            (220, mode("stand-by", false)),
            (225, Note::Observed {}),
        ] {
            assert!(feed.offer_note(Tick::from_millis(second * 1000), note));
        }
        feed.end_within(Duration::from_secs(20));
        let reader = HistoryReader::open(&path).expect("it was written");
        let span = reader.span().expect("it can be read").expect("something has happened");
        let args = Command::parse_from(["report", "line.db"]).args;
        LineSource::read(reader, about, span, Zone::Utc, &args).expect("a line's")
    }

    /// A cycle without a time is counted, and is none of the times.
    #[test]
    fn a_cycle_without_a_time_is_one_of_the_cycles_and_none_of_their_times() {
        let dir = tempfile::tempdir().expect("a directory");
        let source = source(dir.path());
        let text = source.text();
        assert!(text.contains("2 cycles have ended, 1 of them without a time; planned: 2.000 s each\n"), "{text}");
        assert!(text.contains("produced PQ 2 cycles\n"), "{text}");
        let json = serde_json::to_value(tables::LineReportJson::new(&source)).expect("an object");
        assert_eq!((&json["cycles"]["without_time"], &json["cycles"]["time_s"]["count"]), (&1.into(), &1.into()));
        tables::csv(&source, dir.path()).expect("tables are written");
        let cycles = std::fs::read_to_string(dir.path().join("cycle.csv")).expect("a table");
        assert_eq!(cycles.lines().nth(2), Some("2,1970-01-01T00:03:35.000Z,215000000,,2.0"), "{cycles}");
    }

    /// Start-up and times without a record are listed apart from stops, and each figure has a line of the legend.
    #[test]
    fn a_start_up_and_what_is_not_recorded_are_no_stops_and_each_figure_has_its_line() {
        let dir = tempfile::tempdir().expect("a directory");
        let source = source(dir.path());
        let text = source.text();
        let sums = "125.0 s observed: produced 16.0 s, stopped 5.0 s, start-up 4.0 s, not recorded 100.0 s";
        assert!(text.contains(sums), "{text}");
        let silent =
            "not recorded: 100.0 s from 1970-01-01T00:01:50.000Z to 1970-01-01T00:03:30.000Z: no coordinator ran";
        assert!(text.contains(silent), "{text}");
        assert!(text.contains("\n    1       5.0       5.0  operator\n\n"), "the only stop: {text}");
        assert!(
            text.lines().any(|line| line.starts_with("  effectiveness ") && line.ends_with("100 % at most")),
            "{text}"
        );
        tables::csv(&source, dir.path()).expect("tables are written");
        let stops = std::fs::read_to_string(dir.path().join("stop.csv")).expect("a table");
        assert_eq!(stops.lines().count(), 2, "{stops}");
        let json = serde_json::to_value(tables::LineReportJson::new(&source)).expect("an object");
        assert_eq!((&json["start_up_s"], &json["unrecorded"][0]["duration_s"]), (&4.0.into(), &100.0.into()));
    }
}
