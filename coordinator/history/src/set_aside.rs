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
///
/// # Errors
/// They cannot be renamed.
pub fn set_aside(path: &Path, now: SystemTime) -> Result<PathBuf, HistoryError> {
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
