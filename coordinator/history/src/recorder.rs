//! Feeds the database on a thread of its own, so that no decision waits for a disk.
//!
//! Records are offered through a bounded queue, after they are in the cell's log. What finds the queue full is dropped: the
//! thread sees by the numbers that something is missing and reads it from the log ([`RecordSource`]). The same happens when it
//! begins, so a database that is behind for whatever reason (killed, moved away, damaged and replaced) catches up by itself,
//! as far back as the log goes. [`HistoryFeed::newest`] gives how far it is: a log may drop older records.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use linewright_coordinator_cell::Record;
use linewright_line::Tick;

use crate::writer::HistoryItem;
use crate::{History, HistoryError, Note};

/// Batches that can wait. A step of the player is one.
const QUEUE: usize = 1024;
/// Records or notes written at once.
const BATCH: usize = 1000;
/// Notes kept while the queue is full; then the oldest are lost.
const NOTES_MAX: usize = 1000;

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
enum FeedQueue {
    Records(u64, Vec<Record>),
    Note(Tick, Note),
}

/// State shared by both sides.
#[derive(Debug, Default)]
struct FeedState {
    /// The newest record that the database has.
    newest: AtomicU64,
    /// The newest that the log has.
    written: AtomicU64,
    /// Reason why the thread has given up.
    failed: Mutex<Option<String>>,
}

impl FeedState {
    /// Keeps why the thread has given up, if it has.
    fn noting<T>(&self, fed: Result<T, HistoryError>) -> Result<T, HistoryError> {
        if let Err(error) = &fed
            && let Ok(mut failed) = self.failed.lock()
        {
            *failed = Some(error.to_string());
        }
        fed
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
    /// removed, since a power cut has taken them from the log before anything was sent about them.
    pub fn start(history: History, source: Box<dyn RecordSource>, last: u64) -> Self {
        Self::with_queue(history, source, last, QUEUE)
    }

    /// The same with room for so many batches.
    pub fn with_queue(history: History, source: Box<dyn RecordSource>, last: u64, queue: usize) -> Self {
        let (sender, receiver) = sync_channel(queue);
        let shared = Arc::new(FeedState::default());
        shared.written.store(last, Ordering::Release);
        let feeding = Feeding { history, source, shared: shared.clone(), shift: Shift::None };
        let thread = std::thread::spawn(move || {
            let shared = feeding.shared.clone();
            shared.noting(feeding.feed(last, &receiver))
        });
        HistoryFeed { queue: Some(sender), notes: VecDeque::new(), shared, thread: Some(thread) }
    }

    /// Begins without a log, for notes alone. Opening the database is left to the thread as well. Where the newest in it is
    /// later than the first note, as after a clock was set back, all notes are as much later.
    pub fn of_notes(open: impl FnOnce() -> Result<History, HistoryError> + Send + 'static) -> Self {
        let (sender, receiver) = sync_channel(QUEUE);
        let shared = Arc::new(FeedState::default());
        let its = shared.clone();
        let thread = std::thread::spawn(move || {
            its.noting(open().and_then(|history| {
                let shift = history.last()?.map_or(Shift::None, Shift::After);
                Feeding { history, source: Box::new(NoRecords), shared: its.clone(), shift }.feed(0, &receiver)
            }))
        });
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

    /// Reason why nothing is written any more; none while it is. The cell goes on without it.
    pub fn failed(&self) -> Option<String> {
        // In this order: a thread that gives up sets the reason before it ends.
        let has_ended = self.thread.as_ref().is_some_and(JoinHandle::is_finished);
        let why = self.shared.failed.lock().ok().and_then(|failed| failed.clone());
        why.or_else(|| has_ended.then(|| "the thread that writes the database has ended".to_owned()))
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

/// The thread.
struct Feeding {
    history: History,
    source: Box<dyn RecordSource>,
    shared: Arc<FeedState>,
    shift: Shift,
}

/// Correction of the time of notes.
#[derive(Clone, Copy, Debug)]
enum Shift {
    None,
    /// So that the first is not before this.
    After(Tick),
    By(Duration),
}

impl Feeding {
    /// Feeds until nothing more is offered.
    fn feed(mut self, last: u64, queue: &Receiver<FeedQueue>) -> Result<History, HistoryError> {
        self.begin(last)?;
        self.go_on(queue)?;
        Ok(self.history)
    }

    fn shifted(&mut self, at: Tick, note: Note) -> HistoryItem {
        if let Shift::After(last) = self.shift {
            self.shift = Shift::By(last.since(at));
        }
        match self.shift {
            Shift::By(by) => HistoryItem::Note(at + by, note.later(by)),
            Shift::None | Shift::After(_) => HistoryItem::Note(at, note),
        }
    }

    /// Compares with the log, takes missing records, and removes those that the log has lost.
    fn begin(&mut self, last: u64) -> Result<(), HistoryError> {
        // What is behind that is of this life, and may stand under numbers that the database has from one before.
        self.catch_up(0, last)?;
        if self.history.newest() > last {
            self.history.forget_after(last)?;
        }
        self.tell();
        Ok(())
    }

    fn tell(&self) {
        self.shared.newest.store(self.history.newest(), Ordering::Release);
    }

    fn go_on(&mut self, queue: &Receiver<FeedQueue>) -> Result<(), HistoryError> {
        let mut items = Vec::new();
        while let Ok(first) = queue.recv() {
            let mut next = Some(first);
            while let Some(what) = next {
                self.take(what, &mut items)?;
                next = if items.len() < BATCH { queue.try_recv().ok() } else { None };
            }
            let is_drained = items.len() < BATCH;
            self.write(&mut items)?;
            // What was dropped last is followed by nothing that would show it.
            if is_drained {
                self.complete()?;
            }
        }
        self.complete()
    }

    /// Takes from the log records that were offered and have not come.
    fn complete(&mut self) -> Result<(), HistoryError> {
        let newest = self.history.newest();
        if self.shared.written.load(Ordering::Acquire) > newest { self.catch_up(newest, u64::MAX) } else { Ok(()) }
    }

    fn take(&mut self, what: FeedQueue, items: &mut Vec<HistoryItem>) -> Result<(), HistoryError> {
        match what {
            FeedQueue::Note(at, note) => items.push(self.shifted(at, note)),
            FeedQueue::Records(first, records) => {
                let newest = items.iter().map(HistoryItem::number).max().unwrap_or(0).max(self.history.newest());
                if first > newest + 1 {
                    self.write(items)?;
                    self.catch_up(self.history.newest(), u64::MAX)?;
                }
                items.extend((first..).zip(records).map(|(number, record)| HistoryItem::Record(number, record)));
            }
        }
        Ok(())
    }

    fn write(&mut self, items: &mut Vec<HistoryItem>) -> Result<(), HistoryError> {
        self.history.put(items)?;
        items.clear();
        self.tell();
        Ok(())
    }

    /// Takes from the log the records after a number, until another.
    fn catch_up(&mut self, after: u64, until: u64) -> Result<(), HistoryError> {
        let Feeding { history, source, .. } = self;
        let (mut items, mut put) = (Vec::new(), Ok(()));
        let read = source.read(&mut |number, record| {
            if number <= after || number > until || put.is_err() {
                return;
            }
            let newest = items.last().map_or(0, HistoryItem::number).max(history.newest());
            if number > newest + 1 {
                items.push(HistoryItem::Note(record.at, Note::Missing { from: newest + 1, to: number - 1 }));
            }
            items.push(HistoryItem::Record(number, record));
            if items.len() >= BATCH {
                put = history.put(&items);
                items.clear();
            }
        });
        put?;
        read.map_err(|why| HistoryError::Source { path: self.history.path().to_owned(), why })?;
        self.write(&mut items)
    }
}
