//! How far a search is, for another thread to read while it runs.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// How far a search is. The search writes it; any thread may read it. Nothing depends on the two numbers being of one moment.
#[derive(Debug, Default)]
pub struct SearchProgress {
    looked_at: AtomicUsize,
    states_max: AtomicUsize,
    is_again: AtomicBool,
}

impl SearchProgress {
    /// A search begins, which looks at no more states than this; 0 for none.
    pub fn begin(&self, states_max: usize) {
        self.looked_at.store(0, Ordering::Relaxed);
        self.states_max.store(states_max, Ordering::Relaxed);
    }

    /// The searches from now on look once more at the first states of what has been searched, for the nearest violation; or do not.
    pub fn looks_again(&self, is_again: bool) {
        self.is_again.store(is_again, Ordering::Relaxed);
    }

    /// Whether the first states are looked at once more.
    pub fn is_again(&self) -> bool {
        self.is_again.load(Ordering::Relaxed)
    }

    pub(crate) fn looked_at(&self, states: usize) {
        self.looked_at.store(states, Ordering::Relaxed);
    }

    /// The states looked at, and the most that will be; both 0 before the first search.
    pub fn states(&self) -> (usize, usize) {
        (self.looked_at.load(Ordering::Relaxed), self.states_max.load(Ordering::Relaxed))
    }
}
