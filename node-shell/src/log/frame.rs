//! Form of a record in a file: behind a head with its length, its number, the number of records on the disk when it was
//! written, and a checksum over all of that and the record.
//!
//! Numbers rise by one over the whole life of a log, so a frame that an older file has left in a block of the disk is not
//! taken for one of this.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;

/// Bytes before a record.
pub(super) const HEAD_BYTES: u64 = 32;
/// The most bytes that a record may have.
pub const RECORD_BYTES_MAX: usize = 16 << 20;

const MAGIC: [u8; 4] = *b"LWL1";
/// Numbers do not come near this, so counting them on never fails.
const NUMBER_MAX: u64 = 1 << 62;
/// When a damaged place is looked at, so many bytes are read at a time,
const WINDOW_BYTES: usize = 64 * 1024;
/// and so many are summed up at most. Only files made for the purpose need more.
const SUMMED_BYTES_MAX: u64 = 256 << 20;

/// Fields of a frame beside its record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Head {
    /// One more than the frame before.
    pub number: u64,
    /// The newest frame that was on the disk for sure when this was written.
    pub synced: u64,
}

/// Content of a file at a position.
pub(super) enum FrameFound {
    Whole(Head),
    /// Anything else.
    Torn,
}

/// Appends a frame to a buffer, unless the record is too large.
///
/// # Errors
/// Its length, in bytes.
pub(super) fn encode(buffer: &mut Vec<u8>, head: &Head, record: &[u8]) -> Result<(), usize> {
    if record.len() > RECORD_BYTES_MAX {
        return Err(record.len());
    }
    buffer.extend_from_slice(&MAGIC);
    // The most there may be fits.
    buffer.extend_from_slice(&(record.len() as u32).to_le_bytes());
    buffer.extend_from_slice(&head.number.to_le_bytes());
    buffer.extend_from_slice(&head.synced.to_le_bytes());
    buffer.extend_from_slice(&[0; 4]);
    let sum = checksum(record.len() as u32, head, record);
    buffer.extend_from_slice(&sum.to_le_bytes());
    buffer.extend_from_slice(record);
    Ok(())
}

fn checksum(length: u32, head: &Head, record: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&length.to_le_bytes());
    hasher.update(&head.number.to_le_bytes());
    hasher.update(&head.synced.to_le_bytes());
    hasher.update(record);
    hasher.finalize()
}

/// Reads the frame at a place of a file of so many bytes; its record goes to `record`.
pub(super) fn read(file: &File, at: u64, bytes: u64, record: &mut Vec<u8>) -> io::Result<FrameFound> {
    record.clear();
    let Some(room) = bytes.checked_sub(at).and_then(|rest| rest.checked_sub(HEAD_BYTES)) else {
        return Ok(FrameFound::Torn);
    };
    let mut head = [0; HEAD_BYTES as usize];
    file.read_exact_at(&mut head, at)?;
    let word = |from: usize| u32::from_le_bytes([head[from], head[from + 1], head[from + 2], head[from + 3]]);
    let long = |from: usize| u64::from(word(from)) | u64::from(word(from + 4)) << 32;
    let length = word(4);
    if head[..4] != MAGIC || word(24) != 0 || length as usize > RECORD_BYTES_MAX || u64::from(length) > room {
        return Ok(FrameFound::Torn);
    }
    record.resize(length as usize, 0);
    file.read_exact_at(record, at + HEAD_BYTES)?;
    let found = Head { number: long(8), synced: long(16) };
    let is_whole = found.number < NUMBER_MAX && word(28) == checksum(length, &found, record);
    Ok(if is_whole { FrameFound::Whole(found) } else { FrameFound::Torn })
}

/// The end of what is not zero from `at` on: what is behind it was never written.
pub(super) fn written_until(file: &File, at: u64, bytes: u64) -> io::Result<u64> {
    let (mut window, mut from, mut until) = (vec![0; WINDOW_BYTES], at, at);
    while from < bytes {
        let length = (bytes - from).min(WINDOW_BYTES as u64) as usize;
        file.read_exact_at(&mut window[..length], from)?;
        if let Some(last) = window[..length].iter().rposition(|&byte| byte != 0) {
            until = from + last as u64 + 1;
        }
        from += length as u64;
    }
    Ok(until)
}

/// Whether a frame from `at` on shows that frame `number`, which is missing there, was on the disk.
pub(super) fn is_counted_on(file: &File, at: u64, bytes: u64, number: u64) -> io::Result<bool> {
    let (mut window, mut record, mut summed) = (vec![0; WINDOW_BYTES], Vec::new(), 0);
    let mut from = at;
    while from + HEAD_BYTES <= bytes {
        // The last bytes of a window are the first of the next.
        let length = (bytes - from).min(WINDOW_BYTES as u64) as usize;
        file.read_exact_at(&mut window[..length], from)?;
        for (offset, four) in window[..length].windows(MAGIC.len()).enumerate() {
            if four != MAGIC {
                continue;
            }
            let found = read(file, from + offset as u64, bytes, &mut record)?;
            summed += HEAD_BYTES + record.len() as u64;
            match found {
                FrameFound::Whole(head) if head.number > number && head.synced >= number => return Ok(true),
                FrameFound::Whole(_) | FrameFound::Torn => (),
            }
            if summed > SUMMED_BYTES_MAX {
                return Ok(true);
            }
        }
        if length < WINDOW_BYTES {
            break;
        }
        from += (WINDOW_BYTES - MAGIC.len() + 1) as u64;
    }
    Ok(false)
}
