//! The database of a cell, fed with records after they are in its log.
//!
//! The thread of the cell writes a step's records into the log ([`super::CellLog::write`]), sends the messages, and then passes
//! the records to the history, which never blocks. At the beginning of a life the two are compared, and what the database lacks
//! is read from the log. A snapshot removes the records before it from the log, so a snapshot is written only when
//! [`HistoryFeeder::has`] confirms that nothing is lost by it, or when there is no database any more.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use linewright_cell::Cell;
use linewright_coordinator_cell::compile::{CompiledCell, sheet};
use linewright_coordinator_cell::{CellSnapshot, PlayerOutbox, PlayerState, Record};
use linewright_history::{CellAbout, History, HistoryError, HistoryFeed, Note, RecordSource, TimeBase};
use linewright_line::{Line, StationId, Tick};
use linewright_node_shell::log::{LogEntry, RecordLog};

use crate::situation::fault_note;

/// Feeds a database.
#[derive(Debug)]
pub struct HistoryFeeder {
    recorder: HistoryFeed,
    /// The fault of each station as it was last noted.
    faults: BTreeMap<StationId, Option<String>>,
}

impl HistoryFeeder {
    /// Begins a life: `state` is that of the log at `log`, which is the one that is written from here on.
    pub fn begin(history: History, log: &Path, state: &PlayerState) -> Self {
        let source = LogRecords { path: log.to_owned() };
        HistoryFeeder {
            recorder: HistoryFeed::start(history, Box::new(source), state.sequence()),
            faults: BTreeMap::new(),
        }
    }

    /// Records of a step, after they are in the log. `state` is the state after the step.
    pub fn tell(&mut self, state: &PlayerState, out: &PlayerOutbox) {
        let first = state.sequence() + 1 - out.records.len() as u64;
        self.recorder.offer(first, &out.records);
    }

    /// Records an event that is no record of the log.
    pub fn note(&mut self, at: Tick, note: Note) {
        self.recorder.note(at, note);
    }

    /// Records a station's fault, if it has changed.
    pub fn fault(&mut self, at: Tick, station: StationId, text: &str) {
        let noted = self.faults.entry(station).or_default();
        fault_note(noted, station.0, text).into_iter().for_each(|note| self.recorder.note(at, note));
    }

    /// Whether everything that has led to a state is in the database.
    pub fn has(&self, state: &PlayerState) -> bool {
        self.recorder.newest() >= state.sequence()
    }

    /// Reason why nothing more is written; none while it is. The cell goes on without.
    pub fn failed(&self) -> Option<String> {
        self.recorder.failed()
    }

    /// Returns when everything that was passed is in the database.
    ///
    /// # Errors
    /// Reason why it is not.
    pub fn close(self) -> Result<History, HistoryError> {
        self.recorder.close()
    }
}

/// Opens the database beside the log in `dir`, or makes one. Where it cannot be used that is logged, and the cell does
/// without.
pub(super) fn begin(
    dir: &Path,
    (cell, line, made): (&Cell, &Line, &CompiledCell),
    state: &PlayerState,
) -> Option<HistoryFeeder> {
    let about = CellAbout {
        cell: cell.name.clone(),
        title: cell.title.clone(),
        table: made.table.digest(),
        clock: TimeBase::Unix,
        stations: line.stations.iter().map(|station| station.name.clone()).collect(),
        sheet: sheet(cell, made),
    };
    match History::open(&dir.join("cell.db"), &about) {
        Ok(history) => Some(HistoryFeeder::begin(history, &dir.join("cell.log"), state)),
        Err(error) => {
            tracing::error!("{error}; the cell continues without a database");
            None
        }
    }
}

/// The log on disk, read beside its writer.
struct LogRecords {
    path: PathBuf,
}

impl RecordSource for LogRecords {
    fn read(&mut self, take: &mut dyn FnMut(u64, Record)) -> Result<(), String> {
        let mut number = 0;
        let read = RecordLog::read(&self.path, |entry| {
            match entry {
                // Checked by the writer of the log.
                LogEntry::Identity(_) => (),
                LogEntry::Snapshot(bytes) => {
                    let snapshot: CellSnapshot = serde_json::from_slice(bytes).map_err(|error| error.to_string())?;
                    number = snapshot.sequence();
                }
                LogEntry::Record(bytes) => {
                    number += 1;
                    take(number, serde_json::from_slice(bytes).map_err(|error| error.to_string())?);
                }
            }
            Ok(())
        });
        read.map_err(|error| error.to_string())
    }
}
