//! News of a database that is fed, for the log of the program: its texts.

use std::fmt;
use std::path::PathBuf;

use crate::outage::LostNotes;

/// Change in whether a database is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HistoryNews {
    /// Nothing can be written any more, for now.
    Failed {
        /// Reason, with the path of the file.
        why: String,
        /// What a person can do, unless the reason contains it.
        remedy: Option<&'static str>,
    },
    /// Another program has replaced, removed or shortened the file; it was opened again.
    Replaced { path: PathBuf },
    /// A damaged file was renamed, and a new one begun.
    SetAside { why: String, kept: PathBuf },
    /// It is written again.
    Resumed { path: PathBuf, lost: LostNotes },
}

impl HistoryNews {
    /// Whether it belongs among the warnings of a log.
    pub fn is_warning(&self) -> bool {
        !matches!(self, HistoryNews::Resumed { .. })
    }
}

impl fmt::Display for HistoryNews {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            HistoryNews::Failed { why, remedy } => {
                let remedy = remedy.map_or_else(String::new, |remedy| format!("; {remedy}"));
                write!(f, "{why}; until it is written again reports may lack what happens, control goes on{remedy}")?;
                write!(f, "; writing is tried again by itself")
            }
            HistoryNews::Replaced { path } => write!(
                f,
                "database {} was replaced, removed or cut off while it was written; it is opened again, what was in the file \
                 before is in reports only if it still is in this one; to keep it, stop the coordinator before it is moved",
                path.display()
            ),
            HistoryNews::SetAside { why, kept } => write!(
                f,
                "{why}; it is kept as {}, and a new one is begun: reports have what is in that; repair the old one with `sqlite3 .recover` \
                 if it is needed, else remove it",
                kept.display()
            ),
            HistoryNews::Resumed { path, lost } => {
                write!(f, "database {} is written again; ", path.display())?;
                match lost.count {
                    0 => write!(f, "nothing was lost"),
                    1 => write!(f, "1 note was lost, which reports show"),
                    count => write!(f, "{count} notes were lost, which reports show"),
                }
            }
        }
    }
}
