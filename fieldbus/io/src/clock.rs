//! The monotonic clock a node shares among its parts.
//!
//! The pure crates take a [`Tick`]; exactly one place per process turns the machine's clock into ticks, so that a
//! deadline computed by one part means the same moment to another.

use std::time::Duration;

use linewright_line::Tick;

/// A monotonic clock that counts [`Tick`]s from the moment it was started. Copies share the origin.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    origin: tokio::time::Instant,
}

impl Clock {
    /// Starts a clock: [`Tick::ZERO`] is now.
    pub fn start() -> Self {
        Clock { origin: tokio::time::Instant::now() }
    }

    pub fn now(&self) -> Tick {
        Tick::ZERO + self.origin.elapsed()
    }

    /// The moment `tick` as the async timers count it; a tick beyond their range is a day away, which for a deadline
    /// means "not in this sleep".
    pub fn instant(&self, tick: Tick) -> tokio::time::Instant {
        let far = || tokio::time::Instant::now() + Duration::from_secs(86_400);
        if tick == Tick::NEVER { far() } else { self.origin.checked_add(tick.since(Tick::ZERO)).unwrap_or_else(far) }
    }

    /// Sleeps until `deadline`; for ever where there is none. Cancel safe.
    ///
    /// Tokio's timers count whole milliseconds: the sleep ends up to about 1 ms late, never early.
    pub async fn sleep_until(&self, deadline: Option<Tick>) {
        match deadline {
            Some(tick) => tokio::time::sleep_until(self.instant(tick)).await,
            None => std::future::pending().await,
        }
    }
}
