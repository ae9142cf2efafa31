//! The database of a cell, fed with records after they are in its log.
//!
//! The thread of the cell writes a step's records into the log ([`super::CellLog::write`]), sends the messages, and then passes
//! the records to the history, which never blocks. At the beginning of a life the two are compared, and what the database lacks
//! is read from the log. A snapshot removes the records before it from the log, so a snapshot is written only when
//! [`HistoryFeeder::has`] confirms that nothing is lost by it, or while the database could not be written for long: the log stays bounded,
//! and the database says what is missing in it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use linewright_cell::Cell;
use linewright_coordinator_cell::compile::{CompiledCell, sheet};
use linewright_coordinator_cell::{CellSnapshot, PlayerOutbox, PlayerState, Record};
use linewright_history::{CellAbout, History, HistoryError, HistoryFeed, Note, RecordSource, TimeBase};
use linewright_line::{Line, StationId, Tick};
use linewright_node_shell::log::{LogEntry, RecordLog};

use crate::line::log_news;
use crate::situation::fault_note;

/// Feeds a database.
#[derive(Debug)]
pub struct HistoryFeeder {
    recorder: HistoryFeed,
    /// The fault of each station as it was last noted.
    faults: BTreeMap<StationId, Option<String>>,
    /// [`HistoryFeed::resumed`] as it was last looked at.
    resumed: u64,
}

impl HistoryFeeder {
    /// Begins a life: `state` is that of the log at `log`, which is the one that is written from here on. The database is
    /// opened on the thread that feeds it, and again after each failure.
    pub fn open(path: &Path, about: CellAbout, log: &Path, state: &PlayerState, retention: Option<Duration>) -> Self {
        let (path, source) = (path.to_owned(), LogRecords { path: log.to_owned() });
        let open = move || Ok(History::open(&path, &about)?.keeping(retention));
        HistoryFeeder {
            recorder: HistoryFeed::of_log(open, Box::new(source), state.sequence()),
            faults: BTreeMap::new(),
            resumed: 0,
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

    /// Reason why nothing is written now; none while it is. It is tried again, and the cell goes on meanwhile.
    pub fn failed(&self) -> Option<String> {
        self.recorder.failed()
    }

    /// Whether nothing is written now.
    pub fn is_failing(&self) -> bool {
        self.recorder.is_failing()
    }

    /// Logs what has become of the database. Whether notes may have been lost since the last call: what is known has to be
    /// noted anew.
    pub(super) fn has_resumed(&mut self) -> bool {
        log_news(&self.recorder);
        let resumed = self.recorder.resumed();
        let has_resumed = std::mem::replace(&mut self.resumed, resumed) != resumed;
        if has_resumed {
            self.faults.clear();
        }
        has_resumed
    }

    /// Returns when everything that was passed is in the database.
    ///
    /// # Errors
    /// Reason why it is not.
    pub fn close(self) -> Result<History, HistoryError> {
        self.recorder.close()
    }
}

/// Begins to feed the database beside the log in `dir`.
pub(super) fn begin(
    dir: &Path,
    (cell, line, made): (&Cell, &Line, &CompiledCell),
    state: &PlayerState,
    retention: Option<Duration>,
) -> HistoryFeeder {
    let about = CellAbout {
        cell: cell.name.clone(),
        title: cell.title.clone(),
        table: made.table.digest(),
        clock: TimeBase::Unix,
        stations: line.stations.iter().map(|station| station.name.clone()).collect(),
        sheet: sheet(cell, made),
    };
    HistoryFeeder::open(&dir.join("cell.db"), about, &dir.join("cell.log"), state, retention)
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
