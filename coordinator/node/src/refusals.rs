//! The last refusal, as it is published: until a command is obeyed, or half a minute has passed.

use std::time::Duration;

use linewright_line::Tick;
use linewright_msgs::fitting;

/// How soon a refusal may follow another one in what is logged.
const LOGGED_EVERY: Duration = Duration::from_millis(20);
/// How long a refusal is shown, if no command is obeyed before.
const SHOWN_FOR: Duration = Duration::from_secs(30);

/// What has been refused.
#[derive(Debug, Default)]
pub(crate) struct Refusals {
    /// Since the coordinator started.
    pub count: u64,
    text: String,
    until: Tick,
    log_due: Tick,
}

impl Refusals {
    pub fn refuse(&mut self, now: Tick, text: String) {
        self.count += 1;
        if now >= self.log_due {
            self.log_due = now + LOGGED_EVERY;
            tracing::warn!(refusals = self.count, "{text}");
        }
        // With many devices lost there is more to say than a message carries.
        self.text = fitting(text);
        self.until = now + SHOWN_FOR;
    }

    /// A command was obeyed.
    pub fn obey(&mut self) {
        self.text.clear();
    }

    /// The refusal that stands; empty for none.
    pub fn text(&self, now: Tick) -> &str {
        if now < self.until { &self.text } else { "" }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_stands_until_a_command_is_obeyed_or_half_a_minute_is_over() {
        let mut refusals = Refusals::default();
        let at = Tick::from_millis;
        refusals.refuse(at(1000), "hand refused in auto".to_owned());
        assert_eq!(refusals.text(at(30_999)), "hand refused in auto");
        assert_eq!(refusals.text(at(31_000)), "");
        refusals.refuse(at(40_000), "manual refused in auto".to_owned());
        refusals.obey();
        assert_eq!((refusals.text(at(40_001)), refusals.count), ("", 2));
    }
}
