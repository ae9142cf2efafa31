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
    missed: u64,
    replaced: u64,
}

impl NewestBySequence {
    /// Nothing received yet. `term` is the age at which a message of this writer is unknown.
    pub fn new(term: Duration) -> Self {
        NewestBySequence {
            term,
            current: None,
            heard: Tick::ZERO,
            retired: Vec::new(),
            returning: None,
            missed: 0,
            replaced: 0,
        }
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

    /// Messages that were not received, or came after a newer one: the numbers left out between those that were used.
    pub fn missed(&self) -> u64 {
        self.missed
    }

    /// How often another life has followed.
    pub fn replaced(&self) -> u64 {
        self.replaced
    }

    fn replace(&mut self, boot_id: u64, sequence: u64) {
        if let Some((_, seen)) = self.current.filter(|(boot, _)| *boot == boot_id) {
            self.missed = self.missed.saturating_add(sequence.saturating_sub(seen.saturating_add(1)));
        }
        if let Some((boot, _)) = self.current
            && boot != boot_id
        {
            self.replaced = self.replaced.saturating_add(1);
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
