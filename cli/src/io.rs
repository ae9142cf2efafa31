//! `linewright io`: I/O lists as CSV, written from a description and put into one.
//!
//! The effect of a list on a description is in [`linewright_line::with_io_list`]; this module reads and writes CSV,
//! shows the differences, and writes the description only if the list has no errors.

mod list;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Subcommand;
use linewright_line::{
    DeviceBegin, IO_COLUMNS, IoListError, RowProblem, io_list, unknown_devices, with_io_list, within_devices,
};
use miette::{IntoDiagnostic, WrapErr, miette};

use crate::files::{bytes, description};
use crate::load;

/// A list may be this large: far more than the bits of a line.
const LIST_BYTES_MAX: usize = 16 << 20;
/// So many problems of a list are shown.
const SHOWN_MAX: usize = 50;

/// Write the I/O list of a line as CSV, or put one into its description.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: IoCommand,
}

#[derive(Debug, Subcommand)]
enum IoCommand {
    /// Print the I/O list: a row for each digital bit of its devices.
    Export {
        /// The directory of a line, or its description file.
        line: PathBuf,
    },
    /// Put the addresses and comments of a list into the description, and show the differences.
    Import {
        /// The directory of a line, or its description file.
        line: PathBuf,
        /// CSV file with columns name, address and device, optionally station and comment.
        list: PathBuf,
        /// First address of a device in a list with the addresses of a whole controller, as `drill io=%I4,%Q2`, or
        /// `drill io=4` for both; repeat it for each device.
        #[arg(long, value_name = "DEVICE=ADDRESS", value_parser = DeviceBegin::read)]
        begin: Vec<DeviceBegin>,
        /// Show the differences without writing.
        #[arg(long)]
        dry_run: bool,
    },
}

/// `linewright io`
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    match &args.command {
        IoCommand::Export { line } => export(&load::file_of(line)),
        IoCommand::Import { line, list, begin, dry_run } => import(&load::file_of(line), list, begin, *dry_run),
    }
}

fn export(file: &Path) -> miette::Result<ExitCode> {
    let text = description(file)?;
    let rows = io_list(&file.display().to_string(), &text).map_err(|error| refused(&error, file))?;
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(IO_COLUMNS).into_diagnostic()?;
    for row in &rows {
        let (station, comment) = (row.station.as_deref().unwrap_or(""), row.comment.as_deref().unwrap_or(""));
        writer.write_record([&row.name, &row.address, &row.device, station, comment]).into_diagnostic()?;
    }
    crate::out::bytes(&writer.into_inner().map_err(|error| miette!("{error}"))?);
    Ok(ExitCode::SUCCESS)
}

fn import(file: &Path, list: &Path, begin: &[DeviceBegin], dry_run: bool) -> miette::Result<ExitCode> {
    let before = description(file)?;
    let text = list::text(bytes(list, LIST_BYTES_MAX, "an I/O list")?)
        .map_err(|why| miette!(help = "nothing was written", "{}: {why}", list.display()))?;
    let unknown =
        unknown_devices(&file.display().to_string(), &before, begin).map_err(|error| refused(&error, file))?;
    if !unknown.is_empty() {
        return Err(miette!(help = "nothing was written", "--begin: {}", unknown.join("\n")));
    }
    let mut rows = list::rows(&text.text, !begin.is_empty()).map_err(|problems| wrong(&problems, list))?;
    if !begin.is_empty() {
        let counted = rows.len();
        rows = within_devices(rows, begin).map_err(|problems| wrong(&problems, list))?;
        match counted - rows.len() {
            0 => {}
            1 => crate::out::say!("1 row is left out: it is of no digital input or output"),
            left => crate::out::say!("{left} rows are left out: they are of no digital input or output"),
        }
    }
    let change = with_io_list(&file.display().to_string(), &before, &rows).map_err(|error| refused(&error, list))?;
    let name = file.display();
    load::warn(file, &change.warnings);
    if change.changes.is_empty() {
        crate::out::say!("{name}: nothing is different");
        return Ok(ExitCode::SUCCESS);
    }
    if text.is_guessed {
        let name = list.display();
        crate::out::complain!("{name} is not UTF-8 and was read as Windows-1252: look at its special characters below");
    }
    for line in &change.changes {
        crate::out::say!("{line}");
    }
    let count = change.changes.len();
    if dry_run {
        crate::out::say!("{name}: {count} would be different; nothing was written");
    } else {
        replace(file, &change.text)?;
        crate::out::say!("{name}: {count} different, written");
    }
    Ok(ExitCode::SUCCESS)
}

/// Writes the whole file or leaves it as it is, whenever this process ends.
fn replace(file: &Path, text: &str) -> miette::Result<()> {
    let cannot = || format!("cannot write {}", file.display());
    // A link stays a link.
    let file = file.canonicalize().into_diagnostic().wrap_err_with(cannot)?;
    let mut new = file.clone().into_os_string();
    new.push(".new");
    std::fs::write(&new, text).into_diagnostic().wrap_err_with(cannot)?;
    let permissions = std::fs::metadata(&file).into_diagnostic().wrap_err_with(cannot)?.permissions();
    std::fs::set_permissions(&new, permissions).into_diagnostic().wrap_err_with(cannot)?;
    std::fs::rename(&new, &file).into_diagnostic().wrap_err_with(cannot)
}

fn refused(error: &IoListError, list: &Path) -> miette::Report {
    match error {
        IoListError::Rows(problems) => wrong(problems, list),
        IoListError::Description(problems) => miette::Report::new((**problems).clone()),
        IoListError::Result(problems) => miette::Report::new((**problems).clone())
            .wrap_err("with the list in it the description would be wrong; nothing was written"),
    }
}

fn wrong(problems: &[RowProblem], list: &Path) -> miette::Report {
    let name = list.display();
    let mut lines: Vec<String> = problems
        .iter()
        .take(SHOWN_MAX)
        .map(|RowProblem { line, column, message }| match *column {
            "" => format!("{name}:{line}: {message}"),
            column => format!("{name}:{line}: column {column}: {message}"),
        })
        .collect();
    if problems.len() > SHOWN_MAX {
        lines.push(format!("and {} more", problems.len() - SHOWN_MAX));
    }
    miette!(help = "nothing was written", "{}", lines.join("\n"))
}
