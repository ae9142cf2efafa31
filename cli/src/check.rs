//! `linewright check`: whether a line is right, before anything moves.
//!
//! The text is checked by the parser, with every problem at once; the nets and arrows that follow from it by their
//! structure; and the composed line by exploring what its controllers can do together. A flexible cell is checked by
//! exploring its net, beside the line or without one. The decisions are in `linewright-proof`; this file reads, prints
//! and picks the exit code.

mod barriers;
mod cell;
mod explored;
mod explorer;
mod in_parts;
mod larger;
mod options;
mod progress;
mod report;
mod show;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use linewright_line::{Line, Problems};
use linewright_proof::structure::{StructureReport, judge_line, judge_stations};
use miette::{IntoDiagnostic, miette};

use crate::load;
use explorer::Explorer;
use report::CheckReport;

/// Check a description: text, structure, everything its controllers can do together; and of a cell, whether parts get
/// stuck.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The directory of a line or a cell, or its description file.
    line: PathBuf,
    /// Print one JSON object instead of tables, problems of the text included.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: options::ExploreOptions,
}

/// `linewright check`
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let files = load::files_of(&args.line);
    let nothing_of = |asked: Option<&'static str>, what: &str| {
        asked.map_or(Ok(()), |asked| Err(miette!("`{asked}` needs {what}; {} has none", args.line.display())))
    };
    let slow = progress::SlowCheck::begin();
    let explorer = Explorer { options: &args.options, progress: &slow.progress };
    let (mut report, line, arrow_lines) = match &files.line {
        Some(file) => of_line(args, file, files.cell.as_deref())?,
        None => {
            nothing_of(args.options.of_stations(), "the stations of a line")?;
            (CheckReport::of_no_line(), None, Vec::new())
        }
    };
    let cell = match &files.cell {
        Some(file) => Some(cell::read(file, line.as_ref(), args.json)?),
        None => nothing_of(args.options.of_cells(), "a cell").map(|()| None)?,
    };
    if let (Some(file), None, Some(Err(_)), false) = (&files.line, &line, &cell, args.json) {
        crate::out::complain!(
            "note: times, tasks and stations of the cell follow from {}: mend that first, errors of the cell may end with it",
            load::file_of(file).display()
        );
    }
    // Without the cell beside it the line is not judged; what needs no exploration is shown before that begins.
    let line_judged = files.line.as_ref().zip(line.as_ref()).filter(|_| !matches!(cell, Some(Err(_))));
    if let Some((file, line)) = line_judged {
        report.add_structure(line, &load::file_of(file), &arrow_lines);
        if !args.json {
            crate::out::say!("{}", show::structure(&report).trim_end());
        }
        report.add_explored(line, &explorer).into_diagnostic()?;
    }
    if let Some(cell) = cell {
        report.add(cell.map_or_else(Ok, |parsed| cell::judge(&parsed, line.as_ref(), &explorer))?);
    }
    drop(slow);
    if args.json {
        crate::out::json(&report)?;
    } else {
        let rest = show::explored(&report);
        let rest = if line_judged.is_some() { &rest } else { rest.trim_start_matches('\n') };
        crate::out::say!("{}", rest.trim_end());
    }
    Ok(if report.ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The checks by structure that do not hold, of each station the first; nothing is explored.
pub fn refusals(line: &Line) -> impl Iterator<Item = String> {
    let of_station = |report: StructureReport| {
        let check = report.checks.into_iter().find(|check| !check.ok)?;
        Some(format!("{}: {}: {}", report.name, check.name, check.reason))
    };
    let of_line = std::iter::once_with(|| judge_line(line)).flatten().filter(|check| !check.ok);
    let of_line = of_line.map(|check| format!("{}: {}", check.name, check.reason));
    judge_stations(line).into_iter().filter_map(of_station).chain(of_line)
}

/// Report on the text of the line, and the line itself if there is one, with the lines of its arrows; warnings are drawn. With a cell beside it, the cell is
/// checked even if the line could not be parsed.
fn of_line(args: &Args, file: &Path, cell: Option<&Path>) -> miette::Result<(CheckReport, Option<Line>, Vec<usize>)> {
    let read = load::parsed(file).and_then(|mut parsed| {
        // Devices' own files do not concern the controllers, but a line with a wrong one is not right.
        load::with_device_files(&mut parsed.line, file, args.json)?;
        Ok(parsed)
    });
    match read {
        Ok(parsed) => {
            let report = CheckReport::unjudged(&parsed);
            if !args.json {
                draw_warnings(file, parsed.warnings)?;
            }
            Ok((report, Some(parsed.line), parsed.arrow_lines))
        }
        Err(error) if args.json || cell.is_some() => {
            if !args.json {
                crate::out::complain!("{error:?}");
            }
            let report = match error.downcast_ref::<Problems>() {
                Some(problems) => CheckReport::of_problems(problems),
                None => CheckReport::unreadable(format!("{error:#}")),
            };
            Ok((report, None, Vec::new()))
        }
        Err(error) => Err(error),
    }
}

/// Draws what is suspicious about the description `file`.
fn draw_warnings(file: &Path, warnings: Vec<linewright_line::Problem>) -> miette::Result<()> {
    if warnings.is_empty() {
        return Ok(());
    }
    let text = std::fs::read_to_string(file).into_diagnostic()?;
    crate::out::complain!("{:?}", miette::Report::new(Problems::new(&file.display().to_string(), &text, warnings)));
    Ok(())
}
