//! When the emergency stop was entered, by the host's clock.

use std::time::SystemTime;

use linewright_line::Tick;
use linewright_node_shell::clock;

/// Read off the clock once for each stop, so that a clock that is set later does not change it.
#[derive(Debug, Default)]
pub(crate) struct StopTime {
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

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn it_is_the_time_of_the_stop_and_stays() {
        let mut time = StopTime::default();
        let wall = SystemTime::UNIX_EPOCH + Duration::from_secs(72_389);
        let at = Tick::from_millis;
        assert_eq!(time.text((at(5000), wall), None), "");
        assert_eq!(time.text((at(7000), wall + Duration::from_secs(2)), Some(at(5000))), "1970-01-01 20:06:29 UTC");
        assert_eq!(time.text((at(8000), wall + Duration::from_secs(99)), Some(at(5000))), "1970-01-01 20:06:29 UTC");
        assert_eq!(time.text((at(9000), wall), None), "", "it was reset");
    }
}
