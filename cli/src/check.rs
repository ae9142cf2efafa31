//! `linewright check`: whether a line is right, before anything moves.
//!
//! The text is checked by the parser, with every problem at once; the nets and arrows that follow from it by their
//! structure; and the composed line by exploring what its controllers can do together. The decisions are in
//! `linewright-proof`; this file reads, prints and picks the exit code.

mod explored;
mod report;
mod show;

use std::path::PathBuf;
use std::process::ExitCode;

use linewright_line::Problems;
use miette::IntoDiagnostic;

use crate::load;
use report::Report;

/// Check a description: text, structure, and everything its controllers can do together.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// Print one JSON object instead of tables, problems of the text included.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: explored::Options,
}

/// `linewright check`
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let read = load::parsed(&args.line).and_then(|mut parsed| {
        // Devices' own files say nothing about the controllers, but a line with a wrong one is not right.
        load::with_device_files(&mut parsed.line, &args.line, args.json)?;
        Ok(parsed)
    });
    let report = match read {
        Ok(parsed) => {
            let report = report::judge(&parsed, &args.options).into_diagnostic()?;
            if !args.json {
                draw_warnings(args, parsed.warnings)?;
            }
            report
        }
        Err(error) if args.json => match error.downcast_ref::<Problems>() {
            Some(problems) => Report::of_problems(problems),
            None => Report::unreadable(format!("{error:#}")),
        },
        Err(error) => return Err(error),
    };
    if args.json {
        crate::out::say!("{}", serde_json::to_string_pretty(&report).into_diagnostic()?);
    } else {
        crate::out::say!("{}", show::text(&report).trim_end());
    }
    Ok(if report.ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn draw_warnings(args: &Args, warnings: Vec<linewright_line::Problem>) -> miette::Result<()> {
    if warnings.is_empty() {
        return Ok(());
    }
    let file = load::file_of(&args.line);
    let text = std::fs::read_to_string(&file).into_diagnostic()?;
    eprintln!("{:?}", miette::Report::new(Problems::new(&file.display().to_string(), &text, warnings)));
    Ok(())
}
