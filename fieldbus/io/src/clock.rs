//! The monotonic clock a node shares among its parts.
//!
//! The pure crates take a [`Tick`]; exactly one place per process turns the machine's clock into ticks, so that a
//! deadline computed by one part means the same moment to another.
//!
//! It is `CLOCK_BOOTTIME`: the time that the machine sleeps counts, so a lease or an age of before is over when it wakes. The monotonic
//! clock of the standard library stands meanwhile. A virtual machine that its host pauses sees neither: such a host is not for controllers.

use std::time::Duration;

use linewright_line::Tick;
use rustix::time::{ClockId, clock_gettime};

/// A monotonic clock that counts [`Tick`]s from the moment it was started. Copies share the origin.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    /// Time since the start of the machine.
    origin: Duration,
}

/// Time since the start of the machine, its sleep included.
fn since_boot() -> Duration {
    let time = clock_gettime(ClockId::Boottime);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec as u32)
}

impl Clock {
    /// Starts a clock: [`Tick::ZERO`] is now.
    pub fn start() -> Self {
        Clock { origin: since_boot() }
    }

    pub fn now(&self) -> Tick {
        Tick::ZERO + since_boot().saturating_sub(self.origin)
    }

    /// The moment `tick` as the async timers count it; a tick beyond their range is a day away, which for a deadline
    /// means "not in this sleep". Where the machine sleeps before it, the timer is late by as long.
    pub fn instant(&self, tick: Tick) -> tokio::time::Instant {
        const FAR: Duration = Duration::from_secs(86_400);
        tokio::time::Instant::now() + tick.since(self.now()).min(FAR)
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
