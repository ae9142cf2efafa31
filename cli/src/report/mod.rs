//! `linewright report`: what a flexible cell has done, from the database that its coordinator writes while it runs, or that
//! `simulate --record` has written.
//!
//! The database is read as it is at one moment; whoever writes it is not held up. What is reported are the folds of
//! [`linewright_coordinator_cell::tracking`] over the events, within a span of time. This module reads and picks the
//! exit code; each form of output is a module.

mod csv;
mod gantt;
mod json;
mod mcap;
mod rows;
mod story;
mod when;

use std::path::PathBuf;
use std::process::ExitCode;

use miette::{IntoDiagnostic, WrapErr};

use crate::out::{self, say};
use story::ReportSource;
use when::Zone;

/// Options of `report`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The database, or the directory that has it as `cell.db`.
    db: PathBuf,
    /// From when on: a time as RFC 3339 (2026-11-22T06:00:00+01:00), or without offset in local time, the time of day left
    /// out if it does not matter; of a simulation in seconds.
    #[arg(long, value_name = "TIME")]
    from: Option<String>,
    /// Until when [default: the last event].
    #[arg(long, value_name = "TIME")]
    to: Option<String>,
    /// Times in UTC instead of local time.
    #[arg(long)]
    utc: bool,
    /// Print one JSON object instead of text.
    #[arg(long)]
    json: bool,
    /// Write events, activities, parts and orders as CSV files into a directory.
    #[arg(long, value_name = "DIR")]
    csv: Option<PathBuf>,
    /// Write it as MCAP, for Foxglove Studio and others.
    #[arg(long, value_name = "FILE")]
    mcap: Option<PathBuf>,
    /// Write the Gantt chart, plan above actual, as SVG.
    #[arg(long, value_name = "FILE")]
    gantt: Option<PathBuf>,
    /// Print the Gantt chart as text as well.
    #[arg(long, conflicts_with = "json")]
    chart: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let zone = if args.utc { Zone::Utc } else { Zone::Local };
    let db = if args.db.is_dir() { args.db.join("cell.db") } else { args.db.clone() };
    let story = ReportSource::read(&db, (args.from.as_deref(), args.to.as_deref()), zone)?;
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
    } else {
        say!("{}", story.text().trim_end());
        if args.chart {
            say!("\n{}", gantt::text(&story).trim_end());
        }
    }
    Ok(ExitCode::SUCCESS)
}
