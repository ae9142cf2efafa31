//! When the emergency stop was entered, by the host's clock.

use std::time::SystemTime;

use linewright_line::Tick;
use linewright_node_shell::clock;

/// Read off the clock once for each stop, so that a clock that is set later does not change it.
#[derive(Debug, Default)]
pub struct StopTime {
    since: Option<Tick>,
    text: String,
}

impl StopTime {
    /// The time of a stop that was entered at `since`; empty where there is none.
    pub fn text(&mut self, (now, wall): (Tick, SystemTime), since: Option<Tick>) -> &str {
        if self.since != since {
            let at = since.and_then(|since| wall.checked_sub(now.since(since)));
            (self.since, self.text) = (since, at.map(clock).unwrap_or_default());
        }
        &self.text
    }
}
