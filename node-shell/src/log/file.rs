//! The files of a log: what they are called, how one comes to be, and which of them counts.

use std::ffi::OsString;
use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use super::disk::Disk;
use super::frame::{self, Head};
use super::{LogError, at, too_large};

const SEGMENT_MAX: u64 = 1 << 62;

/// The file of a segment.
pub(super) fn name(path: &Path, segment: u64) -> PathBuf {
    beside(path, &segment.to_string())
}

fn beside(path: &Path, what: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".");
    name.push(what);
    name.into()
}

fn directory(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent.as_os_str().is_empty() => Path::new("."),
        Some(parent) => parent,
        None => Path::new("."),
    }
}

/// Keeps every other process away until it is dropped; makes the directory if there is none.
pub(super) fn lock(path: &Path) -> Result<File, LogError> {
    std::fs::create_dir_all(directory(path)).map_err(|error| at(path, error))?;
    let name = beside(path, "lock");
    let file = File::options().read(true).write(true).create(true).truncate(false).open(&name);
    let file = file.map_err(|error| at(&name, error))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(LogError::InUse { path: path.to_owned() }),
        Err(TryLockError::Error(error)) => Err(at(&name, error)),
    }
}

/// The segments there are, in no order.
fn segments(path: &Path) -> Result<Vec<u64>, LogError> {
    let failed = |error| at(path, error);
    let mut prefix: OsString = path.file_name().unwrap_or_default().to_owned();
    prefix.push(".");
    let mut found = Vec::new();
    for entry in std::fs::read_dir(directory(path)).map_err(failed)? {
        let file = entry.map_err(failed)?.file_name();
        let number = file.to_str().zip(prefix.to_str()).and_then(|(file, prefix)| file.strip_prefix(prefix));
        // Another spelling of a number is not ours, nor is one that cannot have been reached.
        let is_ours = |text: &str, number: u64| number.to_string() == text && number < SEGMENT_MAX;
        let number = number.and_then(|text| text.parse().ok().filter(|&number| is_ours(text, number)));
        found.extend(number);
    }
    Ok(found)
}

/// The segment that counts.
pub(super) fn newest(path: &Path) -> Result<Option<u64>, LogError> {
    Ok(segments(path)?.into_iter().max())
}

/// Removes what a segment has replaced, and what was never finished.
pub(super) fn tidy(path: &Path, segment: u64) -> Result<(), LogError> {
    let old = segments(path)?.into_iter().filter(|&old| old < segment).map(|old| name(path, old));
    for file in old.chain([beside(path, "new")]) {
        match std::fs::remove_file(&file) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(at(&file, error)),
            Ok(()) | Err(_) => (),
        }
    }
    Ok(())
}

/// Content of a new segment.
pub(super) struct NewSegment<'a> {
    pub segment: u64,
    /// The number of its first frame.
    pub number: u64,
    pub identity: &'a [u8],
    pub snapshot: Option<&'a [u8]>,
    /// Bytes behind that for records to come.
    pub room: u64,
}

/// A new segment, on the disk and with its name; where its records begin.
pub(super) fn create(disk: &Disk, path: &Path, new: &NewSegment<'_>) -> Result<(File, u64), LogError> {
    let &NewSegment { segment, number, identity, snapshot, room } = new;
    let mut bytes = Vec::new();
    let fits = |bytes| too_large(path, bytes);
    frame::encode(&mut bytes, &Head { number, synced: 0 }, identity).map_err(fits)?;
    let head = Head { number: number + 1, synced: 0 };
    frame::encode(&mut bytes, &head, snapshot.unwrap_or_default()).map_err(fits)?;
    let end = bytes.len() as u64;
    bytes.resize(bytes.len() + usize::try_from(room).unwrap_or(0), 0);
    let (unfinished, name) = (beside(path, "new"), name(path, segment));
    let written = || {
        let file = File::options().read(true).write(true).create(true).truncate(true).open(&unfinished)?;
        disk.write(&file, &bytes, 0)?;
        disk.sync(&file)?;
        disk.rename(&file, &unfinished, &name)?;
        // The name as well.
        disk.sync(&File::open(directory(path))?)?;
        Ok(file)
    };
    written().map(|file| (file, end)).map_err(|error| {
        // What was not finished takes no room.
        let _ = std::fs::remove_file(&unfinished);
        at(&name, error)
    })
}
