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
    pub(crate) fn add(&mut self, at: Tick) {
        self.merge(LostNotes { count: 1, span: Some((at, at)) });
    }

    pub(crate) fn merge(&mut self, more: LostNotes) {
        self.count = self.count.saturating_add(more.count);
        self.span = match (self.span, more.span) {
            (Some((a, b)), Some((c, d))) => Some((a.min(c), b.max(d))),
            (one, other) => one.or(other),
        };
    }

    /// Time and note of the gap they leave; none if none is lost.
    pub(crate) fn gap(&self) -> Option<(Tick, Note)> {
        self.span.map(|(from, to)| (to, Note::Gap { from, to, lost: self.count }))
    }
}

/// Outages, one after the other.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outages {
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

#[cfg(test)]
mod tests {
    use super::*;

    const AT: fn(u64) -> Tick = |seconds| Tick::from_millis(seconds * 1000);
    const S: fn(u64) -> Duration = Duration::from_secs;

    #[test]
    fn waits_double_up_to_half_a_minute_and_one_failure_begins_it() {
        let mut outages = Outages::default();
        assert_eq!((outages.is_on(), outages.left(AT(0))), (false, None));
        let mut now = AT(100);
        assert!(outages.failed(now), "it begins");
        let mut waits = Vec::new();
        for _ in 0..8 {
            let left = outages.left(now).expect("an outage");
            waits.push(left.as_secs());
            assert_eq!(outages.left(now + left * 2), Some(Duration::ZERO));
            now = now + left;
            assert!(!outages.failed(now), "it goes on");
        }
        assert_eq!(waits, [1, 2, 4, 8, 16, 30, 30, 30]);
    }

    #[test]
    fn a_relapse_goes_on_with_longer_waits_and_a_later_outage_begins_anew() {
        let mut outages = Outages::default();
        outages.failed(AT(0));
        outages.failed(AT(1));
        assert_eq!(outages.end(AT(3)), Some(LostNotes::default()));
        assert_eq!(outages.end(AT(3)), None);
        assert!(outages.failed(AT(62)), "another outage");
        assert_eq!(outages.left(AT(62)), Some(S(4)));
        outages.end(AT(70));
        outages.failed(AT(130));
        assert_eq!(outages.left(AT(130)), Some(S(1)));
    }

    #[test]
    fn what_is_lost_is_counted_from_the_first_to_the_last_of_one_outage() {
        let mut outages = Outages::default();
        let mut lost = LostNotes::default();
        assert_eq!(lost.gap(), None);
        lost.add(AT(7));
        lost.add(AT(5));
        outages.failed(AT(0));
        outages.lose(lost);
        lost.add(AT(9));
        outages.lose(LostNotes { count: 1, span: Some((AT(9), AT(9))) });
        assert_eq!(outages.lost(), lost);
        let ended = outages.end(AT(1)).expect("it was on");
        assert_eq!(ended.gap(), Some((AT(9), Note::Gap { from: AT(5), to: AT(9), lost: 3 })));
        assert_eq!(outages.lost(), LostNotes::default());
    }
}
