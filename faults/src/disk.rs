//! The disk of a process: one journal, whose records reach it some time after they were written.

use std::collections::VecDeque;
use std::time::Duration;

use linewright_simulation::Rng;

/// Records that the page cache may hold at once: those of several cycles, as what is not synchronised stays there for seconds.
const CACHED_MAX: usize = 96;

/// How a disk behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiskState {
    /// A write takes no time that matters.
    Good,
    /// A write takes so long.
    Slow(Duration),
    /// A write takes so long, and fails: full, read-only, or an I/O error. The record before it is still there.
    Failing(Duration),
}

/// A journal on a disk.
#[derive(Clone, Debug)]
pub(crate) struct SimulatedDisk<R> {
    pub(crate) state: DiskState,
    /// Start of the host.
    pub(crate) host: u64,
    /// The newest last, each with the start of the host it was written in.
    records: VecDeque<(u64, R)>,
    /// Number of the newest record.
    number: u64,
}

impl<R: Clone> SimulatedDisk<R> {
    pub(crate) fn new() -> Self {
        SimulatedDisk { state: DiskState::Good, host: 1, records: VecDeque::new(), number: 0 }
    }

    /// Time that a write takes, and whether it succeeds.
    pub(crate) fn write_takes(&self) -> (Duration, bool) {
        match self.state {
            DiskState::Good => (Duration::ZERO, true),
            DiskState::Slow(takes) => (takes, true),
            DiskState::Failing(takes) => (takes, false),
        }
    }

    pub(crate) fn store(&mut self, record: R) {
        if self.records.len() == CACHED_MAX {
            self.records.pop_front();
        }
        self.records.push_back((self.host, record));
        self.number += 1;
    }

    /// The newest record, and whether it was written in this start of the host.
    pub(crate) fn newest(&self) -> Option<(&R, bool)> {
        self.records.back().map(|(host, record)| (record, *host == self.host))
    }

    /// The host loses its power: what was not on the disk yet is gone, and a record that was being written is torn.
    pub(crate) fn power_cut(&mut self, rng: &mut Rng) {
        let kept = rng.below(self.records.len() as u64 + 1) as usize;
        self.number -= (self.records.len() - kept) as u64;
        self.records.truncate(kept);
        self.host += 1;
    }

    /// Number of the newest record: one that is lost leaves a lower one.
    pub(crate) fn number(&self) -> u64 {
        self.number
    }

    /// The newest record is not read.
    pub(crate) fn skip_newest(&mut self) {
        if self.records.pop_back().is_some() {
            self.number -= 1;
        }
    }

    /// The disk is replaced, or the journal removed.
    pub(crate) fn lose(&mut self) {
        self.number -= self.records.len() as u64;
        self.records.clear();
    }
}
