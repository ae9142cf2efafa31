//! An outage of the database: when writing is tried again, and what is lost meanwhile.
//!
//! Pure: times of trials are those of the caller's clock, times of what is lost those of the notes.

use std::time::Duration;

use linewright_line::Tick;

use crate::Note;

/// First wait after a failure.
const WAIT_MIN: Duration = Duration::from_secs(1);
/// Longest wait between two trials.
const WAIT_MAX: Duration = Duration::from_secs(30);
/// A failure sooner than this after an outage continues it: waits go on growing.
const RELAPSE: Duration = Duration::from_secs(60);

/// Notes that could not be written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LostNotes {
    pub count: u64,
    /// Times of the first and the last of them.
    pub span: Option<(Tick, Tick)>,
}

impl LostNotes {
    pub fn add(&mut self, at: Tick) {
        self.merge(LostNotes { count: 1, span: Some((at, at)) });
    }

    pub fn merge(&mut self, more: LostNotes) {
        self.count = self.count.saturating_add(more.count);
        self.span = match (self.span, more.span) {
            (Some((a, b)), Some((c, d))) => Some((a.min(c), b.max(d))),
            (one, other) => one.or(other),
        };
    }

    /// Time and note of the gap they leave; none if none is lost.
    pub fn gap(&self) -> Option<(Tick, Note)> {
        self.span.map(|(from, to)| (to, Note::Gap { from, to, lost: self.count }))
    }
}

/// Outages, one after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outages {
    /// Time of the next trial; none while the database is written.
    due: Option<Tick>,
    /// The last wait, and when the last outage ended.
    before: Option<(Duration, Tick)>,
    wait: Duration,
    lost: LostNotes,
}

impl Outages {
    pub fn is_on(&self) -> bool {
        self.due.is_some()
    }

    /// Time until the next trial; none while there is no outage.
    pub fn left(&self, now: Tick) -> Option<Duration> {
        self.due.map(|due| due.since(now))
    }

    /// Writing has failed. True if that begins an outage.
    pub fn failed(&mut self, now: Tick) -> bool {
        let begins = !self.is_on();
        self.wait = match self.before {
            _ if !begins => self.wait * 2,
            Some((wait, ended)) if now.since(ended) < RELAPSE => wait * 2,
            Some(_) | None => WAIT_MIN,
        };
        self.wait = self.wait.min(WAIT_MAX);
        self.due = Some(now + self.wait);
        begins
    }

    /// What is lost belongs to the outage that goes on, or to the next.
    pub fn lose(&mut self, lost: LostNotes) {
        self.lost.merge(lost);
    }

    pub fn lost(&self) -> LostNotes {
        self.lost
    }

    /// Everything is written again; what was lost meanwhile. None if there was no outage.
    pub fn end(&mut self, now: Tick) -> Option<LostNotes> {
        self.due.take().map(|_| {
            self.before = Some((self.wait, now));
            std::mem::take(&mut self.lost)
        })
    }
}
