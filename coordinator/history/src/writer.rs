//! The database, open for writing.
//!
//! What is written in one call is there whole or not at all. It is in the write-ahead log of the database then, which a
//! killed process survives; a power cut may take the newest of it, and records are fed again from the cell's log.

use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use linewright_coordinator_cell::Record;
use linewright_line::Tick;
use rusqlite::config::DbConfig;
use rusqlite::{Connection, OptionalExtension, Transaction, TransactionBehavior, params};

use crate::error::at;
use crate::event::parts;
use crate::{About, HistoryError, Note, retention, schema};

/// Longest wait for another connection to release the file. Readers never hold it.
pub(crate) const PATIENCE: Duration = Duration::from_secs(5);

/// A database that is open for writing.
#[derive(Debug)]
pub struct History {
    pub(crate) db: Connection,
    pub(crate) path: PathBuf,
    newest: u64,
    file: OpenFile,
    /// What it has to keep; everything if none.
    pub(crate) retention: Option<Duration>,
    /// The newest record that was removed; 0 if none was.
    pub(crate) removed_to: u64,
    /// Others have written into the file: its write-ahead log is of what was there before.
    is_overwritten: bool,
}

/// The file as it was last seen. Others may replace it, shorten it or write into it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct OpenFile {
    device: u64,
    number: u64,
    length: u64,
    /// Time of the last write, in seconds and nanoseconds. With a write-ahead log only this process writes into the file, when it
    /// takes over a part of that.
    written: (i64, i64),
}

impl OpenFile {
    fn of(path: &Path) -> std::io::Result<Self> {
        let of = std::fs::metadata(path)?;
        let written = (of.mtime(), of.mtime_nsec());
        Ok(OpenFile { device: of.dev(), number: of.ino(), length: of.len(), written })
    }

    fn is_same_file(&self, other: &OpenFile) -> bool {
        (self.device, self.number) == (other.device, other.number)
    }
}

/// Item to be written.
#[derive(Clone, Debug)]
pub(crate) enum HistoryItem {
    /// Under its number in the log.
    Record(u64, Record),
    /// Beside the log.
    Note(Tick, Note),
}

impl HistoryItem {
    /// Its number in the log; 0 if it has none.
    pub(crate) fn number(&self) -> u64 {
        match self {
            HistoryItem::Record(number, _) => *number,
            HistoryItem::Note(..) => 0,
        }
    }
}

/// Contents of the database under a number.
enum Under {
    Nothing,
    Same,
    Other,
}

/// Whether a database that is about `is` can be used for `expected`.
pub(crate) fn fits(path: &Path, is: &About, expected: &About) -> Result<(), HistoryError> {
    let other = |(is, expected)| HistoryError::Other { path: path.to_owned(), is, expected };
    is.difference(expected).map_or(Ok(()), |difference| Err(other(difference)))
}

impl History {
    /// Makes a new database.
    ///
    /// # Errors
    /// When there is such a file, or it cannot be written.
    pub fn create(path: &Path, about: impl Into<About>) -> Result<Self, HistoryError> {
        let new = std::fs::File::options().write(true).create_new(true).open(path);
        match new {
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {
                Err(HistoryError::Exists { path: path.to_owned() })
            }
            Err(error) => Err(HistoryError::File { path: path.to_owned(), error }),
            Ok(_) => Self::open(path, about),
        }
    }

    /// Opens the database of a cell or line, or makes one.
    ///
    /// # Errors
    /// When it is no such database, is about another cell or line or another description of it, is damaged, or cannot be
    /// written.
    pub fn open(path: &Path, about: impl Into<About>) -> Result<Self, HistoryError> {
        let (about, failed) = (&about.into(), at(path));
        let mut db = Connection::open(path).map_err(failed)?;
        db.busy_timeout(PATIENCE).map_err(failed)?;
        if schema::is_empty(&db, path)? {
            // The journal mode is kept in the file, and cannot be changed in a transaction.
            db.pragma_update(None, "journal_mode", "WAL").map_err(failed)?;
        }
        let change = db.transaction_with_behavior(TransactionBehavior::Immediate).map_err(failed)?;
        if schema::is_empty(&change, path)? {
            schema::create(&change, path)?;
        } else {
            schema::check(&change, path)?;
            fits(path, &read_about(&change, path)?, about)?;
        }
        write_about(&change, path, about)?;
        change.commit().map_err(failed)?;
        // With a write-ahead log this keeps the database whole over power cuts; what it may lose is fed again.
        db.pragma_update(None, "synchronous", "NORMAL").map_err(failed)?;
        let newest = db.query_row("SELECT ifnull(max(log), 0) FROM event", [], |row| row.get(0)).map_err(failed)?;
        let removed_to = retention::removed(&db).map_err(failed)?.map_or(0, |removed| removed.log);
        let newest = removed_to.max(newest);
        let file = OpenFile::of(path).map_err(|error| HistoryError::File { path: path.to_owned(), error })?;
        Ok(History { db, path: path.to_owned(), newest, file, retention: None, removed_to, is_overwritten: false })
    }

    /// Path of the database.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The number of the newest record that is in it; 0 before the first.
    pub fn newest(&self) -> u64 {
        self.newest
    }

    /// Time of the last event in it.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn last(&self) -> Result<Option<Tick>, HistoryError> {
        let last = self.db.query_row("SELECT max(at) FROM event", [], |row| row.get::<_, Option<u64>>(0));
        Ok(last.map_err(at(&self.path))?.map(Tick::from_micros))
    }

    /// Writes records under their numbers in the log, from `first` on. Rows that are there already stay.
    ///
    /// # Errors
    /// When something else is there under one of the numbers, or they cannot be written. Nothing is written then.
    pub fn feed(&mut self, first: u64, records: &[Record]) -> Result<(), HistoryError> {
        let items: Vec<HistoryItem> =
            (first..).zip(records).map(|(number, of)| HistoryItem::Record(number, of.clone())).collect();
        self.put(&items)
    }

    /// Writes a note.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn note(&mut self, at: Tick, note: &Note) -> Result<(), HistoryError> {
        self.put(&[HistoryItem::Note(at, note.clone())])
    }

    /// Removes records beyond `last`: a power cut has taken them from the log, and nothing was sent about them.
    ///
    /// # Errors
    /// When they cannot be removed.
    pub fn forget_after(&mut self, last: u64) -> Result<(), HistoryError> {
        self.db.execute("DELETE FROM event WHERE log > ?1", [number(last)]).map_err(at(&self.path))?;
        self.newest = self.newest.min(last);
        self.has_written();
        Ok(())
    }

    /// Checks all of it.
    ///
    /// # Errors
    /// The file is damaged, or cannot be read.
    pub(crate) fn check(&self) -> Result<(), HistoryError> {
        let found =
            self.db.query_row("PRAGMA quick_check(1)", [], |row| row.get::<_, String>(0)).map_err(at(&self.path))?;
        if found == "ok" { Ok(()) } else { Err(HistoryError::Damaged { path: self.path.clone(), why: found }) }
    }

    /// Closes it without writing anything more into a file that has its name now, or into what others have put into it.
    pub(crate) fn abandon(self) {
        let is_moved = OpenFile::of(&self.path).map_or(true, |now| !now.is_same_file(&self.file));
        if is_moved {
            // What it has yet to take over from the write-ahead log would be put into the other file.
            let _ = self.db.query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |_| Ok(()));
        }
        let _ = self.db.set_db_config(DbConfig::SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, true);
        let (path, is_overwritten) = (self.path.clone(), self.is_overwritten && !is_moved);
        drop(self);
        if is_overwritten {
            // It would be written over what is there now. A person may want it; its index is made anew.
            let with = |end: &str| {
                let mut name = path.as_os_str().to_owned();
                name.push(end);
                PathBuf::from(name)
            };
            let _ = std::fs::rename(with("-wal"), with("-wal.replaced"));
            let _ = std::fs::remove_file(with("-shm"));
        }
    }

    /// Whether the file with its name still is the one that is open, with the content that this has written.
    fn check_file(&mut self) -> Result<(), HistoryError> {
        match OpenFile::of(&self.path) {
            Ok(now) if self.file == now => Ok(()),
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(HistoryError::File { path: self.path.clone(), error })
            }
            Ok(now) => {
                self.is_overwritten = now.is_same_file(&self.file);
                Err(HistoryError::Replaced { path: self.path.clone() })
            }
            Err(_) => Err(HistoryError::Replaced { path: self.path.clone() }),
        }
    }

    /// Looks at the file after a change: a part of the write-ahead log may have been put into it.
    pub(crate) fn has_written(&mut self) {
        // The next change finds out what is wrong.
        let now = OpenFile::of(&self.path).ok().filter(|now| now.is_same_file(&self.file));
        self.file = now.unwrap_or(self.file);
    }

    pub(crate) fn put(&mut self, items: &[HistoryItem]) -> Result<(), HistoryError> {
        self.check_file()?;
        let failed = at(&self.path);
        let change = self.db.transaction_with_behavior(TransactionBehavior::Immediate).map_err(failed)?;
        let mut newest = self.newest;
        for item in items {
            match item {
                // It was removed, and the log still has it.
                HistoryItem::Record(number, _) if *number <= self.removed_to => {}
                HistoryItem::Record(number, record) => {
                    match insert(&change, *number, record).map_err(failed)? {
                        Under::Nothing | Under::Same => (),
                        Under::Other => {
                            return Err(HistoryError::OtherLog { path: self.path.clone(), number: *number });
                        }
                    }
                    newest = newest.max(*number);
                }
                HistoryItem::Note(at, note) => {
                    let (kind, data) = parts(note);
                    let mut add = change
                        .prepare_cached("INSERT INTO event (at, kind, data) VALUES (?1, ?2, ?3)")
                        .map_err(failed)?;
                    add.execute(params![number(at.as_micros()), kind, data]).map_err(failed)?;
                }
            }
        }
        change.commit().map_err(failed)?;
        self.newest = newest;
        self.has_written();
        Ok(())
    }
}

/// Writes a record where there is none; the record that was there.
fn insert(change: &Transaction<'_>, of: u64, record: &Record) -> rusqlite::Result<Under> {
    let (kind, data) = parts(&record.fact);
    let when = number(record.at.as_micros());
    let mut add = change
        .prepare_cached("INSERT INTO event (log, at, kind, data) VALUES (?1, ?2, ?3, ?4) ON CONFLICT DO NOTHING")?;
    if add.execute(params![number(of), when, kind, data])? > 0 {
        return Ok(Under::Nothing);
    }
    let mut look = change.prepare_cached("SELECT at = ?2 AND kind = ?3 AND data = ?4 FROM event WHERE log = ?1")?;
    let same = look.query_row(params![number(of), when, kind, data], |row| row.get::<_, bool>(0)).optional()?;
    Ok(if same == Some(true) { Under::Same } else { Under::Other })
}

/// As SQLite has numbers. None of ours is ever as large as the largest of these.
pub(crate) fn number(of: u64) -> i64 {
    i64::try_from(of).unwrap_or(i64::MAX)
}

pub(crate) fn read_about(db: &Connection, path: &Path) -> Result<About, HistoryError> {
    let text =
        db.query_row("SELECT data FROM about", [], |row| row.get::<_, String>(0)).optional().map_err(at(path))?;
    let damaged = |why: String| HistoryError::Damaged { path: path.to_owned(), why };
    let text = text.ok_or_else(|| damaged("no cell or line named in its header".to_owned()))?;
    // Perhaps of another version of this program: it is not damaged, and not set aside.
    let unknown = |error| format!("its header cannot be read: {error}");
    serde_json::from_str(&text)
        .map_err(|error| HistoryError::NotOurs { path: path.to_owned(), why: Some(unknown(error)) })
}

fn write_about(db: &Connection, path: &Path, about: &About) -> Result<(), HistoryError> {
    let text = serde_json::to_string(about)
        .map_err(|error| HistoryError::Refused { path: path.to_owned(), why: error.to_string() })?;
    let written = db.execute("INSERT OR REPLACE INTO about (only, data) VALUES (1, ?1)", [text]);
    written.map(|_| ()).map_err(at(path))
}
