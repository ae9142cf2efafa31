//! Whether another writer of the same topic is alive beside the one that is followed.
//!
//! The last message of a dead predecessor arrives late, and once. So another life counts as there only from its second
//! message on: with a greater sequence, at least one period after the first, and with a message of the followed life after
//! the first. It counts until it has been silent for its term.

use std::time::Duration;

use linewright_line::Tick;

/// Other lives kept at once. One that goes on is enough; the room is for those that are received once between its
/// messages.
const LIVES_MAX: usize = 64;

/// Another life that is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RivalLife {
    /// Its boot id.
    pub life: u64,
    /// Its newest sequence received.
    pub sequence: u64,
    /// It counts as there until then.
    pub until: Tick,
}

#[derive(Clone, Copy, Debug)]
struct RivalRecord {
    rival: RivalLife,
    since: Tick,
    is_there: bool,
}

/// The lives that are received beside the one that is followed.
#[derive(Clone, Debug)]
pub struct Rivals {
    period: Duration,
    term: Duration,
    others: Vec<RivalRecord>,
}

impl Rivals {
    /// Nothing received yet. Writers repeat themselves every `period`; `term` is the age at which a message is unknown.
    pub fn new(period: Duration, term: Duration) -> Self {
        Rivals { period, term, others: Vec::new() }
    }

    /// Takes a message of another life than the followed one, which was last received at `followed`.
    pub fn hear(&mut self, now: Tick, (life, sequence): (u64, u64), followed: Tick) {
        self.others.retain(|other| now < other.rival.until);
        let until = now + self.term;
        let has_room = self.others.len() < LIVES_MAX;
        match self.others.iter_mut().find(|other| other.rival.life == life) {
            Some(other) if sequence > other.rival.sequence => {
                other.is_there |= now >= other.since + self.period && followed > other.since;
                (other.rival.sequence, other.rival.until) = (sequence, until);
            }
            Some(_) => {}
            None if life != 0 => {
                if !has_room {
                    // Lives received once must not keep out one that goes on.
                    let oldest = self.others.iter().enumerate().filter(|(_, other)| !other.is_there);
                    match oldest.min_by_key(|(_, other)| other.since).map(|(at, _)| at) {
                        Some(at) => drop(self.others.remove(at)),
                        None => return,
                    }
                }
                let rival = RivalLife { life, sequence, until };
                self.others.push(RivalRecord { rival, since: now, is_there: false });
            }
            None => {}
        }
    }

    /// This life is the one that is followed now.
    pub fn forget(&mut self, life: u64) {
        self.others.retain(|other| other.rival.life != life);
    }

    /// The life that is there for longest, if one is.
    pub fn there(&self, now: Tick) -> Option<RivalLife> {
        let there = self.others.iter().filter(|other| other.is_there && now < other.rival.until);
        there.map(|other| other.rival).max_by_key(|rival| rival.until)
    }
}
