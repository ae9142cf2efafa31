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
    /// What this database is about and what was expected, where they differ.
    pub(crate) fn difference(&self, expected: &About) -> Option<(String, String)> {
        let (is, other) = (self.name(), expected.name());
        if is != other {
            return Some((is, other));
        }
        if self.clock() != expected.clock() {
            let of = |about: &About| match about.clock() {
                TimeBase::Unix => format!("{is} that has run"),
                TimeBase::Simulated => format!("a simulation of {is}"),
            };
            return Some((of(self), of(expected)));
        }
        match (self, expected) {
            (About::Cell(is), About::Cell(expected)) => is.difference(expected),
            (About::Line(is), About::Line(expected)) => is.difference(expected),
            (_, _) => None,
        }
    }

    fn clock(&self) -> TimeBase {
        match self {
            About::Cell(of) => of.clock,
            About::Line(of) => of.clock,
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
    /// Difference in stations or operations. Planned times may differ: the newest count.
    fn difference(&self, expected: &LineAbout) -> Option<(String, String)> {
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
    /// What is different in a database that is about this, if it cannot be used for `expected`: what it is about, and what
    /// it should be. Times, titles and what stations are called may differ.
    fn difference(&self, expected: &CellAbout) -> Option<(String, String)> {
        let other = || format!("another description of cell `{}` ({:016x})", self.cell, self.table);
        (self.table != expected.table).then(|| (other(), format!("this one ({:016x})", expected.table)))
    }
}
