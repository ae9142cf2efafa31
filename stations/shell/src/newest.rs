//! Decision which of two whole-state messages is the newer one.
//!
//! A writer numbers its messages and marks them with a boot id that is new with every start of its process. Sequence
//! numbers alone would make a restarted writer (starting from 1) look old, and the last messages of its dead
//! predecessor, still on their way, look new. So: within a boot the greater sequence is newer. Another boot id is
//! accepted only once the present one has been silent for its term: boot ids have no order, so of two that are received
//! at once either may be the older. The price is that a restarted writer is recognised one term after its predecessor's
//! last message; until then its readers rely on a state that they would still hold if it had only become silent.
//!
//! A boot id that was replaced comes back after the same silence, and on its second message only, some time after the
//! first: what a dead process sent last arrives once, and what waited somewhere arrives at once. So does the present one with a lesser sequence: a number that its writer never gave would
//! otherwise make its readers deaf for as long as it lives.

use std::time::Duration;

use linewright_line::Tick;

/// Boot ids remembered as replaced. A writer that restarts more often than this while one message is on its way has
/// other troubles.
const RETIRED_MAX: usize = 8;

/// The newest message of one writer, by (boot id, sequence).
#[derive(Debug, Clone)]
pub struct NewestBySequence {
    /// Silence of the present life after which another one is accepted.
    term: Duration,
    current: Option<(u64, u64)>,
    /// Arrival of the newest message.
    heard: Tick,
    retired: Vec<u64>,
    /// The last message that does not alone prove its life alive, while no newer one is received.
    returning: Option<(u64, u64, Tick)>,
}

impl NewestBySequence {
    /// Nothing received yet. `term` is the age at which a message of this writer is unknown.
    pub fn new(term: Duration) -> Self {
        NewestBySequence { term, current: None, heard: Tick::ZERO, retired: Vec::new(), returning: None }
    }

    /// Takes the next message; gives whether it is the newest, and to be used. Boot id 0 has no writer.
    pub fn offer(&mut self, now: Tick, boot_id: u64, sequence: u64) -> bool {
        let is_newest = match self.current {
            _ if boot_id == 0 => return false,
            None => true,
            Some((boot, seen)) if boot == boot_id && sequence > seen => true,
            Some(_) if now < self.heard + self.term => return false,
            Some((boot, _)) if boot == boot_id || self.retired.contains(&boot_id) => {
                let apart = self.term / 8;
                let first = self.returning.filter(|&(boot, before, _)| boot == boot_id && before < sequence);
                // The first of messages that came close together is the one to compare with.
                if first.is_some_and(|(_, _, at)| now < at + apart) {
                    return false;
                }
                first.is_some()
            }
            Some(_) => true,
        };
        if is_newest {
            self.replace(boot_id, sequence);
            self.heard = now;
        } else {
            self.returning = Some((boot_id, sequence, now));
        }
        is_newest
    }

    /// Boot id and sequence of the newest message.
    pub fn current(&self) -> Option<(u64, u64)> {
        self.current
    }

    /// Arrival of the newest message.
    pub fn heard(&self) -> Tick {
        self.heard
    }

    fn replace(&mut self, boot_id: u64, sequence: u64) {
        if let Some((boot, _)) = self.current
            && boot != boot_id
        {
            self.retired.retain(|&retired| retired != boot_id);
            if self.retired.len() == RETIRED_MAX {
                self.retired.remove(0);
            }
            self.retired.push(boot);
        }
        self.returning = None;
        self.current = Some((boot_id, sequence));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TERM: Duration = Duration::from_millis(250);
    const NEWEST: bool = true;
    const OLD: bool = false;

    /// Offers messages given as (milliseconds, boot id, sequence), with whether each is to be the newest.
    fn judged(messages: &[(u64, u64, u64, bool)]) -> NewestBySequence {
        let mut newest = NewestBySequence::new(TERM);
        for &(at, boot, sequence, expected) in messages {
            let is_newest = newest.offer(Tick::from_millis(at), boot, sequence);
            assert_eq!(is_newest, expected, "boot {boot} sequence {sequence} at {at} ms");
        }
        newest
    }

    #[test]
    fn one_writer_and_its_restarts() {
        let newest = judged(&[
            (0, 0, 1, OLD),
            (0, 7, 5, NEWEST),
            (50, 7, 6, NEWEST),
            (50, 7, 6, OLD),
            (100, 7, 9, NEWEST),
            (101, 7, 8, OLD),
            (150, 8, 1, OLD),
            (349, 8, 5, OLD),
            (350, 8, 6, NEWEST),
            (351, 7, 10, OLD),
            (400, 8, 7, NEWEST),
            (650, 7, 10, OLD),
            (651, 9, 1, NEWEST),
            (900, 7, 11, OLD),
            (901, 9, u64::MAX, NEWEST),
        ]);
        assert_eq!(newest.current(), Some((9, u64::MAX)));
    }

    #[test]
    fn the_last_message_of_a_short_life_does_not_deafen_its_readers() {
        // Life 2 was never received while it lived; its last message overtakes nothing.
        judged(&[(0, 1, 500, NEWEST), (300, 3, 1, NEWEST), (301, 2, 1, OLD), (350, 3, 2, NEWEST)]);
        // The same while life 3 is cut off: it is received again one term later.
        let cut_off = [(0, 3, 1, NEWEST), (300, 2, 9, NEWEST), (310, 3, 7, OLD), (550, 3, 8, OLD)];
        judged(&[&cut_off[..], &[(600, 3, 9, NEWEST), (601, 3, 10, NEWEST)]].concat());
    }

    #[test]
    fn a_sequence_that_its_writer_never_gave_deafens_its_readers_for_one_term() {
        let newest = judged(&[
            (0, 7, 5, NEWEST),
            (10, 7, u64::MAX, NEWEST),
            (50, 7, 6, OLD),
            (259, 7, 10, OLD),
            // One message alone may be a late one, however often it comes.
            (300, 7, 11, OLD),
            (301, 7, 11, OLD),
            // Messages that waited somewhere arrive at once.
            (302, 7, 12, OLD),
            (303, 7, 13, OLD),
            (350, 7, 12, NEWEST),
            (400, 7, 13, NEWEST),
        ]);
        assert_eq!(newest.current(), Some((7, 13)));
    }

    #[test]
    fn of_two_that_are_heard_at_once_the_first_stays() {
        let mut newest = NewestBySequence::new(TERM);
        for round in 0..100 {
            let at = Tick::from_millis(50 * round);
            assert!(newest.offer(at, 1, round + 1));
            assert!(!newest.offer(at, 2, round + 1));
        }
    }

    #[test]
    fn only_the_last_boots_are_remembered() {
        let mut newest = NewestBySequence::new(TERM);
        for boot in 1..=10 {
            newest.offer(Tick::from_millis(1000 * boot), boot, 1);
        }
        assert!(!newest.offer(Tick::from_millis(20_000), 2, 2));
        assert!(newest.offer(Tick::from_millis(20_000), 1, 2), "forgotten after eight more");
    }
}
