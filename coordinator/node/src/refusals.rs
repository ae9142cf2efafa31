//! The last refusal, as it is published: until a command is obeyed, the mode changes, what it asks for
//! is seen done, or half a minute has passed.

use std::time::Duration;

use linewright_coordinator_logic::ModeRefusal;
use linewright_line::Tick;
use linewright_msgs::{LineState, fitting};
use linewright_station_shell::ParticipantId;

/// How soon a refusal may follow another one in what is logged.
const LOGGED_EVERY: Duration = Duration::from_millis(20);
/// How long a refusal is shown, if nothing ends it before.
const SHOWN_FOR: Duration = Duration::from_secs(30);

/// What has been refused.
#[derive(Debug, Default)]
pub struct Refusals {
    /// Since the coordinator started.
    pub count: u64,
    text: String,
    /// The command that was refused, in its words.
    command: String,
    /// Why, where it was a command for the mode.
    reasons: Vec<ModeRefusal>,
    at: Tick,
    log_due: Tick,
    /// The senders of refused commands, the latest first, and how many of each were refused.
    senders: Vec<(ParticipantId, u64)>,
}

/// Senders that are counted; of more, the latest.
const SENDERS_MAX: usize = 16;

/// A participant as the ROS 2 tools write the beginning of an endpoint's identity, e.g. `01.10.5e.…`.
pub fn participant_text(id: &ParticipantId) -> String {
    id.map(|byte| format!("{byte:02x}")).join(".")
}

impl Refusals {
    pub fn refuse(&mut self, now: Tick, text: String, command: String, reasons: &[ModeRefusal]) {
        self.count += 1;
        if now >= self.log_due {
            self.log_due = now + LOGGED_EVERY;
            tracing::warn!(refusals = self.count, "{text}");
        }
        // With many devices lost there is more to say than a message carries.
        self.text = fitting(text);
        self.command = command;
        self.reasons = reasons.to_vec();
        self.at = now;
    }

    /// A command of this sender was refused.
    pub fn count_sender(&mut self, from: ParticipantId) {
        let known = self.senders.iter().position(|(sender, _)| *sender == from);
        let count = known.map_or(0, |at| self.senders.remove(at).1);
        self.senders.truncate(SENDERS_MAX - 1);
        self.senders.insert(0, (from, count + 1));
    }

    /// The senders of refused commands, and how many of each were refused.
    pub fn senders(&self) -> Vec<(String, u64)> {
        self.senders.iter().map(|(sender, count)| (participant_text(sender), *count)).collect()
    }

    /// A command was obeyed, or the mode has changed: what was refused may be possible now.
    pub fn end(&mut self) {
        self.text.clear();
    }

    /// The message with the refusal that stands.
    pub fn message(&self, now: Tick, message: LineState) -> LineState {
        let (text, age) = if self.is_met(&message) { ("", Duration::ZERO) } else { self.standing(now) };
        LineState {
            refused: if text.is_empty() { String::new() } else { self.command.clone() },
            refusal: text.to_owned(),
            refusal_age_ms: u32::try_from(age.as_millis()).unwrap_or(u32::MAX),
            refusals: self.count,
            ..message
        }
    }

    /// Whether what the refusal asks for is done: the emergency stop button is seen released.
    fn is_met(&self, state: &LineState) -> bool {
        let is_released = !state.estop_pressed && !state.console_lost;
        self.reasons == [ModeRefusal::EStopPressed] && is_released
    }

    /// The refusal that stands, and its age; empty for none.
    pub fn standing(&self, now: Tick) -> (&str, Duration) {
        let age = now.since(self.at);
        if self.text.is_empty() || age >= SHOWN_FOR { ("", Duration::ZERO) } else { (&self.text, age) }
    }
}
