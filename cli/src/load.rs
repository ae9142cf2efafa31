//! Reading a description from disk.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use linewright_line::{Line, Problem, StationId};
use miette::miette;

use crate::files::description;

/// The description file of a line that a path means: itself, or `line.toml` in the directory, or beside a cell's.
pub fn file_of(path: &Path) -> PathBuf {
    line_file(path, cell_file(path).as_deref())
}

fn line_file(path: &Path, cell: Option<&Path>) -> PathBuf {
    match cell {
        _ if path.is_dir() => path.join("line.toml"),
        Some(cell) => cell.with_file_name("line.toml"),
        None => path.to_owned(),
    }
}

/// The description of a cell that a path means: itself, or the `cell.toml` of a directory. Called otherwise, it is
/// recognised by what is in it.
pub fn cell_file(path: &Path) -> Option<PathBuf> {
    if path.is_dir() {
        return Some(path.join(CELL)).filter(|file| file.is_file());
    }
    let is_called = path.file_name().is_some_and(|name| name == CELL);
    let is_one = || description(path).is_ok_and(|text| linewright_cell::is_described(&text));
    ((is_called && path.is_file()) || is_one()).then(|| path.to_owned())
}

/// The descriptions that a path means.
pub struct Files {
    pub line: Option<PathBuf>,
    /// Of a flexible cell.
    pub cell: Option<PathBuf>,
}

/// The name of a cell's description, beside the line's or alone.
const CELL: &str = "cell.toml";

/// The descriptions that a path means: those in the directory; with a cell's the line beside it, if there is one; with any
/// other file, a line's, that alone.
pub fn files_of(path: &Path) -> Files {
    let cell = cell_file(path);
    let line = line_file(path, cell.as_deref());
    // Without either file, the error is about the line's, which is the usual one.
    let line = Some(line).filter(|file| cell.is_none() || file.is_file());
    Files { line, cell }
}

/// Reads and parses the description of a cell, whose stations are those of `line`.
pub fn cell(file: &Path, line: Option<&Line>) -> miette::Result<linewright_cell::ParsedCell> {
    let text = description(file)?;
    if linewright_line::is_described(&text) {
        let name = file.display();
        return Err(miette!(help = "a line's is called line.toml", "{name} describes a line, not a flexible cell"));
    }
    linewright_cell::parse(&file.display().to_string(), &text, line).map_err(miette::Report::new)
}

/// The cell beside a line, if there is one.
pub fn cell_of(path: &Path, line: &Line) -> miette::Result<Option<linewright_cell::Cell>> {
    let file = files_of(path).cell;
    file.map(|file| cell(&file, Some(line)).map(|parsed| parsed.cell)).transpose()
}

/// The line that a path means, or that of a cell, quietly; and whether it is a cell's.
pub fn line_or_cell(path: &Path) -> miette::Result<(Line, bool)> {
    let files = files_of(path);
    let file = files.line.ok_or_else(|| miette!("{} has no line.toml: its stations cannot run", path.display()))?;
    Ok((line(&file, true)?, files.cell.is_some()))
}

/// The line of a cell, quietly.
pub fn line_of_cell(path: &Path) -> miette::Result<Line> {
    // A path that does not exist is reported before anything about cells.
    let (line, is_cell) = line_or_cell(path)?;
    if !is_cell {
        return Err(miette!(
            help = "`linewright why` and `linewright watch` show what a line waits for",
            "{} has no cell.toml: it is a line, and a line has no orders, alarms or resources",
            path.display()
        ));
    }
    Ok(line)
}

/// Reads and checks a description; warnings go to standard error unless `quiet`.
pub fn line(path: &Path, quiet: bool) -> miette::Result<Line> {
    let parsed = parsed(path)?;
    if !quiet {
        warn(&file_of(path), &parsed.warnings);
    }
    let mut line = parsed.line;
    with_device_files(&mut line, path, quiet)?;
    Ok(line)
}

/// Prints the warnings on a description on standard error.
pub fn warn(file: &Path, warnings: &[Problem]) {
    for warning in warnings {
        crate::out::complain!("{}:{}:{}: warning: {}", file.display(), warning.line, warning.column, warning.message);
    }
}

/// Adds the content of the devices' own files, which are beside the description.
pub fn with_device_files(line: &mut Line, path: &Path, quiet: bool) -> miette::Result<()> {
    let file = file_of(path);
    crate::devices::complete(line, file.parent().unwrap_or(Path::new("")), quiet)?;
    crate::frames::complete(line, &file)
}

/// Reads and parses a description, keeping its warnings.
pub fn parsed(path: &Path) -> miette::Result<linewright_line::ParsedLine> {
    let file = file_of(path);
    if file != path && !path.is_dir() && !file.exists() {
        let (cell, line) = (path.display(), file.display());
        return Err(miette!("{cell} describes a flexible cell; {line}, the line of its stations, is not there"));
    }
    let text = description(&file)?;
    if linewright_cell::is_described(&text) {
        let name = file.display();
        return Err(miette!(help = "a cell's is called cell.toml", "{name} describes a flexible cell, not a line"));
    }
    linewright_line::parse(&file.display().to_string(), &text).map_err(miette::Report::new)
}

pub fn station(line: &Line, name: &str) -> miette::Result<StationId> {
    line.station_named(name).ok_or_else(|| {
        let known: Vec<&str> = line.stations.iter().map(|s| s.name.as_str()).collect();
        or_meant(miette!("no station '{name}'; the line has {}", known.join(", ")), name, known)
    })
}

/// The error about an unknown word, with the known one that is probably meant.
pub fn or_meant<'a>(error: miette::Report, word: &str, known: impl IntoIterator<Item = &'a str>) -> miette::Report {
    let near = linewright_text::nearest(word, known).map(|near| format!("did you mean `{near}`?"));
    let help = near.or_else(|| error.help().map(|help| help.to_string()));
    WrongArgument { text: error.to_string(), help }.into()
}

/// An argument that names nothing there is: the command ends with the exit code of every wrong argument.
#[derive(Debug)]
pub struct WrongArgument {
    text: String,
    help: Option<String>,
}

impl WrongArgument {
    pub fn new(text: impl Into<String>) -> Self {
        WrongArgument { text: text.into(), help: None }
    }
}

impl Display for WrongArgument {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text)
    }
}

impl std::error::Error for WrongArgument {}

impl miette::Diagnostic for WrongArgument {
    fn help(&self) -> Option<Box<dyn Display + '_>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn Display>)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_station_is_answered_with_the_one_that_is_meant() {
        let text = linewright_line::TransferLine::default().text();
        let line = linewright_line::parse("line.toml", &text).expect("it parses").line;
        let wrong = |name| station(&line, name).expect_err("there is none");
        assert!(wrong("transfre").is::<WrongArgument>(), "it ends with 2");
        let help = |name| wrong(name).help().map(|help| help.to_string());
        assert_eq!(help("transfre").as_deref(), Some("did you mean `transfer`?"));
        assert_eq!(help("oven"), None);
    }

    #[test]
    fn a_directory_means_what_is_in_it() {
        let dir = tempfile::tempdir().expect("a directory");
        let found = |path: &Path| {
            let Files { line, cell } = files_of(path);
            let name =
                |file: Option<PathBuf>| file.map(|file| file.strip_prefix(dir.path()).expect("in it").to_owned());
            (name(line), name(cell))
        };
        let (line, cell) = (Some(PathBuf::from("line.toml")), Some(PathBuf::from("cell.toml")));
        assert_eq!(found(dir.path()), (line.clone(), None));
        std::fs::write(dir.path().join("cell.toml"), "").expect("written");
        assert_eq!(found(dir.path()), (None, cell.clone()));
        assert_eq!(found(&dir.path().join("cell.toml")), (None, cell.clone()));
        std::fs::write(dir.path().join("line.toml"), "").expect("written");
        assert_eq!(found(dir.path()), (line.clone(), cell.clone()));
        assert_eq!(found(&dir.path().join("cell.toml")), (line.clone(), cell));
        assert_eq!(found(&dir.path().join("line.toml")), (line.clone(), None));
        // Whatever it is called, a cell's is recognised.
        let other = PathBuf::from("other.toml");
        for (text, is_cell) in [
            ("[cell]\nwip_max = 3\n", true),
            ("[[resource]]\nname = \"rack\"\n", true),
            ("[[station]]\n[cell]\n", false),
            ("name = \"x\"\n", false),
            ("[cell", false),
        ] {
            std::fs::write(dir.path().join(&other), text).expect("written");
            let wanted = if is_cell { (line.clone(), Some(other.clone())) } else { (Some(other.clone()), None) };
            assert_eq!(found(&dir.path().join(&other)), wanted, "{text}");
        }
    }
}
