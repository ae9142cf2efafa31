//! A state with its age, and the age from which it shows nothing any more.

use std::time::Duration;

use linewright_line::Line;

/// The newest state of a node.
#[derive(Debug)]
pub struct Aged<'s, T> {
    pub state: &'s T,
    /// Time since it was received.
    pub age: Duration,
}

/// The age from which a `CellState` no longer shows that its coordinator runs: two and a half periods.
pub const CELL_FRESH: Duration = Duration::from_millis(2500);

/// The age from which a state of a node is shown no longer: twice the age at which controllers ignore it, so that a picture does not
/// flicker.
pub fn state_fresh(line: &Line) -> Duration {
    line.timing.stale * 2
}

impl<T> Clone for Aged<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Aged<'_, T> {}

impl<'s, T> Aged<'s, T> {
    /// The state, while it is younger than this.
    pub fn fresh(self, limit: Duration) -> Option<&'s T> {
        (self.age < limit).then_some(self.state)
    }

    /// For how long the node, which was received, is not received any more; none while its state is younger than this.
    pub fn unheard_for(self, limit: Duration) -> Option<Duration> {
        (self.age >= limit).then_some(self.age)
    }
}
