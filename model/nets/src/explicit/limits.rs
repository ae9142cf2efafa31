//! Limits of a search, and the result where they are not enough.

use thiserror::Error;

use crate::FireError;

/// Limits of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExplorationLimits {
    /// The most states that are still decided.
    pub states: u64,
    /// The most bytes that the search may hold at a time, as it accounts for them itself: the tables whose size grows
    /// with the states. Memory that depends on the size of the net alone is not counted.
    pub bytes: usize,
    /// Number of threads; 0 counts as 1. Results do not depend on it.
    pub threads: usize,
}

impl Default for ExplorationLimits {
    /// A hundred million states in two gigabytes, on one thread.
    fn default() -> Self {
        ExplorationLimits { states: 100_000_000, bytes: 2 << 30, threads: 1 }
    }
}

/// The search did not come to an end: nothing is known about the net as a whole.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("undecided after {states} states: {cause}")]
pub struct ExplorationUndecided {
    /// The states found until then.
    pub states: u64,
    pub cause: ExplorationLimit,
}

/// Limit that stops a search.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ExplorationLimit {
    /// There are more states than allowed.
    #[error("there are more than the {limit} allowed; allow more, or decide first whether the net is bounded")]
    States {
        /// [`ExplorationLimits::states`].
        limit: u64,
    },
    /// The next table would not fit.
    #[error("the search needs {needs} bytes, and {limit} are allowed")]
    Bytes {
        /// Bytes that it would have held at a time.
        needs: usize,
        /// [`ExplorationLimits::bytes`].
        limit: usize,
    },
    /// A place gets more tokens than can be counted.
    #[error("{0}")]
    Overflow(FireError),
}

/// Counts the bytes that a search holds.
#[derive(Clone, Copy, Debug)]
pub(super) struct MemoryBudget {
    limit: usize,
    held: usize,
    peak: usize,
}

impl MemoryBudget {
    pub(super) fn new(limit: usize) -> Self {
        MemoryBudget { limit, held: 0, peak: 0 }
    }

    /// Accounts for a table before it is made.
    pub(super) fn take(&mut self, bytes: usize, states: u64) -> Result<(), ExplorationUndecided> {
        let needs = self.held.saturating_add(bytes);
        if needs > self.limit {
            return Err(ExplorationUndecided { states, cause: ExplorationLimit::Bytes { needs, limit: self.limit } });
        }
        self.held = needs;
        self.peak = self.peak.max(needs);
        Ok(())
    }

    /// Accounts for a table that is gone.
    pub(super) fn give_back(&mut self, bytes: usize) {
        self.held -= bytes;
    }

    /// The most that was held at a time.
    pub(super) fn peak(&self) -> usize {
        self.peak
    }
}
