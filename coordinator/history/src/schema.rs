//! The tables, and views for queries in SQL.
//!
//! One table has everything that has happened. Columns for selections are computed from the JSON, so that they are never at
//! odds with it, and a fact with a part, a firing, a station has them by itself. The views add names to numbers and the end
//! of an activity to its beginning; the program uses none of them.

use std::path::Path;

use rusqlite::Connection;

use crate::HistoryError;
use crate::error::at;

/// Application id of the file: `LWRT`.
const APPLICATION: i64 = 0x4C57_5254;
/// The form of the tables. Another one gets another number.
const FORM: i64 = 1;

const TABLES: &str = "
CREATE TABLE about (
  only INTEGER PRIMARY KEY CHECK (only = 1),
  -- Cell, description, resources, modes.
  data TEXT NOT NULL CHECK (json_valid(data))
) STRICT;

CREATE TABLE event (
  id INTEGER PRIMARY KEY,
  -- The number of the record in the cell's log; none for what is in no log.
  log INTEGER UNIQUE,
  -- Microseconds, of what about.clock says.
  at INTEGER NOT NULL,
  kind TEXT NOT NULL,
  data TEXT NOT NULL CHECK (json_valid(data)),
  mode INTEGER GENERATED ALWAYS AS (data ->> '$.mode') VIRTUAL,
  part INTEGER GENERATED ALWAYS AS (data ->> '$.part') VIRTUAL,
  firing INTEGER GENERATED ALWAYS AS (data ->> '$.firing') VIRTUAL,
  station INTEGER GENERATED ALWAYS AS (data ->> '$.station') VIRTUAL
);
CREATE INDEX event_at ON event (at, log);
CREATE INDEX event_kind ON event (kind, at);
CREATE INDEX event_part ON event (part) WHERE part IS NOT NULL;
CREATE INDEX event_firing ON event (firing) WHERE firing IS NOT NULL;

CREATE VIEW resource AS
  SELECT key AS resource, value ->> '$.name' AS name, value ->> '$.prototype' AS prototype,
    value ->> '$.capacity' AS capacity
  FROM json_each((SELECT data FROM about), '$.sheet.resources');
CREATE VIEW mode AS
  SELECT key AS mode, value ->> '$.name' AS name, value ->> '$.activity' AS activity
  FROM json_each((SELECT data FROM about), '$.sheet.modes');
-- Each activity with its beginning, its failure and its end, in microseconds.
CREATE VIEW activity AS
  SELECT started.firing, mode.activity, mode.name, started.part, started.at AS began,
    (SELECT at FROM event WHERE firing = started.firing AND kind = 'raised') AS failed,
    (SELECT at FROM event WHERE firing = started.firing AND kind = 'ended') AS ended
  FROM event AS started LEFT JOIN mode ON mode.mode = started.mode
  WHERE started.kind = 'started';
";

/// Makes a new database, empty but for its tables.
pub fn create(db: &Connection, path: &Path) -> Result<(), HistoryError> {
    db.execute_batch(TABLES).map_err(at(path))?;
    db.pragma_update(None, "application_id", APPLICATION).map_err(at(path))?;
    db.pragma_update(None, "user_version", FORM).map_err(at(path))
}

/// Whether there is nothing in a file yet, as after a process killed while it made it.
pub fn is_empty(db: &Connection, path: &Path) -> Result<bool, HistoryError> {
    let tables = db.query_row("SELECT count(*) FROM sqlite_schema", [], |row| row.get::<_, i64>(0));
    Ok(tables.map_err(at(path))? == 0)
}

/// Whether it has these tables.
pub fn check(db: &Connection, path: &Path) -> Result<(), HistoryError> {
    let number = |name| db.query_row(&format!("PRAGMA {name}"), [], |row| row.get::<_, i64>(0)).map_err(at(path));
    if number("application_id")? != APPLICATION {
        let why = Some("another program's".to_owned());
        return Err(HistoryError::NotOurs { path: path.to_owned(), why });
    }
    match number("user_version")? {
        FORM => Ok(()),
        is => Err(HistoryError::Form { path: path.to_owned(), is, expected: FORM }),
    }
}
