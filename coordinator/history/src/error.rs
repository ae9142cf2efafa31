//! Reasons why a database cannot be used.

use std::io;
use std::path::{Path, PathBuf};

use rusqlite::ErrorCode;
use thiserror::Error;

/// Reason why a database cannot be used.
#[derive(Debug, Error)]
pub enum HistoryError {
    /// The file system refuses.
    #[error("cannot use database {path}: {error}")]
    File {
        path: PathBuf,
        /// The system's reason.
        error: io::Error,
    },
    /// There is one already, and a new one was requested.
    #[error("{path} exists already; choose another name, or remove it")]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The file is no database of a cell or line.
    #[error("{path} is no database of a cell or line{}", .why.as_ref().map(|why| format!(" ({why})")).unwrap_or_default())]
    NotOurs {
        /// The file.
        path: PathBuf,
        /// Reason, where known.
        why: Option<String>,
    },
    /// Another version of the program wrote it.
    #[error("database {path} has form {is}, this program reads form {expected}: it was written by another version")]
    Form {
        path: PathBuf,
        /// Form of the file.
        is: i64,
        /// The form that is understood.
        expected: i64,
    },
    /// The database is about another cell or line, or another description of it.
    #[error("database {path} is about {is}, not about {expected}; move it away to begin a new one")]
    Other {
        path: PathBuf,
        /// Cell or line found.
        is: String,
        /// Cell or line expected.
        expected: String,
    },
    /// The log differs: it was begun anew, and the database was not.
    #[error(
        "database {path} has another record {number} than the log, so it is of another log of the same cell; move it \
         away to begin a new one"
    )]
    OtherLog {
        path: PathBuf,
        /// The first number under which they differ.
        number: u64,
    },
    /// Its contents cannot have happened.
    #[error("database {path} is damaged: {why}")]
    Damaged {
        path: PathBuf,
        /// Contradiction found.
        why: String,
    },
    /// Another program has replaced, removed or shortened the file while it was open.
    #[error("database {path} was replaced, removed or cut off while it was written")]
    Replaced {
        /// The file.
        path: PathBuf,
    },
    /// The database refuses.
    #[error("cannot use database {path}: {why}")]
    Refused {
        path: PathBuf,
        /// Reason given by the database system.
        why: String,
    },
    /// The log from which it is caught up cannot be read.
    #[error("records missing in database {path} cannot be added from the log: {why}")]
    Source {
        path: PathBuf,
        /// Reason.
        why: String,
    },
}

impl HistoryError {
    /// The file.
    pub fn path(&self) -> &Path {
        match self {
            HistoryError::File { path, .. }
            | HistoryError::Exists { path }
            | HistoryError::NotOurs { path, .. }
            | HistoryError::Form { path, .. }
            | HistoryError::Other { path, .. }
            | HistoryError::OtherLog { path, .. }
            | HistoryError::Damaged { path, .. }
            | HistoryError::Replaced { path }
            | HistoryError::Refused { path, .. }
            | HistoryError::Source { path, .. } => path,
        }
    }

    /// Whether the file cannot be used by anything as a database: its contents are not those of one.
    pub(crate) fn is_damage(&self) -> bool {
        matches!(self, HistoryError::Damaged { .. } | HistoryError::NotOurs { why: None, .. })
    }

    /// What a person can do; none where the reason contains it.
    pub fn remedy(&self) -> Option<&'static str> {
        match self {
            HistoryError::File { .. } | HistoryError::Refused { .. } => {
                Some("make room on the disk, or make file and directory writable")
            }
            HistoryError::Source { .. } => Some("make the log readable"),
            HistoryError::NotOurs { .. } | HistoryError::Form { .. } | HistoryError::Damaged { .. } => {
                Some("move it away to begin a new one")
            }
            HistoryError::Exists { .. }
            | HistoryError::Other { .. }
            | HistoryError::OtherLog { .. }
            | HistoryError::Replaced { .. } => None,
        }
    }
}

/// Adds the file to a failure, and distinguishes a damaged file from a missing one.
pub(crate) fn at(path: &Path) -> impl Fn(rusqlite::Error) -> HistoryError + Copy {
    |error| {
        let path = path.to_owned();
        match error.sqlite_error_code() {
            Some(ErrorCode::NotADatabase) => HistoryError::NotOurs { path, why: None },
            Some(ErrorCode::DatabaseCorrupt) => HistoryError::Damaged { path, why: error.to_string() },
            // A value of another type than was written.
            None => HistoryError::Damaged { path, why: error.to_string() },
            Some(_) => HistoryError::Refused { path, why: error.to_string() },
        }
    }
}
