//! The time a station spends in other modes than auto.
//!
//! What passes there, at night, in a fault or while people work at a panel, is neither a wait of the chart nor a part
//! of the cycle time. Only modes count here.

use std::time::Duration;

use linewright_line::Tick;
use linewright_line::net::ControlMode;

/// One station's time out of auto.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Idle {
    before: Duration,
    since: Option<Tick>,
}

impl Idle {
    /// Of a station that has just been switched on.
    pub(crate) fn from_the_start() -> Self {
        Idle { before: Duration::ZERO, since: Some(Tick::ZERO) }
    }

    /// Whether the station is out of auto.
    pub(crate) fn is_on(self) -> bool {
        self.since.is_some()
    }

    /// All of it until `now`.
    pub(crate) fn until(self, now: Tick) -> Duration {
        self.before + self.since.map_or(Duration::ZERO, |since| now.since(since))
    }

    /// The station obeys a mode from `now` on.
    pub(crate) fn enter(&mut self, now: Tick, mode: ControlMode) {
        if mode == ControlMode::Auto {
            *self = Idle { before: self.until(now), since: None };
        } else if self.since.is_none() {
            self.since = Some(now);
        }
    }
}
