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

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(at: u64) -> Tick {
        Tick::from_millis(at)
    }

    fn rivals() -> Rivals {
        Rivals::new(Duration::from_millis(50), Duration::from_millis(250))
    }

    #[test]
    fn one_late_message_its_copies_and_a_predecessor_of_a_silent_life_do_not_count() {
        let mut late = rivals();
        late.hear(ms(1000), (2, 7), ms(990));
        late.hear(ms(1100), (2, 7), ms(1090));
        assert_eq!(late.there(ms(1100)), None);
        // Messages that come at once come from one buffer.
        late.hear(ms(1300), (3, 7), ms(1290));
        late.hear(ms(1301), (3, 8), ms(1301));
        assert_eq!(late.there(ms(1301)), None);
        // A successor sends while the life before has just fallen silent.
        let mut successor = rivals();
        for at in [1000, 1050, 1100] {
            successor.hear(ms(at), (4, at), ms(990));
        }
        assert_eq!(successor.there(ms(1100)), None);
    }

    #[test]
    fn a_life_that_goes_on_beside_the_followed_one_counts_until_it_is_silent() {
        let mut beside = rivals();
        for at in [1000, 1050] {
            beside.hear(ms(at), (2, at), ms(at));
        }
        assert_eq!(beside.there(ms(1299)), Some(RivalLife { life: 2, sequence: 1050, until: ms(1300) }));
        assert_eq!(beside.there(ms(1300)), None);
        // After the silence it has to be received twice again.
        beside.hear(ms(1400), (2, 1400), ms(1400));
        assert_eq!(beside.there(ms(1400)), None);
    }

    #[test]
    fn who_becomes_the_followed_one_is_no_rival() {
        let mut beside = rivals();
        for at in [1000, 1050] {
            beside.hear(ms(at), (2, at), ms(at));
        }
        beside.forget(2);
        assert_eq!(beside.there(ms(1051)), None);
    }

    #[test]
    fn lives_heard_once_do_not_keep_out_one_that_goes_on() {
        let mut crowd = rivals();
        for nth in 0..20 {
            let at = 1000 + 50 * nth;
            (0..4).for_each(|life| crowd.hear(ms(at), (100 + 4 * nth + life, 1), ms(at)));
            crowd.hear(ms(at + 1), (7, nth + 1), ms(at));
        }
        assert_eq!(crowd.there(ms(1952)).map(|rival| rival.life), Some(7));
    }
}
