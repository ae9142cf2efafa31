//! Memory of a node across a kill of its process: one record, replaced whole.
//!
//! Two slots in one file are written in turn, each with a number and a checksum; on opening, the valid slot with the
//! higher number is the record. A kill in the middle of a write spoils one slot and leaves the other. A write is one
//! system call into the page cache, some microseconds, so a controller can afford it before every output it changes. Where
//! the disk is behind, the call takes as long as the disk; see [`crate::JournalWriter`].
//!
//! That of a station is not flushed to the disk: after a power cut the record may be an older one, or gone. The mechanisms have then
//! moved without their controller, and a person has to look at them anyway. That of the coordinator is
//! ([`Journal::open_synced`]): an operator's command is obeyed for good.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// A slot's size. A record of a station with 64 operations is below 4 KiB.
const SLOT_BYTES: usize = 16 * 1024;
const HEAD_BYTES: usize = 20;
const MAGIC: u32 = 0x4C57_4A31;

/// Why a journal cannot be used.
#[derive(Debug, Error)]
pub enum JournalError {
    /// The file system refuses.
    #[error("cannot use journal {path}: {error}")]
    File {
        path: PathBuf,
        /// The system's reason.
        error: io::Error,
    },
    /// The thread that wrote it has failed.
    #[error("journal {path} cannot be written any more: the thread that wrote it has failed; see the log")]
    Thread { path: PathBuf },
    /// The record does not fit a slot.
    #[error("a record of {bytes} bytes does not fit journal {path}, which holds {most}")]
    TooLarge {
        path: PathBuf,
        /// The record.
        bytes: usize,
        /// The most there may be.
        most: usize,
    },
}

/// A journal.
#[derive(Debug)]
pub struct Journal {
    file: File,
    path: PathBuf,
    number: u64,
    buffer: Vec<u8>,
    /// A record is on the disk when [`Journal::write`] returns.
    is_synced: bool,
}

impl Journal {
    /// Opens or creates the journal at `path`, and gives its record if it holds a whole one.
    ///
    /// # Errors
    /// When the file or its directory cannot be created, read or locked for writing.
    pub fn open(path: &Path) -> Result<(Self, Option<Vec<u8>>), JournalError> {
        let failed = |error| JournalError::File { path: path.to_owned(), error };
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(failed)?;
        }
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(failed)?;
        let mut newest: Option<(u64, Vec<u8>)> = None;
        for slot in 0..2 {
            let mut bytes = vec![0; SLOT_BYTES];
            // A slot that the disk does not give back may have the newest record, an emergency stop: the other is not enough.
            let length = read_up_to(&file, &mut bytes, slot * SLOT_BYTES as u64).map_err(failed)?;
            if let Some((number, record)) = decode(&bytes[..length])
                && newest.as_ref().is_none_or(|(other, _)| number > *other)
            {
                newest = Some((number, record));
            }
        }
        // Room for both slots is taken now: a disk that fills up later does not keep a record from being written.
        let length = file.metadata().map_err(failed)?.len();
        let missing = usize::try_from((2 * SLOT_BYTES as u64).saturating_sub(length)).unwrap_or(0);
        file.write_all_at(&vec![0; missing], length).map_err(failed)?;
        let number = newest.as_ref().map_or(0, |(number, _)| *number);
        let journal =
            Journal { file, path: path.to_owned(), number, buffer: Vec::with_capacity(SLOT_BYTES), is_synced: false };
        Ok((journal, newest.map(|(_, record)| record)))
    }

    /// The same, with records that are on the disk when they are written.
    ///
    /// # Errors
    /// As [`Journal::open`], and when the disk does not take what is there.
    pub fn open_synced(path: &Path) -> Result<(Self, Option<Vec<u8>>), JournalError> {
        let (mut journal, record) = Self::open(path)?;
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        // Its name as well; and a killed process may have left its record in memory.
        let synced = journal.file.sync_all().and_then(|()| File::open(parent)?.sync_all());
        synced.map_err(|error| JournalError::File { path: path.to_owned(), error })?;
        journal.is_synced = true;
        Ok((journal, record))
    }

    /// Replaces the record.
    ///
    /// # Errors
    /// When the record is larger than a slot or cannot be written; the last one that was written is then still there, however often
    /// it is tried.
    pub fn write(&mut self, record: &[u8]) -> Result<(), JournalError> {
        let most = SLOT_BYTES - HEAD_BYTES;
        if record.len() > most {
            return Err(JournalError::TooLarge { path: self.path.clone(), bytes: record.len(), most });
        }
        // A record that failed is written again to the same slot: the other one has the record before it, whole.
        let number = self.number + 1;
        self.buffer.clear();
        self.buffer.extend_from_slice(&MAGIC.to_le_bytes());
        self.buffer.extend_from_slice(&number.to_le_bytes());
        self.buffer.extend_from_slice(&(record.len() as u32).to_le_bytes());
        self.buffer.extend_from_slice(&checksum(number, record).to_le_bytes());
        self.buffer.extend_from_slice(record);
        let offset = (number % 2) * SLOT_BYTES as u64;
        self.file
            .write_all_at(&self.buffer, offset)
            .and_then(|()| if self.is_synced { self.file.sync_data() } else { Ok(()) })
            .map_err(|error| JournalError::File { path: self.path.clone(), error })?;
        self.number = number;
        Ok(())
    }
}

fn checksum(number: u64, record: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&number.to_le_bytes());
    hasher.update(record);
    hasher.finalize()
}

fn read_up_to(file: &File, bytes: &mut [u8], offset: u64) -> io::Result<usize> {
    let mut length = 0;
    while length < bytes.len() {
        match file.read_at(&mut bytes[length..], offset + length as u64) {
            Ok(0) => break,
            Ok(read) => length += read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(length)
}

fn decode(slot: &[u8]) -> Option<(u64, Vec<u8>)> {
    let head = slot.get(..HEAD_BYTES)?;
    let word = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    let number = u64::from(word(4)) | u64::from(word(8)) << 32;
    let record = slot.get(HEAD_BYTES..HEAD_BYTES.checked_add(word(12) as usize)?)?;
    (word(0) == MAGIC && word(16) == checksum(number, record)).then(|| (number, record.to_vec()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scratch(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("linewright-journal-{}-{name}", std::process::id()));
        let _ = std::fs::remove_file(&path);
        path
    }

    #[test]
    fn the_newest_record_is_found_again() {
        let path = scratch("newest");
        let (mut journal, none) = Journal::open(&path).expect("opens");
        assert_eq!(none, None);
        for n in 0..5u8 {
            journal.write(&[n; 7]).expect("writes");
        }
        drop(journal);
        let (mut journal, found) = Journal::open(&path).expect("opens");
        assert_eq!(found, Some(vec![4; 7]));
        journal.write(b"after").expect("writes");
        assert_eq!(Journal::open(&path).expect("opens").1, Some(b"after".to_vec()));
        std::fs::remove_file(&path).expect("removes");
    }

    #[test]
    fn the_room_for_its_records_is_taken_when_it_is_opened() {
        let path = scratch("room");
        let (mut journal, _) = Journal::open(&path).expect("opens");
        let length = || std::fs::metadata(&path).expect("it is there").len();
        assert_eq!(length(), 2 * SLOT_BYTES as u64);
        journal.write(&[7; 5000]).expect("writes");
        assert_eq!(length(), 2 * SLOT_BYTES as u64);
        assert_eq!(Journal::open(&path).expect("opens").1, Some(vec![7; 5000]));
        std::fs::remove_file(&path).expect("removes");
    }

    #[test]
    fn a_write_that_was_cut_short_leaves_the_record_before_it() {
        let path = scratch("torn");
        let (mut journal, _) = Journal::open(&path).expect("opens");
        journal.write(b"first").expect("writes");
        journal.write(b"second").expect("writes");
        // The third goes where the first was; spoil it as a kill in the middle would.
        journal.write(b"third").expect("writes");
        journal.file.write_all_at(b"?", SLOT_BYTES as u64 + HEAD_BYTES as u64 + 2).expect("spoils");
        assert_eq!(Journal::open(&path).expect("opens").1, Some(b"second".to_vec()));
        std::fs::remove_file(&path).expect("removes");
    }

    #[test]
    fn writes_that_fail_again_and_again_leave_the_last_record() {
        let path = scratch("again");
        let (mut journal, _) = Journal::open(&path).expect("opens");
        journal.write(b"first").expect("writes");
        journal.write(b"second").expect("writes");
        let (whole, read_only) = (journal.file, File::open(&path).expect("opens"));
        journal.file = read_only;
        for _ in 0..3 {
            journal.write(b"third").expect_err("it is not open for writing");
        }
        // What a failed write may have left: half a record where the next one goes.
        let next = ((journal.number + 1) % 2) * SLOT_BYTES as u64;
        whole.write_all_at(b"?", next + HEAD_BYTES as u64 + 2).expect("spoils");
        assert_eq!(Journal::open(&path).expect("opens").1, Some(b"second".to_vec()));
        journal.file = whole;
        journal.write(b"fourth").expect("writes");
        assert_eq!(Journal::open(&path).expect("opens").1, Some(b"fourth".to_vec()));
        std::fs::remove_file(&path).expect("removes");
    }

    #[test]
    fn rubbish_is_no_record_and_a_large_record_is_an_error() {
        let path = scratch("rubbish");
        std::fs::write(&path, vec![0xA5; 3 * SLOT_BYTES]).expect("writes");
        let (mut journal, found) = Journal::open(&path).expect("opens");
        assert_eq!(found, None);
        assert!(matches!(journal.write(&vec![0; SLOT_BYTES]), Err(JournalError::TooLarge { .. })));
        std::fs::remove_file(&path).expect("removes");
    }
}
