//! `linewright report`: report on a flexible cell or a line, from the database that its coordinator writes while it
//! runs, or that `simulate --record` has written.
//!
//! The database is read as it is at one moment; its writer is not held up. The report consists of the folds of
//! [`linewright_coordinator_cell::tracking`] and [`linewright_history::line`] over the events, within a span of time.
//! This module reads and picks the exit code; each form of output is a module, those of lines in [`mod@line`].

mod csv;
mod gantt;
mod json;
mod line;
mod mcap;
mod rows;
mod story;
mod when;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use linewright_history::{About, HistoryReader};
use miette::{IntoDiagnostic, WrapErr, miette};

use crate::out::{self, say};
use story::ReportSource;
use when::Zone;

/// Options of `report`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Database, or directory with a `cell.db` or `line.db`.
    db: PathBuf,
    /// Beginning of the span: a time as RFC 3339 (2026-11-22T06:00:00+01:00), without an offset in local time, with or
    /// without the time of day; of a simulation in seconds [default: the first event].
    #[arg(long, value_name = "TIME")]
    from: Option<String>,
    /// End of the span [default: the last event].
    #[arg(long, value_name = "TIME")]
    to: Option<String>,
    /// Times in UTC instead of local time.
    #[arg(long)]
    utc: bool,
    /// Print one JSON object instead of text.
    #[arg(long)]
    json: bool,
    /// Write events, activities, parts and orders (of a line motions, waits, stops and cycles) as CSV files into a directory.
    #[arg(long, value_name = "DIR")]
    csv: Option<PathBuf>,
    /// Write an MCAP file, for Foxglove Studio and others.
    #[arg(long, value_name = "FILE")]
    mcap: Option<PathBuf>,
    /// Write the Gantt chart, plan above actual, as SVG; of a line the bar chart of one cycle.
    #[arg(long, value_name = "FILE")]
    gantt: Option<PathBuf>,
    /// Print the Gantt chart as text as well; of a line the bar chart of one cycle.
    #[arg(long, conflicts_with = "json")]
    chart: bool,
    /// Of a line: draw this cycle [default: the newest in which every operation was done].
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    cycle: Option<i32>,
    /// Of a line: planned busy time (ISO 22400-2 PBT) in the span, in hours; for the availability.
    #[arg(long, value_name = "HOURS")]
    planned_busy: Option<f64>,
    /// Of a line: number of the span's cycles with a rejected part; for the quality ratio.
    #[arg(long, value_name = "NUMBER")]
    rejected: Option<u64>,
}

impl Args {
    /// What is written to.
    fn written(&self) -> impl Iterator<Item = &Path> {
        [&self.csv, &self.mcap, &self.gantt].into_iter().flatten().map(PathBuf::as_path)
    }

    /// Whether the report is printed as text: not where files were asked for, and nothing else.
    fn wants_text(&self) -> bool {
        self.chart || self.written().next().is_none()
    }

    fn say_written(&self) {
        self.written().for_each(|path| say!("written: {}", path.display()));
    }
}

/// The database that a path means.
fn database(path: &Path) -> miette::Result<PathBuf> {
    if !path.exists() {
        return Err(miette!(
            "there is no {}; give the state directory of a run, or its cell.db or line.db",
            path.display()
        ));
    }
    if !path.is_dir() {
        return Ok(path.to_owned());
    }
    let named = ["cell.db", "line.db"].map(|name| path.join(name));
    let found = named.into_iter().find(|file| file.is_file());
    found.ok_or_else(|| {
        miette!(
            "{} has neither cell.db nor line.db; give the state directory of a run (`run --state-dir DIR`)",
            path.display()
        )
    })
}

/// Runs the command.
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let zone = if args.utc { Zone::Utc } else { Zone::Local };
    let reader = HistoryReader::open(&database(&args.db)?).map_err(story::failed)?;
    let asked = (args.from.as_deref(), args.to.as_deref());
    let about = match reader.about().clone() {
        About::Line(about) => {
            let span = story::span(&reader, asked, about.clock, zone)?;
            return line::run(args, line::LineSource::read(reader, about, span, zone, args)?);
        }
        About::Cell(about) => about,
    };
    if args.cycle.is_some() || args.planned_busy.is_some() || args.rejected.is_some() {
        return Err(miette!("--cycle, --planned-busy and --rejected are for lines; this database is about a cell"));
    }
    let span = story::span(&reader, asked, about.clock, zone)?;
    let story = ReportSource::read(reader, about, span, zone)?;
    if let Some(dir) = &args.csv {
        csv::write(&story, dir)?;
    }
    if let Some(path) = &args.mcap {
        mcap::write(&story, path)?;
    }
    if let Some(path) = &args.gantt {
        let written = std::fs::write(path, gantt::svg(&story));
        written.into_diagnostic().wrap_err_with(|| format!("cannot write {}", path.display()))?;
    }
    if args.json {
        out::json(&json::ReportJson::new(&story))?;
        return Ok(ExitCode::SUCCESS);
    }
    if args.wants_text() {
        say!("{}", story.text().trim_end());
    }
    if args.chart {
        say!("\n{}", gantt::text(&story).trim_end());
    }
    args.say_written();
    Ok(ExitCode::SUCCESS)
}
