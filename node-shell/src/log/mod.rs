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
//!
//! # A full disk
//! [`RecordLog::make_room`] writes zeros behind the records. Records to come replace them, which needs no more of the disk. Zeros
//! at the end of a file are no torn record.
//!
//! # A disk that fails
//! A write that fails is taken back, and can be repeated. After a failed sync the content of the file is unknown: then
//! [`RecordLog::begin_anew`] alone goes on, into another file.

mod disk;
mod file;
mod frame;

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

pub use disk::{Disk, DiskFaults, DiskOperation};
use file::NewSegment;
pub use frame::RECORD_BYTES_MAX;
use frame::{FrameFound, Head};

/// A buffer that was larger is given back.
const BUFFER_BYTES: usize = 64 * 1024;
/// Room is made in pieces of this, so that it is made seldom.
const ROOM_BYTES: u64 = 256 * 1024;
/// Written to find out whether a disk can be.
const PROBE_BYTES: u64 = 512;

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
    #[error("log {path}: an earlier write failed, its content is unknown")]
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
    disk: Disk,
    path: PathBuf,
    identity: Vec<u8>,
    segment: u64,
    file: File,
    /// Position of the next record.
    end: u64,
    /// Length of the file: behind `end` it is zero.
    length: u64,
    /// Room asked for.
    least_room: u64,
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
        read: impl FnMut(LogEntry<'_>) -> Result<(), String>,
    ) -> Result<(Self, u64), LogError> {
        Self::open_on(Disk::default(), path, identity, read)
    }

    /// The same on a disk of the caller's.
    ///
    /// # Errors
    /// As [`RecordLog::open`].
    pub fn open_on(
        disk: Disk,
        path: &Path,
        identity: &[u8],
        mut read: impl FnMut(LogEntry<'_>) -> Result<(), String>,
    ) -> Result<(Self, u64), LogError> {
        let lock = file::lock(path)?;
        let (identity, segment, file, opened) = match file::newest(path)? {
            None => {
                let new = NewSegment { segment: 1, number: 1, identity, snapshot: None, room: 0 };
                let (file, end) = file::create(&disk, path, &new)?;
                (identity.to_vec(), 1, file, Opened { end, length: end, next: 3, cut: 0, identity: Vec::new() })
            }
            Some(segment) => {
                let name = file::name(path, segment);
                let file = File::options().read(true).write(true).open(&name).map_err(|error| at(&name, error))?;
                let mut opened = read_all(&file, &name, &mut read)?;
                if opened.cut > 0 {
                    // On the disk, lest what was cut off comes back behind what is written next. The room stays.
                    let zeros = vec![0; usize::try_from(opened.cut).unwrap_or(0)];
                    let cleared = disk.write(&file, &zeros, opened.end).and_then(|()| disk.sync(&file));
                    cleared.map_err(|error| at(&name, error))?;
                }
                (std::mem::take(&mut opened.identity), segment, file, opened)
            }
        };
        file::tidy(path, segment)?;
        let Opened { end, length, next, cut, .. } = opened;
        let mut log = RecordLog {
            disk,
            path: path.to_owned(),
            identity,
            segment,
            file,
            end,
            length,
            least_room: 0,
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
        if let Err(error) = self.disk.write(&self.file, &self.buffer, self.end) {
            // The begun write is taken back at once, on the disk as well; otherwise its content is unknown.
            self.has_failed = self.take_back().is_err();
            return Err(at(&self.name(), error));
        }
        self.end += self.buffer.len() as u64;
        self.length = self.length.max(self.end);
        self.next = next;
        self.buffer.shrink_to(BUFFER_BYTES);
        Ok(())
    }

    /// Takes back a write at the end of the records. Room stays room: a disk that is full would not give it again.
    fn take_back(&mut self) -> io::Result<()> {
        self.buffer.fill(0);
        let in_room = self.buffer.len().min(usize::try_from(self.room()).unwrap_or(usize::MAX));
        if self.disk.write(&self.file, &self.buffer[..in_room], self.end).is_err() {
            self.length = self.end;
        }
        self.disk.set_len(&self.file, self.length)?;
        self.disk.sync(&self.file)
    }

    /// Returns when all that was written is on the disk; at once if it is.
    ///
    /// # Errors
    /// When the disk refuses. Its content is unknown then, so the log has failed for good.
    pub fn sync(&mut self) -> Result<(), LogError> {
        self.must_work()?;
        if self.synced + 1 < self.next {
            self.disk.sync_data(&self.file).map_err(|error| {
                self.has_failed = true;
                at(&file::name(&self.path, self.segment), error)
            })?;
            self.synced = self.next - 1;
        }
        Ok(())
    }

    /// Makes room for so many bytes of records, so that a disk that fills up later does not keep them from being written.
    ///
    /// # Errors
    /// When the disk has no room, or refuses. What room there is stays.
    pub fn make_room(&mut self, least: u64) -> Result<(), LogError> {
        self.must_work()?;
        self.least_room = least;
        if self.room() >= least {
            return Ok(());
        }
        let missing = least + ROOM_BYTES - self.room();
        let made = self.disk.write(&self.file, &vec![0; usize::try_from(missing).unwrap_or(0)], self.length);
        match made {
            Ok(()) => self.length += missing,
            // Part of it may be there.
            Err(_) => self.length = self.file.metadata().map_or(self.length, |of| of.len().max(self.end)),
        }
        made.map_err(|error| at(&self.name(), error))
    }

    /// Bytes of records that need no more of the disk.
    pub fn room(&self) -> u64 {
        self.length.saturating_sub(self.end)
    }

    /// Finds out whether the disk can be written, by a write into the room, and a sync. Nothing is changed.
    ///
    /// # Errors
    /// When it cannot. After a failed sync the log has failed.
    pub fn probe(&mut self) -> Result<(), LogError> {
        self.must_work()?;
        let bytes = self.room().min(PROBE_BYTES);
        self.disk
            .write(&self.file, &[0; PROBE_BYTES as usize][..bytes as usize], self.end)
            .and_then(|()| {
                let synced = self.disk.sync_data(&self.file);
                self.has_failed = synced.is_err();
                synced
            })
            .map_err(|error| at(&file::name(&self.path, self.segment), error))?;
        self.synced = self.next - 1;
        Ok(())
    }

    /// Goes on with a snapshot in the place of all there is, also after a failure. It is on the disk when this returns.
    ///
    /// # Errors
    /// When the snapshot is too large or the file system refuses. Unless it has failed by that, or had before, the
    /// log before it goes on.
    pub fn begin_anew(&mut self, snapshot: &[u8]) -> Result<(), LogError> {
        // A file that an earlier attempt has left counts as well.
        let segment = file::newest(&self.path)?.unwrap_or(0).max(self.segment) + 1;
        let (number, room) = (self.next, self.least_room);
        let new = NewSegment { segment, number, identity: &self.identity, snapshot: Some(snapshot), room };
        let created = file::create(&self.disk, &self.path, &new);
        // With its name, but perhaps not on the disk: which of the two will be found is unknown.
        self.has_failed |= created.is_err() && file::name(&self.path, segment).exists();
        (self.file, self.end) = created?;
        self.has_failed = false;
        self.length = self.end + room;
        self.segment = segment;
        self.synced = self.next + 1;
        self.next += 2;
        // Whatever cannot be removed now is removed the next time.
        _ = file::tidy(&self.path, segment);
        Ok(())
    }

    /// Whether the content of the file is unknown: [`RecordLog::begin_anew`] alone goes on.
    pub fn has_failed(&self) -> bool {
        self.has_failed
    }

    /// The file that is being written.
    pub fn name(&self) -> PathBuf {
        file::name(&self.path, self.segment)
    }

    /// Its length without the room, in bytes.
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
    /// Of the file.
    length: u64,
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
    let mut opened = Opened { end: 0, length: bytes, next: 0, cut: 0, identity: Vec::new() };
    let (mut position, mut record) = (0_u64, Vec::new());
    while opened.end < bytes {
        let head = match frame::read(file, opened.end, bytes, &mut record).map_err(failed)? {
            FrameFound::Whole(head) if position == 0 || head.number == opened.next => head,
            // The first two were on the disk before the file had its name.
            FrameFound::Whole(_) | FrameFound::Torn if position < 2 => break,
            FrameFound::Whole(_) | FrameFound::Torn => {
                let written = frame::written_until(file, opened.end, bytes).map_err(failed)?;
                if frame::is_counted_on(file, opened.end, written, opened.next).map_err(failed)? {
                    return Err(LogError::Damaged { path: name.to_owned(), offset: opened.end });
                }
                opened.cut = written - opened.end;
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
