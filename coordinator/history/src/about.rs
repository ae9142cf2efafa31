//! Identity of a database: one cell or one line, as it was described.

use linewright_coordinator_cell::tracking::ReportMetadata;
use serde::{Deserialize, Serialize};

/// Identity of a database.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum About {
    Cell(CellAbout),
    Line(LineAbout),
}

impl From<&CellAbout> for About {
    fn from(of: &CellAbout) -> Self {
        About::Cell(of.clone())
    }
}

impl From<&LineAbout> for About {
    fn from(of: &LineAbout) -> Self {
        About::Line(of.clone())
    }
}

impl About {
    pub(crate) fn difference(&self, expected: &About) -> Option<(String, String)> {
        match (self, expected) {
            (About::Cell(is), About::Cell(expected)) => is.difference(expected),
            (About::Line(is), About::Line(expected)) => is.difference(expected),
            (is, expected) => Some((is.name(), expected.name())),
        }
    }

    fn name(&self) -> String {
        match self {
            About::Cell(of) => format!("cell `{}`", of.cell),
            About::Line(of) => format!("line `{}`", of.line),
        }
    }
}

/// A line of a database. Contains all that a report needs of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LineAbout {
    /// The line's name.
    pub line: String,
    pub title: String,
    pub clock: TimeBase,
    /// Its stations, by number.
    pub stations: Vec<LineStation>,
    /// Planned duration of a cycle, in µs; 0: nothing is planned.
    pub cycle_us: u64,
}

/// A station of a line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LineStation {
    pub name: String,
    /// Its operations, by number.
    pub operations: Vec<LineOperation>,
}

/// An operation of a line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LineOperation {
    pub name: String,
    /// When it begins and ends in a cycle of the line that has run in, by the description alone: µs after the first of them
    /// begins.
    pub planned_us: Option<(u64, u64)>,
}

impl LineAbout {
    /// Difference, as [`CellAbout::difference`]. Planned times may differ: the newest count.
    fn difference(&self, expected: &LineAbout) -> Option<(String, String)> {
        let name = |of: &LineAbout| format!("line `{}`", of.line);
        if (&self.line, self.clock) != (&expected.line, expected.clock) {
            return Some((name(self), name(expected)));
        }
        let names = |of: &LineAbout| -> Vec<(String, Vec<String>)> {
            let operations = |of: &LineStation| of.operations.iter().map(|of| of.name.clone()).collect();
            of.stations.iter().map(|of| (of.name.clone(), operations(of))).collect()
        };
        let other = || format!("line `{}` with other stations or operations", self.line);
        (names(self) != names(expected)).then(|| (other(), "its description".to_owned()))
    }
}

/// A cell of a database. Contains all that a report needs of it, so that none needs the description.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellAbout {
    /// The cell's name.
    pub cell: String,
    pub title: String,
    /// The digest of the table that the records are about.
    pub table: u64,
    pub clock: TimeBase,
    /// Its stations, by number.
    pub stations: Vec<String>,
    /// Modes and resources.
    pub sheet: ReportMetadata,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TimeBase {
    /// Microseconds since 1970 began, UTC.
    Unix,
    /// Microseconds since a simulation began.
    Simulated,
}

impl CellAbout {
    /// Difference because of which a database with this identity cannot be used for `expected`: value found, and value
    /// expected. Times, titles and names of stations may differ.
    pub(crate) fn difference(&self, expected: &CellAbout) -> Option<(String, String)> {
        let of = |cell: &str| format!("cell `{cell}`");
        if self.cell != expected.cell {
            return Some((of(&self.cell), of(&expected.cell)));
        }
        if self.clock != expected.clock {
            let of = |clock| match clock {
                TimeBase::Unix => "a cell that has run".to_owned(),
                TimeBase::Simulated => "a simulation".to_owned(),
            };
            return Some((of(self.clock), of(expected.clock)));
        }
        let other = || format!("another description of cell `{}` ({:016x})", self.cell, self.table);
        (self.table != expected.table).then(|| (other(), format!("this one ({:016x})", expected.table)))
    }
}
