//! `linewright new`: writes the description of a new line or cell, to be read and changed by hand.
//!
//! The text of a transfer line comes from [`linewright_line::TransferLine`], others lie beside this file; this module only
//! decides what it is called and where it goes. An existing description is replaced with `--force` alone.

use std::fs::{OpenOptions, create_dir_all};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Subcommand;
use linewright_line::TransferLine;
use linewright_text::{Located, Report, ros_name};
use miette::{IntoDiagnostic, WrapErr, miette};

/// Write the description of a new line or cell.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    kind: NewKind,
}

/// The names of the kinds.
const KINDS: [&str; 5] = ["transfer-line", "rotary-table", "cell", "empty-line", "empty-cell"];

#[derive(Debug, Subcommand)]
enum NewKind {
    /// A line: a transfer bar with a number of clamp-and-mill pairs along it.
    TransferLine(TransferLineArgs),
    /// A line: a rotary indexing table with four stations around it, which are of one station type.
    RotaryTable(NewTarget),
    /// A flexible cell: a rack, a washer, a dryer, and a robot that carries parts between them.
    Cell(NewTarget),
    /// The smallest line: one station with one motion out and back, and where to go on from there.
    EmptyLine(NewTarget),
    /// The smallest flexible cell: one machine to which parts are brought by hand, and where to go on from there.
    EmptyCell(NewTarget),
    /// None of these.
    #[command(external_subcommand)]
    Other(Vec<String>),
}

#[derive(Debug, clap::Args)]
struct TransferLineArgs {
    /// Number of clamp-and-mill pairs, 1 to 23.
    #[arg(long, default_value_t = 1, value_parser = machines)]
    machines: usize,
    /// Factor on every duration, 0.01 to 1000; watchdogs stay at 1 s or above.
    #[arg(long, default_value_t = 1.0, value_parser = time_scale)]
    time_scale: f64,
    #[command(flatten)]
    place: NewTarget,
}

/// What it is called, and where it goes.
#[derive(Debug, clap::Args)]
struct NewTarget {
    /// Name, which is the ROS namespace and the directory that is made here: lower-case letters, digits and single `_`, a letter first.
    #[arg(value_name = "NAME", value_parser = name)]
    name: Option<String>,
    /// The same as NAME.
    #[arg(long = "name", value_name = "NAME", conflicts_with = "name", value_parser = name)]
    name_option: Option<String>,
    /// Directory to write to; created if missing [default: the name, or else the kind].
    #[arg(long)]
    dir: Option<PathBuf>,
    /// Overwrite an existing description.
    #[arg(long)]
    force: bool,
}

/// The same rule as the reader's.
fn name(word: &str) -> Result<String, String> {
    let mut report = Report::default();
    ros_name(&Located::new(word.to_owned(), 0..word.len()), "line or cell", &mut report);
    match report.into_problems("", word).into_vec().pop() {
        None => Ok(word.to_owned()),
        Some(problem) => {
            let meant = meant_name(word).map_or_else(String::new, |name| format!("; `{name}` would do"));
            let dir = if word.contains(std::path::MAIN_SEPARATOR) { "; a directory is given with --dir" } else { "" };
            Err(format!("{}: {}{meant}{dir}", problem.message, problem.hint.unwrap_or_default()))
        }
    }
}

/// The name that is nearest to a word or to the end of a path; none where nothing of it can be in a name.
fn meant_name(word: &str) -> Option<String> {
    let last = Path::new(word).file_name()?.to_str()?.to_lowercase();
    let words: Vec<&str> = last.split(|c: char| !c.is_ascii_alphanumeric()).filter(|part| !part.is_empty()).collect();
    let name = words.join("_");
    Some(name.trim_start_matches(|c: char| !c.is_ascii_lowercase()).to_owned()).filter(|name| !name.is_empty())
}

fn machines(word: &str) -> Result<usize, String> {
    let most = TransferLine::MACHINES_MAX;
    match word.parse() {
        Ok(machines) if (1..=most).contains(&machines) => Ok(machines),
        Ok(_) | Err(_) => Err(format!("a transfer line has 1 to {most} machines")),
    }
}

fn time_scale(word: &str) -> Result<f64, String> {
    let bounds = TransferLine::TIME_SCALE;
    match word.parse() {
        Ok(scale) if bounds.contains(&scale) => Ok(scale),
        Ok(_) | Err(_) => Err(format!("a time scale is a number from {} to {}", bounds.start(), bounds.end())),
    }
}

/// `linewright new`
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    match &args.kind {
        NewKind::TransferLine(args) => {
            let line = TransferLine { machines: args.machines, time_scale: args.time_scale };
            let dir = args.place.write("transfer-line", &[("line.toml", &line.text())])?;
            next(&dir, "");
        }
        NewKind::RotaryTable(place) => {
            let dir = place.write("rotary-table", &[("line.toml", include_str!("rotary-table/line.toml"))])?;
            next(&dir, "");
        }
        NewKind::Cell(place) => {
            let cell = include_str!("washing-cell/cell.toml");
            let line = include_str!("washing-cell/line.toml");
            let dir = place.write("washing-cell", &[("cell.toml", cell), ("line.toml", line)])?;
            next(&dir, " --parts bowl=3");
        }
        NewKind::EmptyLine(place) => {
            let dir = place.write("empty-line", &[("line.toml", include_str!("empty-line/line.toml"))])?;
            next(&dir, "");
        }
        NewKind::EmptyCell(place) => {
            let cell = include_str!("empty-cell/cell.toml");
            let line = include_str!("empty-cell/line.toml");
            let dir = place.write("empty-cell", &[("cell.toml", cell), ("line.toml", line)])?;
            next(&dir, " --parts A=2");
        }
        NewKind::Other(words) => return Err(no_kind(words)),
    }
    Ok(ExitCode::SUCCESS)
}

fn no_kind(words: &[String]) -> miette::Report {
    let word = words.first().map_or("", String::as_str);
    let meant = linewright_text::nearest(word, KINDS);
    let meant = meant.map_or_else(String::new, |kind| format!("did you mean `{kind}`? "));
    miette!(
        help =
            format!("{meant}for example `linewright new transfer-line my_line`; what each is: `linewright new --help`"),
        "there is no '{word}' to begin with; there are {}",
        KINDS.join(", ")
    )
}

/// Prints the next steps.
fn next(dir: &Path, options: &str) {
    let dir = crate::out::shell_word(&dir.display().to_string());
    crate::out::say!("next:  linewright check {dir}");
    crate::out::say!("       linewright simulate {dir}{options}");
    crate::out::say!("       linewright run {dir}{options}");
}

impl NewTarget {
    /// Writes the files; gives back their directory.
    fn write(&self, kind: &str, files: &[(&str, &str)]) -> miette::Result<PathBuf> {
        let dir = match (&self.dir, self.name()) {
            (Some(dir), _) => dir.clone(),
            (None, Some(name)) => name.into(),
            (None, None) => kind.into(),
        };
        // Either all are written or none.
        for (name, _) in files.iter().filter(|_| !self.force) {
            let file = dir.join(name);
            if file.exists() {
                return Err(is_there(&file));
            }
        }
        create_dir_all(&dir).into_diagnostic().wrap_err_with(|| format!("cannot make {}", dir.display()))?;
        for (name, text) in files {
            let file = dir.join(name);
            write(&file, &self.named(text), self.force)?;
            crate::out::say!("wrote {}", file.display());
        }
        Ok(dir)
    }

    fn name(&self) -> Option<&String> {
        self.name.as_ref().or(self.name_option.as_ref())
    }

    /// The text with the name in it.
    fn named(&self, text: &str) -> String {
        let Some(name) = self.name() else { return text.to_owned() };
        let mut is_done = false;
        let lines = text.split_inclusive('\n').map(|line| match line.strip_prefix("name = \"") {
            Some(rest) if !is_done => {
                is_done = true;
                let (old, rest) = rest.split_once('"').unwrap_or((rest, "\n"));
                format!("name = \"{name}\"{}", rest.replace(old, name))
            }
            _ => line.to_owned(),
        });
        lines.collect()
    }
}

fn is_there(file: &Path) -> miette::Report {
    miette!(help = "--force writes over it; --dir writes elsewhere", "{} is there already", file.display())
}

fn write(file: &Path, text: &str, force: bool) -> miette::Result<()> {
    let mut options = OpenOptions::new();
    // `create_new` leaves no moment between looking for the file and making it.
    if force {
        options.create(true).truncate(true)
    } else {
        options.create_new(true)
    };
    let name = file.display();
    match options.write(true).open(file) {
        Ok(mut open) => {
            open.write_all(text.as_bytes()).into_diagnostic().wrap_err_with(|| format!("cannot write {name}"))
        }
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Err(is_there(file)),
        Err(error) => Err(error).into_diagnostic().wrap_err_with(|| format!("cannot write {name}")),
    }
}

#[cfg(test)]
mod tests {
    use super::name;

    #[test]
    fn a_name_that_cannot_be_one_is_refused_with_one_that_can_and_where_a_directory_goes() {
        assert_eq!(name("my_cell").as_deref(), Ok("my_cell"));
        let refused = |word| name(word).expect_err("it is no ROS name");
        let path = refused("cells/My-Cell 2");
        assert!(path.ends_with("; `my_cell_2` would do; a directory is given with --dir"), "{path}");
        let bare = refused("2Cells");
        assert!(bare.ends_with("; `cells` would do"), "{bare}");
        assert!(refused("42").starts_with("`42` cannot be the name of a line or cell: "), "{}", refused("42"));
    }
}
