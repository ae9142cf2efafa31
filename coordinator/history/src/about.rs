//! What a database is about: one cell, as it was described.

use linewright_coordinator_cell::tracking::ReportMetadata;
use serde::{Deserialize, Serialize};

/// What a database is about. All that a report has to know of the cell is in it, so that none needs the description.
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
