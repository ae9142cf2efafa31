//! A journal that is written beside the loop: a disk may take its time, and an emergency stop must not wait for it.
//!
//! One record is under way at a time. What must follow a record waits for [`JournalWriter::written`]; meanwhile the loop may take
//! in what must not wait, and turn outputs off.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use tokio::task::JoinHandle;

use crate::journal::{Journal, JournalError};

/// A journal and the record that is being written to it.
#[derive(Debug)]
pub struct JournalWriter {
    path: PathBuf,
    state: WriterState,
    times: RecordTimes,
}

/// How long records took to be written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RecordTimes {
    /// Records written by this writer.
    pub records: u64,
    /// Time of the last one.
    pub last: Duration,
    /// The longest time of one.
    pub longest: Duration,
}

#[derive(Debug)]
enum WriterState {
    Idle(Journal),
    Writing(JoinHandle<(Journal, Duration, Result<(), JournalError>)>),
    /// The thread that wrote has panicked, and the journal is gone with it.
    Lost,
}

impl JournalWriter {
    /// Opens or creates the journal at `path`, and gives its record; see [`Journal::open`].
    ///
    /// # Errors
    /// As [`Journal::open`].
    pub fn open(path: &Path) -> Result<(Self, Option<Vec<u8>>), JournalError> {
        Ok(Self::of(path, Journal::open(path)?))
    }

    /// The same for records that are on the disk when they are written; see [`Journal::open_synced`].
    ///
    /// # Errors
    /// As [`Journal::open_synced`].
    pub fn open_synced(path: &Path) -> Result<(Self, Option<Vec<u8>>), JournalError> {
        Ok(Self::of(path, Journal::open_synced(path)?))
    }

    fn of(path: &Path, (journal, record): (Journal, Option<Vec<u8>>)) -> (Self, Option<Vec<u8>>) {
        (
            JournalWriter { path: path.to_owned(), state: WriterState::Idle(journal), times: RecordTimes::default() },
            record,
        )
    }

    /// How long records took.
    pub fn times(&self) -> RecordTimes {
        self.times
    }

    /// Whether a record is being written.
    pub fn is_writing(&self) -> bool {
        matches!(self.state, WriterState::Writing(_))
    }

    /// Begins to replace the record. While one is being written nothing begins: wait for [`JournalWriter::written`] first.
    /// Must be called within a tokio runtime.
    pub fn begin(&mut self, record: Vec<u8>) {
        self.state = match std::mem::replace(&mut self.state, WriterState::Lost) {
            WriterState::Idle(mut journal) => WriterState::Writing(tokio::task::spawn_blocking(move || {
                let begun = Instant::now();
                let written = journal.write(&record);
                (journal, begun.elapsed(), written)
            })),
            busy => busy,
        };
    }

    /// Waits until the record that is being written, if any, is there. May be given up and called again.
    ///
    /// # Errors
    /// When it cannot be written; the record before it is then still there.
    pub async fn written(&mut self) -> Result<(), JournalError> {
        let ended = match &mut self.state {
            WriterState::Idle(_) => return Ok(()),
            WriterState::Writing(writing) => writing.await.ok(),
            WriterState::Lost => None,
        };
        let Some((journal, took, written)) = ended else {
            self.state = WriterState::Lost;
            return Err(JournalError::Thread { path: self.path.clone() });
        };
        self.state = WriterState::Idle(journal);
        self.times.last = took;
        self.times.longest = self.times.longest.max(took);
        self.times.records += u64::from(written.is_ok());
        written
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_record_is_there_once_it_is_written_and_the_wait_may_be_given_up() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("journal");
        let (mut recorder, none) = JournalWriter::open(&path).expect("it opens");
        assert_eq!(none, None);
        recorder.written().await.expect("nothing to wait for");
        for record in [b"first".to_vec(), b"second".to_vec()] {
            recorder.begin(record);
            assert!(recorder.is_writing());
            recorder.begin(b"it is busy".to_vec());
            let given_up = tokio::time::timeout(Duration::ZERO, recorder.written()).await;
            if given_up.is_err() {
                recorder.written().await.expect("it writes");
            }
            assert!(!recorder.is_writing());
        }
        assert_eq!(Journal::open(&path).expect("it opens").1, Some(b"second".to_vec()));
        let times = recorder.times();
        assert!(times.records == 2 && times.longest >= times.last && !times.last.is_zero(), "{times:?}");
    }

    #[tokio::test]
    async fn a_record_that_does_not_fit_is_an_error_and_the_next_one_is_written() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("journal");
        let (mut recorder, _) = JournalWriter::open(&path).expect("it opens");
        recorder.begin(vec![0; 1 << 20]);
        assert!(matches!(recorder.written().await, Err(JournalError::TooLarge { .. })));
        recorder.begin(b"small".to_vec());
        recorder.written().await.expect("it writes");
        assert_eq!(Journal::open(&path).expect("it opens").1, Some(b"small".to_vec()));
    }
}
