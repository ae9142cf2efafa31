//! Memory of a node across a kill or a power failure, where the newest record alone does not suffice: all records, in
//! their order.
//!
//! Beside [`crate::Journal`], which replaces one record, this appends: a record is written behind the one before
//! ([`RecordLog::append`]), and is on the disk after [`RecordLog::sync`]. Before a record's content is published, it is
//! synced. So that a log does not grow for ever, it begins anew with a *snapshot* of everything that its records have
//! led to ([`RecordLog::begin_anew`]); the content of records and snapshots is their owner's business, here they are
//! bytes.
//!
//! # Files
//! `PATH.1`, `PATH.2`, …, of which the last counts; each begins with the log's identity and the snapshot. One is
//! complete and on the disk before it gets its name, and the one before is removed after that. `PATH.lock` keeps a
//! second process away.
//!
//! # State after a crash
//! Every record that was synced, in order, and perhaps some that were not. A record that is not whole is *torn*: it and
//! all behind it were not synced, are cut off, and were never published. To distinguish a torn record from one that was
//! damaged on the disk, each contains the number of records synced when it was written: if a later one counts it as
//! synced, the log is refused. Memory does not depend on how long a log is, only on its largest record.

mod file;
mod frame;

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use thiserror::Error;

pub use frame::RECORD_BYTES_MAX;
use frame::{FrameFound, Head};

/// A buffer that was larger is given back.
const BUFFER_BYTES: usize = 64 * 1024;

/// Why a log cannot be used.
#[derive(Debug, Error)]
pub enum LogError {
    /// The file system refuses.
    #[error("cannot use log {path}: {error}")]
    File {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        error: io::Error,
    },
    /// Another process has it.
    #[error("log {path} is in use by another process")]
    InUse { path: PathBuf },
    /// A record larger than [`RECORD_BYTES_MAX`].
    #[error("a record of {bytes} bytes is too large for log {path}, whose records have at most {most}")]
    TooLarge {
        path: PathBuf,
        /// The record.
        bytes: usize,
        /// The most there may be.
        most: usize,
    },
    /// A record that was on the disk is not there any more.
    #[error("log {path} is damaged at byte {offset}, before records that were flushed; not used")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Position in the file.
        offset: u64,
    },
    /// Its owner cannot use its content.
    #[error("log {path} cannot be used from byte {offset} on: {why}")]
    Refused {
        /// The file.
        path: PathBuf,
        /// Position of the record.
        offset: u64,
        /// Its owner's reason.
        why: String,
    },
    /// The end of an earlier, failed write may be in the file.
    #[error("log {path}: an earlier write failed; open it again")]
    Failed {
        /// The file.
        path: PathBuf,
    },
}

/// Entry of a log, from its beginning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogEntry<'a> {
    /// Identity of the log. It comes first, and is not empty.
    Identity(&'a [u8]),
    /// Sum of all records that are gone.
    Snapshot(&'a [u8]),
    Record(&'a [u8]),
}

/// A log that is open for writing.
#[derive(Debug)]
pub struct RecordLog {
    path: PathBuf,
    identity: Vec<u8>,
    segment: u64,
    file: File,
    /// Position of the next record.
    end: u64,
    /// The number of the next frame.
    next: u64,
    /// The newest frame that is on the disk.
    synced: u64,
    has_failed: bool,
    buffer: Vec<u8>,
    /// Held as long as this is.
    _lock: File,
}

impl RecordLog {
    /// Opens the log at `path`, or begins one about `identity`, and gives everything in it to `read`; how many bytes of a
    /// torn end were cut off. A log that exists keeps its identity: `read` is to refuse one that it does not like.
    ///
    /// # Errors
    /// When the files cannot be created, read or locked; when something on the disk is damaged; what `read` refuses.
    pub fn open(
        path: &Path,
        identity: &[u8],
        mut read: impl FnMut(LogEntry<'_>) -> Result<(), String>,
    ) -> Result<(Self, u64), LogError> {
        let lock = file::lock(path)?;
        let (identity, segment, file, opened) = match file::newest(path)? {
            None => {
                let (file, end) = file::create(path, 1, 1, identity, None)?;
                (identity.to_vec(), 1, file, Opened { end, next: 3, cut: 0, identity: Vec::new() })
            }
            Some(segment) => {
                let name = file::name(path, segment);
                let file = File::options().read(true).write(true).open(&name).map_err(|error| at(&name, error))?;
                let mut opened = read_all(&file, &name, &mut read)?;
                if opened.cut > 0 {
                    // On the disk, lest what was cut off comes back behind what is written next.
                    file.set_len(opened.end).and_then(|()| file.sync_all()).map_err(|error| at(&name, error))?;
                }
                (std::mem::take(&mut opened.identity), segment, file, opened)
            }
        };
        file::tidy(path, segment)?;
        let Opened { end, next, cut, .. } = opened;
        let mut log = RecordLog {
            path: path.to_owned(),
            identity,
            segment,
            file,
            end,
            next,
            synced: 0,
            has_failed: false,
            buffer: Vec::new(),
            _lock: lock,
        };
        // Data written by a killed process may be in memory only; its owner counts on them from now on.
        log.sync()?;
        Ok((log, cut))
    }

    /// Gives everything that the newest file of the log at `path` has to `read`, as far as it is written, while another thread
    /// or process may be writing it. Nothing is changed; a record that is being written is left out.
    ///
    /// # Errors
    /// When there is none, or it cannot be read; when something on the disk is damaged; what `read` refuses.
    pub fn read(path: &Path, mut read: impl FnMut(LogEntry<'_>) -> Result<(), String>) -> Result<(), LogError> {
        loop {
            let Some(segment) = file::newest(path)? else { return Err(at(path, io::ErrorKind::NotFound.into())) };
            let name = file::name(path, segment);
            match File::open(&name) {
                Ok(file) => return read_all(&file, &name, &mut read).map(|_| ()),
                // It has begun anew in between.
                Err(_) if file::newest(path)?.is_some_and(|newest| newest > segment) => (),
                Err(error) => return Err(at(&name, error)),
            }
        }
    }

    /// Writes records behind all others, in one go. They are kept if the process is killed, and after [`RecordLog::sync`] if the
    /// power goes.
    ///
    /// # Errors
    /// When a record is too large or cannot be written; none of them is in the log then.
    pub fn append<'a>(&mut self, records: impl IntoIterator<Item = &'a [u8]>) -> Result<(), LogError> {
        self.must_work()?;
        self.buffer.clear();
        let mut next = self.next;
        for record in records {
            frame::encode(&mut self.buffer, &Head { number: next, synced: self.synced }, record)
                .map_err(|bytes| too_large(&self.path, bytes))?;
            next += 1;
        }
        if let Err(error) = self.file.write_all_at(&self.buffer, self.end) {
            // The begun write is taken back at once, on the disk as well; otherwise its content is unknown.
            self.has_failed = self.file.set_len(self.end).and_then(|()| self.file.sync_all()).is_err();
            return Err(at(&self.name(), error));
        }
        self.end += self.buffer.len() as u64;
        self.next = next;
        self.buffer.shrink_to(BUFFER_BYTES);
        Ok(())
    }

    /// Returns when all that was written is on the disk; at once if it is.
    ///
    /// # Errors
    /// When the disk refuses. Its content is unknown then, so the log has failed for good.
    pub fn sync(&mut self) -> Result<(), LogError> {
        self.must_work()?;
        if self.synced + 1 < self.next {
            self.file.sync_data().map_err(|error| {
                self.has_failed = true;
                at(&file::name(&self.path, self.segment), error)
            })?;
            self.synced = self.next - 1;
        }
        Ok(())
    }

    /// Goes on with a snapshot in the place of all there is. It is on the disk when this returns.
    ///
    /// # Errors
    /// When the snapshot is too large or the file system refuses. Unless it has failed by that, the
    /// log before it goes on.
    pub fn begin_anew(&mut self, snapshot: &[u8]) -> Result<(), LogError> {
        self.must_work()?;
        let segment = self.segment + 1;
        let created = file::create(&self.path, segment, self.next, &self.identity, Some(snapshot));
        // With its name, but perhaps not on the disk: which of the two will be found is unknown.
        self.has_failed = created.is_err() && file::name(&self.path, segment).exists();
        (self.file, self.end) = created?;
        self.segment = segment;
        self.synced = self.next + 1;
        self.next += 2;
        // Whatever cannot be removed now is removed the next time.
        _ = file::tidy(&self.path, segment);
        Ok(())
    }

    /// The file that is being written.
    pub fn name(&self) -> PathBuf {
        file::name(&self.path, self.segment)
    }

    /// Its length, in bytes.
    pub fn bytes(&self) -> u64 {
        self.end
    }

    fn must_work(&self) -> Result<(), LogError> {
        if self.has_failed { Err(LogError::Failed { path: self.name() }) } else { Ok(()) }
    }
}

/// Content found in a file.
struct Opened {
    end: u64,
    next: u64,
    cut: u64,
    identity: Vec<u8>,
}

fn read_all(
    file: &File,
    name: &Path,
    read: &mut impl FnMut(LogEntry<'_>) -> Result<(), String>,
) -> Result<Opened, LogError> {
    let failed = |error| at(name, error);
    let bytes = file.metadata().map_err(failed)?.len();
    let mut opened = Opened { end: 0, next: 0, cut: 0, identity: Vec::new() };
    let (mut position, mut record) = (0_u64, Vec::new());
    while opened.end < bytes {
        let head = match frame::read(file, opened.end, bytes, &mut record).map_err(failed)? {
            FrameFound::Whole(head) if position == 0 || head.number == opened.next => head,
            // The first two were on the disk before the file had its name.
            FrameFound::Whole(_) | FrameFound::Torn if position < 2 => break,
            FrameFound::Whole(_) | FrameFound::Torn => {
                if frame::is_counted_on(file, opened.end, bytes, opened.next).map_err(failed)? {
                    return Err(LogError::Damaged { path: name.to_owned(), offset: opened.end });
                }
                opened.cut = bytes - opened.end;
                break;
            }
        };
        let entry = match position {
            0 => {
                opened.identity = record.clone();
                Some(LogEntry::Identity(&record))
            }
            1 => (!record.is_empty()).then_some(LogEntry::Snapshot(&record)),
            _ => Some(LogEntry::Record(&record)),
        };
        let refused = |why| LogError::Refused { path: name.to_owned(), offset: opened.end, why };
        entry.map_or(Ok(()), &mut *read).map_err(refused)?;
        opened.next = head.number + 1;
        opened.end += frame::HEAD_BYTES + record.len() as u64;
        position += 1;
    }
    if position < 2 {
        return Err(LogError::Damaged { path: name.to_owned(), offset: opened.end });
    }
    Ok(opened)
}

fn at(path: &Path, error: io::Error) -> LogError {
    LogError::File { path: path.to_owned(), error }
}

fn too_large(path: &Path, bytes: usize) -> LogError {
    LogError::TooLarge { path: path.to_owned(), bytes, most: RECORD_BYTES_MAX }
}
