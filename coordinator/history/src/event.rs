//! One row: a record, or a note.
//!
//! A fact is written as serde writes it, `{"started": {…}}`, and kept in two columns, the word and what stands behind it.
//! So a fact that is new needs nothing here, and an unknown word is of a newer program.

use linewright_coordinator_cell::{Record, RecordKind};
use linewright_line::Tick;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::Note;

/// Event in a database: a record of the log, or a note, with its time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HistoryEvent {
    /// Time of the event, in µs of the caller's clock.
    pub at: Tick,
    /// Kind of event with its data.
    pub what: EventKind,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// Record of the log under a number.
    Fact(u64, RecordKind),
    /// An event that is in no log.
    Note(Note),
}

impl HistoryEvent {
    pub fn record(&self) -> Option<Record> {
        match &self.what {
            EventKind::Fact(_, fact) => Some(Record { at: self.at, fact: fact.clone() }),
            EventKind::Note(_) => None,
        }
    }

    /// Kind of the event, and its content as JSON, as reports print them.
    pub fn parts(&self) -> (String, String) {
        match &self.what {
            EventKind::Fact(_, fact) => parts(fact),
            EventKind::Note(note) => parts(note),
        }
    }
}

/// Splits what serde writes of an enum into the variant's word and the rest.
pub(crate) fn parts<T: Serialize>(of: &T) -> (String, String) {
    // Facts and notes have string keys and finite numbers only, which always have a text.
    let text = serde_json::to_string(of).unwrap_or_default();
    let split = || {
        let rest = text.strip_prefix("{\"")?.strip_suffix('}')?;
        let (kind, data) = rest.split_once("\":")?;
        Some((kind.to_owned(), data.to_owned()))
    };
    split().unwrap_or_else(|| (text.trim_matches('"').to_owned(), "null".to_owned()))
}

/// Puts them together again.
pub(crate) fn whole<T: DeserializeOwned>(kind: &str, data: &str) -> Result<T, serde_json::Error> {
    let text = if data == "null" { format!("\"{kind}\"") } else { format!("{{\"{kind}\":{data}}}") };
    serde_json::from_str(&text)
}
