//! Limit on reports of repeated events.

use std::time::Duration;

use linewright_line::Tick;

/// Lets a few through at once, and after that one every so often.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    burst: u32,
    every: Duration,
    left: u32,
    since: Tick,
}

impl Budget {
    /// So many at once, and one every so often.
    pub const fn new(burst: u32, every: Duration) -> Self {
        Budget { burst, every, left: burst, since: Tick::ZERO }
    }

    /// Whether one more is let through at `now`.
    pub fn take(&mut self, now: Tick) -> bool {
        let earned = now.since(self.since).as_micros() / self.every.as_micros().max(1);
        if earned > 0 {
            self.left = self.left.saturating_add(u32::try_from(earned).unwrap_or(u32::MAX)).min(self.burst);
            self.since = now;
        }
        self.left > 0 && {
            self.left -= 1;
            true
        }
    }
}
