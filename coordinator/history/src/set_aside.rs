//! Damaged databases, kept under another name: the first, which has most in it, and the newest.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use chrono::{DateTime, Utc};

use crate::HistoryError;

/// Files that belong to a database: itself, its write-ahead log and the index of that.
const FILES: [&str; 3] = ["", "-wal", "-shm"];
/// Databases kept at most. A bad disk would fill itself with them.
const KEPT_MAX: usize = 5;

fn with(path: &Path, end: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(end);
    PathBuf::from(name)
}

/// Renames the files of a database so that the time is in their names; gives the name of the first. Of more than are kept those after
/// the first are removed.
pub(crate) fn set_aside(path: &Path, now: SystemTime) -> Result<PathBuf, HistoryError> {
    let time = DateTime::<Utc>::from(now).format("%Y%m%dT%H%M%SZ").to_string();
    let names = std::iter::once(String::new()).chain((2..100).map(|nth| format!("-{nth}")));
    let kept = names.map(|nth| with(path, &format!(".damaged-{time}{nth}"))).find(|kept| !kept.exists());
    let kept = kept.unwrap_or_else(|| with(path, ".damaged"));
    // The database first: if it cannot be renamed, it still has what belongs to it.
    for end in FILES {
        match std::fs::rename(with(path, end), with(&kept, end)) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(HistoryError::File { path: path.to_owned(), error });
            }
            Ok(()) | Err(_) => {}
        }
    }
    let all = kept_before(path);
    for old in all.iter().skip(1).take(all.len().saturating_sub(KEPT_MAX)) {
        for end in FILES {
            let _ = std::fs::remove_file(with(old, end));
        }
    }
    Ok(kept)
}

/// Databases that were set aside, the first first.
fn kept_before(path: &Path) -> Vec<PathBuf> {
    let (Some(dir), Some(name)) = (path.parent(), path.file_name().and_then(|name| name.to_str())) else {
        return Vec::new();
    };
    let prefix = format!("{name}.damaged-");
    let is_one = |name: &str| name.starts_with(&prefix) && !FILES[1..].iter().any(|end| name.ends_with(end));
    let dir = if dir.as_os_str().is_empty() { Path::new(".") } else { dir };
    let entries = std::fs::read_dir(dir).into_iter().flatten().flatten();
    let mut all: Vec<PathBuf> = entries
        .map(|entry| entry.path())
        .filter(|path| path.file_name().and_then(|name| name.to_str()).is_some_and(is_one))
        .collect();
    all.sort();
    all
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_damaged_database_is_kept_with_its_time_and_all_that_belongs_to_it_and_none_is_overwritten() {
        let dir = tempfile::tempdir().expect("a directory");
        let path = dir.path().join("line.db");
        let at = SystemTime::UNIX_EPOCH + Duration::from_secs(1_795_000_000);
        for nth in ["", "-2"] {
            for end in ["", "-wal"] {
                std::fs::write(dir.path().join(format!("line.db{end}")), format!("{nth}{end}")).expect("written");
            }
            let kept = set_aside(&path, at).expect("renamed");
            let name = kept.file_name().and_then(|name| name.to_str()).expect("a name").to_owned();
            assert_eq!(name, format!("line.db.damaged-20261118T110640Z{nth}"));
            for end in ["", "-wal"] {
                let text = std::fs::read_to_string(dir.path().join(format!("{name}{end}"))).expect("it is kept");
                assert_eq!(text, format!("{nth}{end}"));
            }
            assert!(!path.exists());
        }
    }

    #[test]
    fn of_many_damaged_databases_the_first_and_the_newest_are_kept() {
        let dir = tempfile::tempdir().expect("a directory");
        let path = dir.path().join("line.db");
        for nth in 0..9_u64 {
            for end in ["", "-wal"] {
                std::fs::write(dir.path().join(format!("line.db{end}")), nth.to_string()).expect("written");
            }
            set_aside(&path, SystemTime::UNIX_EPOCH + Duration::from_secs(1_795_000_000 + nth)).expect("renamed");
        }
        let files = |end: &str| {
            let mut names: Vec<PathBuf> = std::fs::read_dir(dir.path())
                .expect("a directory")
                .map(|entry| entry.expect("an entry").path())
                .filter(|path| path.to_str().is_some_and(|name| name.ends_with(end)))
                .collect();
            names.sort();
            names.iter().map(|name| std::fs::read_to_string(name).expect("it is there")).collect::<Vec<_>>()
        };
        for end in ["Z", "-wal"] {
            assert_eq!(files(end), ["0", "5", "6", "7", "8"], "{end}");
        }
    }
}
