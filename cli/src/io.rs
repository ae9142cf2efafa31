//! `linewright io`: I/O lists as CSV, written from a description and put into one.
//!
//! The effect of a list on a description is in [`linewright_line::with_io_list`]; this module reads and writes CSV,
//! shows the differences, and writes the description only if nothing is wrong.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Subcommand;
use linewright_line::{IO_COLUMNS, IoListError, IoRow, RowProblem, io_list, suggestion, with_io_list};
use miette::{IntoDiagnostic, WrapErr, miette};

use crate::files::{description, text};
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
    /// Put a list into the description: where each signal is, and comments. Shows what is different.
    Import {
        /// The directory of a line, or its description file.
        line: PathBuf,
        /// The list: CSV with columns name, address and device; station and comment may be there.
        list: PathBuf,
        /// Only show what would be different.
        #[arg(long)]
        dry_run: bool,
    },
}

/// `linewright io`
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    match &args.command {
        IoCommand::Export { line } => export(&load::file_of(line)),
        IoCommand::Import { line, list, dry_run } => import(&load::file_of(line), list, *dry_run),
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

fn import(file: &Path, list: &Path, dry_run: bool) -> miette::Result<ExitCode> {
    let before = description(file)?;
    let rows = rows(&text(list, LIST_BYTES_MAX, "an I/O list")?).map_err(|problems| wrong(&problems, list))?;
    let change = with_io_list(&file.display().to_string(), &before, &rows).map_err(|error| refused(&error, list))?;
    let name = file.display();
    load::warn(file, &change.warnings);
    if change.changes.is_empty() {
        crate::out::say!("{name}: nothing is different");
        return Ok(ExitCode::SUCCESS);
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

/// The rows of a list. Commas, semicolons and tabs separate, whichever the first line has most of.
fn rows(text: &str) -> Result<Vec<IoRow>, Vec<RowProblem>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let first = text.lines().next().unwrap_or("");
    let count = |sign: u8| first.bytes().filter(|byte| *byte == sign).count();
    let separator = [b',', b';', b'\t'].into_iter().rev().max_by_key(|sign| count(*sign)).unwrap_or(b',');
    let mut reader =
        csv::ReaderBuilder::new().delimiter(separator).flexible(true).trim(csv::Trim::All).from_reader(text.as_bytes());
    let unreadable = |error: csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        vec![RowProblem { line, column: "", message: format!("cannot be read: {error}") }]
    };
    let headers = reader.headers().map_err(unreadable)?.clone();
    let column = |name: &str| headers.iter().position(|header| header.eq_ignore_ascii_case(name));
    let missing = ["name", "address", "device"].into_iter().filter(|name| column(name).is_none());
    let missing: Vec<RowProblem> = missing
        .map(|name| {
            let near = suggestion(name, headers.iter()).filter(|_| headers.len() > 1);
            let near = near.map(|near| format!(" ({near})")).unwrap_or_default();
            RowProblem { line: 1, column: "", message: format!("the first line has no column `{name}`{near}") }
        })
        .collect();
    if !missing.is_empty() {
        return Err(missing);
    }
    let at = IO_COLUMNS.map(column);
    let mut rows = Vec::new();
    let (mut counted, mut line) = (0, 1);
    let mut problems = Vec::new();
    for record in reader.records() {
        let record = record.map_err(unreadable)?;
        let field = |column: usize| at[column].map(|at| record.get(at).unwrap_or("").to_owned());
        if record.iter().all(str::is_empty) {
            continue;
        }
        let [name, address, device] = [0, 1, 2].map(|column| field(column).unwrap_or_default());
        // The reader's own count of lines is behind where lines end with CR LF.
        let from = record.position().and_then(|at| usize::try_from(at.byte()).ok()).unwrap_or(counted);
        let begin = text.len() - text[from..].trim_start_matches(['\r', '\n']).len();
        line += text.as_bytes()[counted..begin].iter().filter(|&&byte| byte == b'\n').count() as u64;
        counted = begin;
        let mut wrong = |message: &str| problems.push(RowProblem { line, column: "", message: message.to_owned() });
        if record.iter().any(|field| field.contains('\n')) {
            wrong("a field goes on in the next line: a quote is not closed");
        }
        if record.iter().skip(headers.len()).any(|field| !field.is_empty()) {
            wrong("more fields than the first line has columns: a text with the separator in it stands in quotes");
        }
        rows.push(IoRow { line, name, address, device, station: field(3), comment: field(4) });
    }
    if problems.is_empty() { Ok(rows) } else { Err(problems) }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_as_spreadsheets_write_them() {
        let row = |line, name: &str| IoRow {
            line,
            name: name.to_owned(),
            address: "%IX0.0".to_owned(),
            device: "clamp, io".to_owned(),
            station: None,
            comment: Some("says \"no\"".to_owned()),
        };
        for (separator, device) in [(',', "\"clamp, io\""), (';', "clamp, io"), ('\t', "clamp, io")] {
            let header = ["Address", "type", "DEVICE", "comment", "name"].join(&separator.to_string());
            let line =
                |name: &str| ["%IX0.0", "BOOL", device, "\"says \"\"no\"\"\"", name].join(&separator.to_string());
            let text = format!("\u{feff}{header}\r\n{}\r\n\r\n{}\r\n", line(" a "), line("b"));
            assert_eq!(rows(&text).expect("read"), [row(2, "a"), row(4, "b")], "{separator:?}");
        }
        let unclosed = rows("name,address,device\na,%IX0.0,\"far side\nb,%IX0.1,clamp\n").expect_err("not closed");
        assert_eq!((unclosed[0].line, unclosed.len()), (2, 1), "{unclosed:?}");
        let longer = rows("name;address;device;comment\na;%IX0.0;clamp;near; above\n").expect_err("five fields");
        assert!(longer[0].message.starts_with("more fields"), "{longer:?}");
        let short = rows("name,address,device\nx\n").expect("read");
        assert_eq!((short[0].device.as_str(), &short[0].comment, &short[0].station), ("", &None, &None));
    }

    #[test]
    fn a_list_without_its_columns_is_refused() {
        let problems = rows("name;adress;device\n").expect_err("no address");
        assert_eq!(problems[0].message, "the first line has no column `address` (did you mean `adress`?)");
        assert_eq!(rows("").expect_err("nothing").len(), 3);
    }
}
