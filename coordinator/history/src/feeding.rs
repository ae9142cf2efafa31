//! The thread that feeds a database.
//!
//! ```text
//!   written ── failure ──▶ outage: what is offered is counted and dropped
//!      ▲                     │  after 1 s, 2 s, … 30 s
//!      └── gap noted ◀───────┘  opened anew; records of a log are caught up from there
//! ```
//!
//! A damaged file is renamed and a new one begun; a file that was replaced is opened again. Neither is an outage if it
//! succeeds at once.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant, SystemTime};

use linewright_line::Tick;

use crate::news::HistoryNews;
use crate::outage::{LostNotes, Outages};
use crate::recorder::{FeedQueue, FeedState, RecordSource};
use crate::set_aside::set_aside;
use crate::writer::HistoryItem;
use crate::{History, HistoryError, Note};

/// Records or notes written at once.
const BATCH: usize = 1000;

/// Opens the database, again after each failure.
pub type OpenHistory = Box<dyn FnMut() -> Result<History, HistoryError> + Send>;

/// Correction of the time of notes.
#[derive(Clone, Copy, Debug)]
enum Shift {
    None,
    /// So that the first is not before this.
    After(Tick),
    By(Duration),
}

/// The thread.
pub struct Feeding {
    open: OpenHistory,
    /// None during an outage.
    history: Option<History>,
    source: Box<dyn RecordSource>,
    shared: Arc<FeedState>,
    shift: Shift,
    /// Whether notes are shifted to come after what is there: there is no log whose records have their own times.
    shifts: bool,
    /// The number of the newest record of the log when this life began, until the database is compared with the log.
    begins: Option<u64>,
    outages: Outages,
    /// Another program has replaced the file, or cut it off.
    is_suspect: bool,
    /// Notes taken and not yet written.
    pending: LostNotes,
    began: Instant,
}

impl Feeding {
    /// With a log, whose newest record is `last`.
    pub fn of_log(open: OpenHistory, source: Box<dyn RecordSource>, last: u64, shared: Arc<FeedState>) -> Self {
        let (shift, outages, pending) = (Shift::None, Outages::default(), LostNotes::default());
        let (shifts, begins, is_suspect, began) = (false, Some(last), false, Instant::now());
        Feeding { open, history: None, source, shared, shift, shifts, begins, outages, is_suspect, pending, began }
    }

    /// Without a log.
    pub fn of_notes(open: OpenHistory, source: Box<dyn RecordSource>, shared: Arc<FeedState>) -> Self {
        Feeding { shifts: true, begins: None, ..Self::of_log(open, source, 0, shared) }
    }

    /// Feeds until nothing more is offered.
    ///
    /// # Errors
    /// Why not everything is in the database at the end.
    pub fn run(mut self, queue: &Receiver<FeedQueue>) -> Result<History, HistoryError> {
        self.try_open();
        let mut items = Vec::new();
        loop {
            let first = match self.outages.left(self.now()) {
                None => queue.recv().map_err(RecvTimeoutError::from),
                Some(Duration::ZERO) => {
                    self.try_open();
                    continue;
                }
                Some(left) => queue.recv_timeout(left),
            };
            match first {
                Ok(first) if self.outages.is_on() => self.drop_offered(first),
                Ok(first) => {
                    let fed = self.feed(first, queue, &mut items);
                    self.settle(fed, &mut items);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        if self.outages.is_on() {
            self.open_again()?;
        }
        self.complete().inspect_err(|error| self.shared.fail(error))?;
        self.history.ok_or_else(|| HistoryError::Refused { path: PathBuf::new(), why: "it is closed".to_owned() })
    }

    fn now(&self) -> Tick {
        Tick::ZERO + self.began.elapsed()
    }

    fn try_open(&mut self) {
        let opened = self.open_again();
        self.settle(opened, &mut Vec::new());
    }

    /// After a failure the outage begins, or goes on.
    fn settle(&mut self, fed: Result<(), HistoryError>, items: &mut Vec<HistoryItem>) {
        let Err(error) = fed else { return };
        items.clear();
        self.outages.lose(std::mem::take(&mut self.pending));
        self.abandon();
        // Where that fails too, its reason is the one to be mended.
        let error = if error.is_damage() { self.set_aside(&error).err().unwrap_or(error) } else { error };
        if self.outages.failed(self.now()) {
            let (why, remedy) = (error.to_string(), error.remedy());
            self.shared.report(HistoryNews::Failed { why, remedy });
        }
        self.shared.fail(&error);
    }

    /// During an outage. Records of a log are taken from there when it is over.
    fn drop_offered(&mut self, what: FeedQueue) {
        if let FeedQueue::Note(at, _) = what {
            let mut lost = LostNotes::default();
            lost.add(at);
            self.outages.lose(lost);
        }
    }

    /// Takes what is offered, as far as it goes into one batch, and writes it.
    fn feed(
        &mut self,
        first: FeedQueue,
        queue: &Receiver<FeedQueue>,
        items: &mut Vec<HistoryItem>,
    ) -> Result<(), HistoryError> {
        let mut next = Some(first);
        while let Some(what) = next {
            self.take(what, items)?;
            next = if items.len() < BATCH { queue.try_recv().ok() } else { None };
        }
        let (is_drained, written) = (items.len() < BATCH, items.len());
        self.write(items)?;
        if let Some(history) = &mut self.history {
            history.remove_old(written)?;
        }
        // What was dropped last is followed by nothing that would show it.
        if is_drained { self.complete() } else { Ok(()) }
    }

    fn take(&mut self, what: FeedQueue, items: &mut Vec<HistoryItem>) -> Result<(), HistoryError> {
        match what {
            FeedQueue::Note(at, note) => {
                self.pending.add(at);
                items.push(self.shifted(at, note));
            }
            FeedQueue::Records(first, records) => {
                let newest = items.iter().map(HistoryItem::number).max().unwrap_or(0).max(self.newest());
                if first > newest + 1 {
                    self.write(items)?;
                    self.catch_up(self.newest(), u64::MAX)?;
                }
                items.extend((first..).zip(records).map(|(number, record)| HistoryItem::Record(number, record)));
            }
        }
        Ok(())
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

    fn newest(&self) -> u64 {
        self.history.as_ref().map_or(0, History::newest)
    }

    /// Opens the database unless it is open, compares it with the log, and notes the gap of an outage.
    fn open_again(&mut self) -> Result<(), HistoryError> {
        if self.history.is_none() {
            let opened = match self.open_checked() {
                Err(error) if error.is_damage() => {
                    self.set_aside(&error)?;
                    (self.open)()
                }
                opened => opened,
            };
            let history = opened?;
            if self.shifts {
                self.shift = history.last()?.map_or(Shift::None, Shift::After);
            }
            self.history = Some(history);
        }
        if let Some(last) = self.begins {
            self.begin(last)?;
        }
        self.complete()?;
        let lost = self.outages.lost();
        if let Some((at, gap)) = lost.gap() {
            let gap = self.shifted(at, gap);
            self.put(&[gap])?;
        }
        if let Some(lost) = self.outages.end(self.now()) {
            let path = self.history.as_ref().map_or_else(PathBuf::new, |history| history.path().to_owned());
            self.shared.report(HistoryNews::Resumed { path, lost });
            self.shared.resume();
        }
        Ok(())
    }

    /// Opens it. A file that another program has touched is checked as a whole.
    fn open_checked(&mut self) -> Result<History, HistoryError> {
        let history = (self.open)()?;
        if std::mem::take(&mut self.is_suspect) {
            history.check()?;
        }
        Ok(history)
    }

    /// Compares with the log, takes missing records, and removes those that the log has lost.
    fn begin(&mut self, last: u64) -> Result<(), HistoryError> {
        // What is behind that is of this life, and may stand under numbers that the database has from one before.
        self.catch_up(0, last)?;
        if let Some(history) = self.history.as_mut().filter(|history| history.newest() > last) {
            history.forget_after(last)?;
        }
        self.begins = None;
        self.publish_newest();
        Ok(())
    }

    /// Until the database was compared with the log, what it has beyond that is of a life before: a log that is cut off on that
    /// would lose records of this one.
    fn publish_newest(&self) {
        let newest = self.begins.map_or(self.newest(), |last| self.newest().min(last));
        self.shared.newest.store(newest, Ordering::Release);
    }

    /// Takes from the log records that were offered and have not come.
    fn complete(&mut self) -> Result<(), HistoryError> {
        let newest = self.newest();
        if self.shared.written.load(Ordering::Acquire) > newest { self.catch_up(newest, u64::MAX) } else { Ok(()) }
    }

    /// Writes a batch; into another file, if that which was open is damaged or was replaced.
    fn write(&mut self, items: &mut Vec<HistoryItem>) -> Result<(), HistoryError> {
        match self.put(items) {
            Err(error) if error.is_damage() || matches!(error, HistoryError::Replaced { .. }) => {
                self.abandon();
                if error.is_damage() {
                    self.set_aside(&error)?;
                } else {
                    self.shared.report(HistoryNews::Replaced { path: error.path().to_owned() });
                    self.is_suspect = true;
                }
                self.open_again()?;
                self.put(items)?;
                self.shared.resume();
            }
            put => put?,
        }
        items.clear();
        self.pending = LostNotes::default();
        Ok(())
    }

    fn put(&mut self, items: &[HistoryItem]) -> Result<(), HistoryError> {
        if let Some(history) = self.history.as_mut().filter(|_| !items.is_empty()) {
            history.put(items)?;
        }
        self.publish_newest();
        Ok(())
    }

    fn abandon(&mut self) {
        self.history.take().into_iter().for_each(History::abandon);
    }

    /// Renames a damaged database, with what belongs to it.
    fn set_aside(&mut self, error: &HistoryError) -> Result<(), HistoryError> {
        let kept = set_aside(error.path(), SystemTime::now())?;
        self.shared.report(HistoryNews::SetAside { why: error.to_string(), kept });
        Ok(())
    }

    /// Takes from the log the records after a number, until another.
    fn catch_up(&mut self, after: u64, until: u64) -> Result<(), HistoryError> {
        let Feeding { history: Some(history), source, .. } = self else { return Ok(()) };
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
        read.map_err(|why| HistoryError::Source { path: history.path().to_owned(), why })?;
        self.put(&items)
    }
}
