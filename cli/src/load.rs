//! Reading a description from disk.

use std::path::{Path, PathBuf};

use linewright_line::{Line, StationId};
use miette::{IntoDiagnostic, WrapErr, miette};

/// A description may be this large; the parser refuses more, so do not read more.
const TEXT_BYTES_MAX: u64 = 4 << 20;

/// The description file a path means: itself, or `line.toml` in the directory.
pub fn file_of(path: &Path) -> PathBuf {
    if path.is_dir() { path.join("line.toml") } else { path.to_owned() }
}

/// Reads and checks a description; warnings go to standard error unless `quiet`.
pub fn line(path: &Path, quiet: bool) -> miette::Result<Line> {
    let parsed = parsed(path)?;
    if !quiet {
        for warning in &parsed.warnings {
            eprintln!("{}:{}:{}: warning: {}", file_of(path).display(), warning.line, warning.column, warning.message);
        }
    }
    let mut line = parsed.line;
    with_device_files(&mut line, path, quiet)?;
    Ok(line)
}

/// Adds what the devices' own files say, which lie beside the description.
pub fn with_device_files(line: &mut Line, path: &Path, quiet: bool) -> miette::Result<()> {
    let file = file_of(path);
    crate::devices::complete(line, file.parent().unwrap_or(Path::new("")), quiet)?;
    crate::frames::complete(line, &file)
}

/// Reads and parses a description, keeping its warnings.
pub fn parsed(path: &Path) -> miette::Result<linewright_line::Parsed> {
    let file = file_of(path);
    let name = file.display().to_string();
    let size = std::fs::metadata(&file).into_diagnostic().wrap_err_with(|| format!("cannot read {name}"))?.len();
    if size > TEXT_BYTES_MAX {
        return Err(miette::miette!("{name} has {size} bytes; a description has {TEXT_BYTES_MAX} at most"));
    }
    let text = std::fs::read_to_string(&file).into_diagnostic().wrap_err_with(|| format!("cannot read {name}"))?;
    linewright_line::parse(&name, &text).map_err(miette::Report::new)
}

/// The station of this name.
pub fn station(line: &Line, name: &str) -> miette::Result<StationId> {
    line.station_named(name).ok_or_else(|| {
        let known: Vec<&str> = line.stations.iter().map(|s| s.name.as_str()).collect();
        miette!("no station '{name}'; the line has {}", known.join(", "))
    })
}
