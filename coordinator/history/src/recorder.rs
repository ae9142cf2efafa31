//! Feeds the database on a thread of its own ([`Feeding`]), so that no decision waits for a disk.
//!
//! Records are offered through a bounded queue, after they are in the cell's log. What finds the queue full is dropped: the
//! thread sees by the numbers that something is missing and reads it from the log ([`RecordSource`]). The same happens when it
//! begins, so a database that is behind for whatever reason (killed, moved away, damaged and replaced) catches up by itself,
//! as far back as the log goes. [`HistoryFeed::newest`] gives how far it is: a log may drop older records.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use linewright_coordinator_cell::Record;
use linewright_line::Tick;

use crate::feeding::Feeding;
use crate::news::HistoryNews;
use crate::{History, HistoryError, Note};

/// Batches that can wait. A step of the player is one.
const QUEUE: usize = 1024;
/// Notes kept while the queue is full; then the oldest are lost.
const NOTES_MAX: usize = 1000;
/// News kept until they are taken; then the oldest are lost.
const NEWS_MAX: usize = 16;

/// Period of the check whether the thread has ended.
const POLL: Duration = Duration::from_millis(10);

/// The log, for readers beside its writer.
pub trait RecordSource: Send {
    /// Gives `take` every record that the log has, with its number, in their order, as far as they are written. It may begin
    /// later than with the first: the log no longer has those before.
    ///
    /// # Errors
    /// Reason, in words.
    fn read(&mut self, take: &mut dyn FnMut(u64, Record)) -> Result<(), String>;
}

/// No log: there are notes alone.
struct NoRecords;

impl RecordSource for NoRecords {
    fn read(&mut self, _: &mut dyn FnMut(u64, Record)) -> Result<(), String> {
        Ok(())
    }
}

/// Items that wait to be written.
pub(crate) enum FeedQueue {
    Records(u64, Vec<Record>),
    Note(Tick, Note),
}

/// State shared by both sides.
#[derive(Debug, Default)]
pub(crate) struct FeedState {
    /// The newest record that the database has.
    pub newest: AtomicU64,
    /// The newest that the log has.
    pub written: AtomicU64,
    /// Number of times that writing was resumed, after an outage or into another file.
    resumed: AtomicU64,
    is_failing: AtomicBool,
    /// Reason why nothing is written now.
    failed: Mutex<Option<String>>,
    news: Mutex<VecDeque<HistoryNews>>,
}

impl FeedState {
    /// Keeps the reason why nothing can be written.
    pub fn fail(&self, error: &HistoryError) {
        if let Ok(mut failed) = self.failed.lock() {
            *failed = Some(error.to_string());
        }
        self.is_failing.store(true, Ordering::Release);
    }

    /// Notes that writing was resumed, after an outage or into another file.
    pub fn resume(&self) {
        if let Ok(mut failed) = self.failed.lock() {
            *failed = None;
        }
        self.is_failing.store(false, Ordering::Release);
        self.resumed.fetch_add(1, Ordering::AcqRel);
    }

    pub fn report(&self, of: HistoryNews) {
        let Ok(mut news) = self.news.lock() else { return };
        if news.len() >= NEWS_MAX {
            news.pop_front();
        }
        news.push_back(of);
    }
}

/// Feeds a database.
#[derive(Debug)]
pub struct HistoryFeed {
    queue: Option<SyncSender<FeedQueue>>,
    notes: VecDeque<(Tick, Note)>,
    shared: Arc<FeedState>,
    thread: Option<JoinHandle<Result<History, HistoryError>>>,
}

impl HistoryFeed {
    /// Begins, with what the log has: `last` is the number of its newest record. Records of the database beyond that are
    /// removed, since a power cut has taken them from the log before anything was sent about them. The database is opened
    /// on the thread, and again after each failure.
    pub fn of_log(
        open: impl FnMut() -> Result<History, HistoryError> + Send + 'static,
        source: Box<dyn RecordSource>,
        last: u64,
    ) -> Self {
        Self::with_queue(open, source, last, QUEUE)
    }

    /// As [`HistoryFeed::of_log`], with room for `queue` batches.
    pub fn with_queue(
        open: impl FnMut() -> Result<History, HistoryError> + Send + 'static,
        source: Box<dyn RecordSource>,
        last: u64,
        queue: usize,
    ) -> Self {
        Self::on_thread(queue, |shared| {
            shared.written.store(last, Ordering::Release);
            Feeding::of_log(Box::new(open), source, last, shared)
        })
    }

    /// Begins without a log, for notes alone. Opening the database is left to the thread as well, also after each failure.
    /// Where the newest in it is later than the first note, as after a clock was set back, all notes are as much later.
    pub fn of_notes(open: impl FnMut() -> Result<History, HistoryError> + Send + 'static) -> Self {
        Self::on_thread(QUEUE, |shared| Feeding::of_notes(Box::new(open), Box::new(NoRecords), shared))
    }

    fn on_thread(queue: usize, feeding: impl FnOnce(Arc<FeedState>) -> Feeding) -> Self {
        let (sender, receiver) = sync_channel(queue);
        let shared = Arc::new(FeedState::default());
        let feeding = feeding(shared.clone());
        let thread = std::thread::spawn(move || feeding.run(&receiver));
        HistoryFeed { queue: Some(sender), notes: VecDeque::new(), shared, thread: Some(thread) }
    }

    /// Offers records that are in the log, numbered from `first` on. It never waits.
    pub fn offer(&mut self, first: u64, records: &[Record]) {
        let Some(last) = (first + records.len() as u64).checked_sub(1).filter(|_| !records.is_empty()) else { return };
        self.shared.written.fetch_max(last, Ordering::AcqRel);
        self.flush();
        // A full queue is caught up from the log.
        _ = self.send(FeedQueue::Records(first, records.to_vec()));
    }

    /// Offers a note. It never waits.
    pub fn note(&mut self, at: Tick, note: Note) {
        if self.notes.len() >= NOTES_MAX {
            self.notes.pop_front();
        }
        self.notes.push_back((at, note));
        self.flush();
    }

    /// Offers a note, unless there is no room for it; whether there was. It never waits.
    pub fn offer_note(&mut self, at: Tick, note: Note) -> bool {
        self.flush();
        let has_room = self.notes.len() < NOTES_MAX;
        if has_room {
            self.notes.push_back((at, note));
            self.flush();
        }
        has_room
    }

    /// Waits for all that was offered to be written, but not longer than so; the rest may be lost.
    pub fn end_within(mut self, long: Duration) {
        self.flush();
        self.queue = None;
        let Some(thread) = self.thread.take() else { return };
        let steps = long.as_millis() / POLL.as_millis();
        for _ in 0..steps {
            if thread.is_finished() {
                break;
            }
            std::thread::sleep(POLL);
        }
    }

    fn flush(&mut self) {
        while let Some((at, note)) = self.notes.pop_front() {
            if let Err(FeedQueue::Note(at, note)) = self.send(FeedQueue::Note(at, note)) {
                self.notes.push_front((at, note));
                return;
            }
        }
    }

    fn send(&self, what: FeedQueue) -> Result<(), FeedQueue> {
        match self.queue.as_ref().map(|queue| queue.try_send(what)) {
            Some(Err(TrySendError::Full(what) | TrySendError::Disconnected(what))) => Err(what),
            Some(Ok(())) | None => Ok(()),
        }
    }

    /// The newest record that the database has, and all before it as far back as the log went.
    pub fn newest(&self) -> u64 {
        self.shared.newest.load(Ordering::Acquire)
    }

    /// Reason why nothing is written now; none while it is. It is tried again, and the cell goes on meanwhile.
    pub fn failed(&self) -> Option<String> {
        let why = self.shared.failed.lock().ok().and_then(|failed| failed.clone());
        why.or_else(|| self.has_ended().then(|| "the thread that writes the database has ended".to_owned()))
    }

    /// Whether nothing is written now.
    pub fn is_failing(&self) -> bool {
        self.shared.is_failing.load(Ordering::Acquire) || self.has_ended()
    }

    /// Whether nothing will be written any more: a bug has ended the thread.
    pub fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// A number that changes when notes may have been lost, or another file begun, and notes are written again.
    pub fn resumed(&self) -> u64 {
        self.shared.resumed.load(Ordering::Acquire)
    }

    /// The oldest news not yet taken.
    pub fn news(&self) -> Option<HistoryNews> {
        self.shared.news.lock().ok()?.pop_front()
    }

    /// Returns when all that was offered is in the database.
    ///
    /// # Errors
    /// Reason why it is not.
    pub fn close(mut self) -> Result<History, HistoryError> {
        for (at, note) in std::mem::take(&mut self.notes) {
            // At the end there is time to wait; a thread that has given up is reported below.
            _ = self.queue.as_ref().map(|queue| queue.send(FeedQueue::Note(at, note)));
        }
        self.queue = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(history)) => history,
            // It has panicked, which is a bug; the caller panics too.
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            // Not before, since closing takes the recorder.
            None => Err(HistoryError::Refused { path: PathBuf::new(), why: "it is closed".to_owned() }),
        }
    }
}

impl Drop for HistoryFeed {
    /// Waits as well: a drop by mistake loses nothing.
    fn drop(&mut self) {
        self.queue = None;
        _ = self.thread.take().map(JoinHandle::join);
    }
}
