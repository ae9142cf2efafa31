//! The records of a cell in a log on disk.
//!
//! Each record is a line of JSON, so that a person can read what happened (`strings`); its meaning depends on the table it
//! was written for, so the log begins with the cell's name and the table's digest, and is refused for another. After some
//! thousand records a snapshot of the state takes their place. What is read from the disk is checked: every record is
//! applied to the state in turn.
//!
//! # When it is on the disk
//! [`CellLog::write`] takes what a step of the player left. Records are written at once, which a killed process survives; if
//! the step sends a message, or a person waits for a reply, they and all before them are on the disk before that returns, which a
//! power cut survives.
//! Records that nothing was sent about may be lost by one: they are then received, or decided, again.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use linewright_coordinator_cell::{CellSnapshot, CellTable, PlayerOutbox, PlayerState, Record};
use linewright_node_shell::log::{Disk, LogEntry, LogError, RecordLog};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The form in which records are written. Another one gets another number.
const FORMAT: u32 = 1;
/// After so many records a log begins anew, with a snapshot. A record has some hundred bytes.
pub const RECORDS_MAX: u64 = 10_000;
/// A log waits so long for a database that cannot be written.
const RECORDS_KEPT_MAX: u64 = 10 * RECORDS_MAX;

/// Reason why the log of a cell cannot be used.
#[derive(Debug, Error)]
pub enum CellLogError {
    /// Failure of the log, or contents that do not fit.
    #[error(transparent)]
    Log(#[from] LogError),
    /// It is about something else.
    #[error(
        "log {path} is about {is}, not about {expected}; empty the cell with that description, then remove {path}.*"
    )]
    Other {
        /// The log.
        path: PathBuf,
        /// Cell of the log found.
        is: String,
        /// Cell expected.
        expected: String,
    },
    /// The record cannot be written as text. No state is so.
    #[error("cannot write down what happened: {0}")]
    Text(#[from] serde_json::Error),
}

/// Identity of a log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LogIdentity {
    format: u32,
    cell: String,
    table: String,
}

impl LogIdentity {
    /// Difference to a log with this identity; none if they are equal.
    fn difference(&self, expected: &LogIdentity) -> Option<(String, String)> {
        let of = |format: u32| format!("records in form {format}");
        if self.format != expected.format {
            return Some((of(self.format), of(expected.format)));
        }
        let of = |cell: &str| format!("cell `{cell}`");
        if self.cell != expected.cell {
            return Some((of(&self.cell), of(&expected.cell)));
        }
        let other = || format!("another description of cell `{}` ({})", self.cell, self.table);
        (self.table != expected.table).then(|| (other(), format!("this one ({})", expected.table)))
    }
}

/// The log of a cell, open for writing.
#[derive(Debug)]
pub struct CellLog {
    log: RecordLog,
    /// Since the last snapshot.
    records: u64,
    /// Records at which a snapshot is due: more after one that failed.
    long: u64,
}

/// A log, and its contents.
#[derive(Debug)]
pub struct OpenedLog {
    /// To go on with.
    pub log: CellLog,
    /// State that the log leads to.
    pub state: PlayerState,
    /// Bytes at its end that were torn, and cut off.
    pub cut: u64,
}

impl CellLog {
    /// Opens the log of a cell, or begins one.
    ///
    /// # Errors
    /// When there is a log and it cannot be used, or is about another cell or another description of it.
    pub fn open(path: &Path, cell: &str, table: &Arc<CellTable>) -> Result<OpenedLog, CellLogError> {
        Self::open_on(Disk::default(), path, cell, table)
    }

    /// The same on a disk of the caller's.
    ///
    /// # Errors
    /// As [`CellLog::open`].
    pub fn open_on(disk: Disk, path: &Path, cell: &str, table: &Arc<CellTable>) -> Result<OpenedLog, CellLogError> {
        let expected = LogIdentity { format: FORMAT, cell: cell.to_owned(), table: format!("{:016x}", table.digest()) };
        let (mut state, mut records) = (PlayerState::new(table.clone()), 0);
        let mut difference = None;
        let opened = RecordLog::open_on(disk, path, &serde_json::to_vec(&expected)?, |entry| match entry {
            LogEntry::Identity(bytes) => {
                let is: LogIdentity = serde_json::from_slice(bytes).map_err(|_| "it is no log of a cell".to_owned())?;
                difference = is.difference(&expected);
                difference.as_ref().map_or(Ok(()), |(is, _)| Err(is.clone()))
            }
            LogEntry::Snapshot(bytes) => {
                let snapshot: CellSnapshot = serde_json::from_slice(bytes).map_err(|error| error.to_string())?;
                state = PlayerState::restore(table.clone(), snapshot).map_err(|misfit| misfit.to_string())?;
                Ok(())
            }
            LogEntry::Record(bytes) => {
                let record: Record = serde_json::from_slice(bytes).map_err(|error| error.to_string())?;
                records += 1;
                state.apply(&record).map_err(|misfit| misfit.to_string())
            }
        });
        match (opened, difference) {
            (Ok((log, cut)), _) => Ok(OpenedLog { log: CellLog { log, records, long: RECORDS_MAX }, state, cut }),
            (Err(_), Some((is, expected))) => Err(CellLogError::Other { path: path.to_owned(), is, expected }),
            (Err(error), None) => Err(error.into()),
        }
    }

    /// Writes down the records of a step, before any message that follows from them is sent.
    ///
    /// # Errors
    /// When it cannot be written. Nothing of it may then be sent.
    pub fn write(&mut self, out: &PlayerOutbox) -> Result<(), CellLogError> {
        self.append(&out.records)?;
        if out.needs_disk() { self.sync() } else { Ok(()) }
    }

    /// Writes down records that nothing is sent for yet.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn append(&mut self, records: &[Record]) -> Result<(), CellLogError> {
        if records.is_empty() {
            return Ok(());
        }
        let lines = records.iter().map(serde_json::to_vec).collect::<Result<Vec<_>, _>>()?;
        self.log.append(lines.iter().map(Vec::as_slice))?;
        self.records += records.len() as u64;
        Ok(())
    }

    /// Returns when all that was written is on the disk.
    ///
    /// # Errors
    /// When the disk refuses; the log cannot be used any more.
    pub fn sync(&mut self) -> Result<(), CellLogError> {
        Ok(self.log.sync()?)
    }

    /// Whether there are so many records that a snapshot should take their place.
    pub fn is_long(&self) -> bool {
        self.records >= self.long
    }

    /// Whether there are so many that the log is shortened although the database lacks some of them.
    pub fn is_very_long(&self) -> bool {
        self.records >= RECORDS_KEPT_MAX
    }

    /// Puts a snapshot in the place of all records. `state` is the state they lead to.
    ///
    /// # Errors
    /// When it cannot be written. Unless the log has failed, it goes on without; the next is due later.
    pub fn begin_anew(&mut self, state: &PlayerState) -> Result<(), CellLogError> {
        self.long = self.records + RECORDS_MAX / 10;
        self.log.begin_anew(&serde_json::to_vec(&state.snapshot())?)?;
        (self.records, self.long) = (0, RECORDS_MAX);
        Ok(())
    }

    /// Whether a snapshot alone makes it usable again.
    pub fn has_failed(&self) -> bool {
        self.log.has_failed()
    }

    /// Takes room on the disk for so many bytes of records.
    ///
    /// # Errors
    /// When there is none.
    pub fn make_room(&mut self, least: u64) -> Result<(), CellLogError> {
        Ok(self.log.make_room(least)?)
    }

    /// Bytes of records for which there is room whatever becomes of the disk.
    pub fn room(&self) -> u64 {
        self.log.room()
    }

    /// Finds out whether the disk can be written, changing nothing.
    ///
    /// # Errors
    /// When it cannot.
    pub fn probe(&mut self) -> Result<(), CellLogError> {
        Ok(self.log.probe()?)
    }

    /// The file that is being written, and how long it is.
    pub fn file(&self) -> (PathBuf, u64) {
        (self.log.name(), self.log.bytes())
    }
}

/// State on disk, or the initial state.
pub(super) fn known(
    dir: Option<&Path>,
    cell: &str,
    table: &Arc<CellTable>,
) -> Result<(PlayerState, Option<CellLog>), CellLogError> {
    let Some(dir) = dir else { return Ok((PlayerState::new(table.clone()), None)) };
    let found = CellLog::open(&dir.join("cell.log"), cell, table)?;
    if found.cut > 0 {
        tracing::warn!("the log's last {} bytes were torn, and are cut off", found.cut);
    }
    if found.state.sequence() > 0 {
        let (parts, running) = (found.state.parts().len(), found.state.firings().len());
        tracing::info!("continued from the log: {parts} parts in the cell, {running} activities in progress");
    }
    Ok((found.state, Some(found.log)))
}
