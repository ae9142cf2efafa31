//! Removal of what is older than a database has to keep, in small steps.
//!
//! Rows go in the order of their times, and what was removed last is in a table of its own: reports begin there, and records that the log
//! still has are not taken again. Of notes whose effect lasts (a mode, a station that is lost) the newest is moved to the new
//! beginning, so that the situation there is known.

use std::time::Duration;

use linewright_line::Tick;
use rusqlite::{Connection, OptionalExtension, TransactionBehavior, params};

use crate::error::at;
use crate::event::parts;
use crate::writer::number;
use crate::{History, HistoryError, Note};

/// Rows removed in one step, at least. A step takes some milliseconds.
const STEP: usize = 500;

/// Made with the first removal: other versions read databases without it.
const TABLE: &str = "
CREATE TABLE IF NOT EXISTS removed (
  only INTEGER PRIMARY KEY CHECK (only = 1),
  -- What is before this time is not there, in microseconds.
  until INTEGER NOT NULL,
  -- The newest record of the log among it.
  log INTEGER NOT NULL
) STRICT";

/// The newest rows, up to a time, of notes whose effect lasts.
const LASTING: &str = "
SELECT max(id) FROM event
WHERE log IS NULL AND at <= ?1 AND kind IN ('mode', 'emergency-stop', 'station', 'device', 'fault')
GROUP BY kind, station";

/// Removed part of a database.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RemovedPart {
    /// Everything before this.
    pub until: Tick,
    /// The newest record of a log among it; 0 if there was none.
    pub log: u64,
}

/// The removed part of a database; none if all is there.
pub(crate) fn removed(db: &Connection) -> rusqlite::Result<Option<RemovedPart>> {
    let is_there = "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name = 'removed'";
    if db.query_row(is_there, [], |row| row.get::<_, i64>(0))? == 0 {
        return Ok(None);
    }
    let row = |row: &rusqlite::Row<'_>| Ok(RemovedPart { until: Tick::from_micros(row.get(0)?), log: row.get(1)? });
    db.query_row("SELECT until, log FROM removed", [], row).optional()
}

impl History {
    /// Keeps what is at most so old, beside the newest; everything if none.
    #[must_use]
    pub fn keeping(mut self, retention: Option<Duration>) -> Self {
        self.retention = retention;
        self
    }

    /// Removes a part of what is too old: some more than the number of rows that were written meanwhile. How many.
    pub(crate) fn remove_old(&mut self, written: usize) -> Result<usize, HistoryError> {
        let (Some(retention), Some(last)) = (self.retention, self.last()?) else { return Ok(0) };
        let kept_from = Tick::ZERO + last.since(Tick::ZERO + retention);
        if !self.is_covered(kept_from, last, retention)? {
            return Ok(0);
        }
        self.remove_before(kept_from, STEP + 2 * written)
    }

    /// Whether the rows from `kept_from` on span at least half of the retention time. If not, the line stood still for long, or the
    /// clock was wrong when the newest row was written, so ages measured from that row may be wrong.
    fn is_covered(&self, kept_from: Tick, last: Tick, retention: Duration) -> Result<bool, HistoryError> {
        let first = "SELECT min(at) FROM event WHERE at >= ?1";
        let first = self.db.query_row(first, [number(kept_from.as_micros())], |row| row.get::<_, Option<u64>>(0));
        let first = first.map_err(at(&self.path))?.map_or(last, Tick::from_micros);
        Ok(last.since(first) >= retention / 2)
    }

    fn remove_before(&mut self, kept_from: Tick, most: usize) -> Result<usize, HistoryError> {
        let failed = at(&self.path);
        let change = self.db.transaction_with_behavior(TransactionBehavior::Immediate).map_err(failed)?;
        let nth = "SELECT at FROM event WHERE at < ?1 ORDER BY at LIMIT 1 OFFSET ?2";
        let last = "SELECT max(at) FROM event WHERE at < ?1";
        let before = number(kept_from.as_micros());
        let bound: Option<i64> = change
            .query_row(nth, params![before, most as i64], |row| row.get(0))
            .optional()
            .map_err(failed)?
            .or(change.query_row(last, [before], |row| row.get(0)).map_err(failed)?);
        let Some(bound) = bound else { return Ok(0) };
        // Something newer is there: the newest is kept.
        let next = "SELECT min(at) FROM event WHERE at > ?1";
        let next: i64 = change.query_row(next, [bound], |row| row.get(0)).map_err(failed)?;
        let newest = "SELECT ifnull(max(log), 0) FROM event WHERE at <= ?1";
        let log = change.query_row(newest, [bound], |row| row.get::<_, u64>(0)).map_err(failed)?.max(self.removed_to);
        let moved = format!("UPDATE event SET at = ?2 WHERE id IN ({LASTING})");
        change.execute(&moved, [bound, next]).map_err(failed)?;
        let removed = change.execute("DELETE FROM event WHERE at <= ?1", [bound]).map_err(failed)?;
        if log > self.removed_to {
            let old = "DELETE FROM event WHERE log IS NULL AND kind = 'missing' AND data ->> '$.to' <= ?1";
            change.execute(old, [number(log)]).map_err(failed)?;
            let (kind, data) = parts(&Note::Missing { from: 1, to: log });
            let add = "INSERT INTO event (at, kind, data) VALUES (?1, ?2, ?3)";
            change.execute(add, params![next, kind, data]).map_err(failed)?;
        }
        change.execute_batch(TABLE).map_err(failed)?;
        let note = "INSERT OR REPLACE INTO removed (only, until, log) VALUES (1, ?1, ?2)";
        change.execute(note, params![next, number(log)]).map_err(failed)?;
        change.commit().map_err(failed)?;
        self.removed_to = log;
        self.has_written();
        Ok(removed)
    }
}
