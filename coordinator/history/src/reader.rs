//! The database, open for reading beside its writer: of one moment from beginning to end.

use std::path::{Path, PathBuf};

use linewright_coordinator_cell::RecordKind;
use linewright_line::Tick;
use rusqlite::{Connection, OpenFlags};

use crate::error::at;
use crate::event::{EventKind, HistoryEvent, whole};
use crate::writer::{PATIENCE, fits, number, read_about};
use crate::{About, HistoryError, Note, RemovedPart, retention, schema};

/// A database as it was when it was opened, whatever is written meanwhile.
#[derive(Debug)]
pub struct HistoryReader {
    db: Connection,
    path: PathBuf,
    about: About,
}

impl HistoryReader {
    /// Opens a database. Nothing in it is changed.
    ///
    /// # Errors
    /// When there is none, it is something else, of another form, or damaged.
    pub fn open(path: &Path) -> Result<Self, HistoryError> {
        // The database's own message does not name the error of the file.
        std::fs::File::open(path).map_err(|error| HistoryError::File { path: path.to_owned(), error })?;
        // A connection that may only read leaves files behind that others would have to remove; so it may write, and
        // does not.
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let db = Connection::open_with_flags(path, flags).map_err(at(path))?;
        db.pragma_update(None, "query_only", true).map_err(at(path))?;
        db.busy_timeout(PATIENCE).map_err(at(path))?;
        // All that is read from here on is of the moment in which the first of it is.
        db.execute_batch("BEGIN").map_err(at(path))?;
        if schema::is_empty(&db, path)? {
            return Err(HistoryError::NotOurs { path: path.to_owned(), why: Some("it is empty".to_owned()) });
        }
        schema::check(&db, path)?;
        let about = read_about(&db, path)?;
        Ok(HistoryReader { db, path: path.to_owned(), about })
    }

    pub fn about(&self) -> &About {
        &self.about
    }

    /// Whether a coordinator of what is `expected` goes on with this database.
    ///
    /// # Errors
    /// When it is about something else.
    pub fn fits(&self, expected: impl Into<About>) -> Result<(), HistoryError> {
        fits(&self.path, &self.about, &expected.into())
    }

    /// The part that was removed, since it was older than what has to be kept; none if nothing was.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn removed(&self) -> Result<Option<RemovedPart>, HistoryError> {
        retention::removed(&self.db).map_err(at(&self.path))
    }

    /// Times of the first and the last event; none if there is none.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn span(&self) -> Result<Option<(Tick, Tick)>, HistoryError> {
        let row = |row: &rusqlite::Row<'_>| Ok((row.get::<_, Option<u64>>(0)?, row.get::<_, Option<u64>>(1)?));
        let span = self.db.query_row("SELECT min(at), max(at) FROM event", [], row).map_err(at(&self.path))?;
        Ok(span.0.zip(span.1).map(|(first, last)| (Tick::from_micros(first), Tick::from_micros(last))))
    }

    /// Gives everything that has happened until a moment, itself included, to `take`, in its order; the records as the log
    /// has them.
    ///
    /// # Errors
    /// When it cannot be read, or its contents are impossible.
    pub fn each(&self, until: Tick, mut take: impl FnMut(HistoryEvent)) -> Result<(), HistoryError> {
        let failed = at(&self.path);
        let damaged = |why: String| HistoryError::Damaged { path: self.path.clone(), why };
        let mut select = self
            .db
            .prepare("SELECT id, log, at, kind, data FROM event WHERE at <= ?1 ORDER BY at, log, id")
            .map_err(failed)?;
        let mut rows = select.query([number(until.as_micros())]).map_err(failed)?;
        let (mut newest, mut count) = (0, 0_u64);
        while let Some(row) = rows.next().map_err(failed)? {
            let EventColumns { id, log, at, kind, data } =
                EventColumns::new(row).map_err(|error| damaged(error.to_string()))?;
            let unknown = |error| damaged(format!("event {id} of kind `{kind}` is none: {error}"));
            let what = match log {
                Some(log) => {
                    if log != newest + 1 {
                        return Err(damaged(format!("record {log} of the log follows on record {newest}")));
                    }
                    newest = log;
                    EventKind::Fact(log, whole::<RecordKind>(&kind, &data).map_err(unknown)?)
                }
                None => EventKind::Note(whole::<Note>(&kind, &data).map_err(unknown)?),
            };
            // A note of what is missing comes before what is there again: of one time, what has no number comes first.
            if let EventKind::Note(Note::Missing { from: _, to }) = what {
                newest = to;
            }
            count += 1;
            take(HistoryEvent { at: Tick::from_micros(at), what });
        }
        // A damaged index can hide rows without being noticed; the table itself is counted beside it.
        let all = "SELECT count(*) FROM event NOT INDEXED WHERE at <= ?1";
        let all: u64 = self.db.query_row(all, [number(until.as_micros())], |row| row.get(0)).map_err(failed)?;
        if all == count { Ok(()) } else { Err(damaged(format!("{count} of {all} events can be found"))) }
    }
}

/// A row as it is.
struct EventColumns {
    id: i64,
    log: Option<u64>,
    at: u64,
    kind: String,
    data: String,
}

impl EventColumns {
    fn new(row: &rusqlite::Row<'_>) -> rusqlite::Result<Self> {
        Ok(EventColumns { id: row.get(0)?, log: row.get(1)?, at: row.get(2)?, kind: row.get(3)?, data: row.get(4)? })
    }
}
