//! *Resume*, held at a console by message: hold-to-run across a network, by one console at a time.
//!
//! As with [`crate::buttons`] only a release that was received makes the next message a new press. Besides, one finger starts
//! several stations by it, so that it has to be known whose it is: a message of another console, held or released, ends it. It
//! counts again when one console alone has been received for as long as a message counts, and has released it since.

use std::time::Duration;

use linewright_line::Tick;

/// The button, and the console that was received last.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ResumeButton {
    console: u64,
    said: bool,
    until: Tick,
    /// Held while it could not count, and no release received since.
    unreleased: bool,
    /// Two consoles count as being there until then.
    contested_until: Tick,
}

impl ResumeButton {
    /// Takes what a console sends, for `term` from now. Returns whether it is pressed by this, or ended by a second console.
    pub(crate) fn hear(&mut self, now: Tick, console: u64, held: bool, term: Duration) -> bool {
        let (is_received, is_same) = (now < self.until, console == self.console);
        let was_contested = self.is_contested(now);
        if is_received && !is_same {
            self.contested_until = now + term;
        }
        let is_ended = self.said && !was_contested && self.is_contested(now);
        let goes_on = self.said && is_received && is_same;
        let is_cut = self.said && !goes_on;
        self.unreleased = held && (self.unreleased || is_cut || self.is_contested(now));
        (self.console, self.said, self.until) = (console, held, now + term);
        is_ended || held && !goes_on && !was_contested
    }

    /// It counts neither as held nor as released: it comes from an unknown time.
    pub(crate) fn hear_late(&mut self, now: Tick, console: u64, held: bool, term: Duration) {
        self.hear(now, console, held, term);
        self.unreleased = held;
    }

    /// What is held now does not count before it was released.
    pub(crate) fn disarm(&mut self) {
        self.unreleased |= self.said;
    }

    pub(crate) fn is_held(&self, now: Tick) -> bool {
        now < self.until && self.said && !self.unreleased
    }

    pub(crate) fn is_contested(&self, now: Tick) -> bool {
        now < self.contested_until
    }

    /// Held, and not counted before it was released.
    pub(crate) fn is_unreleased(&self) -> bool {
        self.unreleased
    }

    /// Expiry.
    pub(crate) fn until(&self) -> Tick {
        self.until
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TERM: Duration = Duration::from_millis(250);
    const A: u64 = 1;
    const B: u64 = 2;

    fn at(millis: u64) -> Tick {
        Tick::from_millis(millis)
    }

    #[test]
    fn held_while_one_console_renews_it() {
        let mut button = ResumeButton::default();
        assert!(button.hear(at(1000), A, true, TERM), "a press");
        assert!(!button.hear(at(1200), A, true, TERM), "renewed");
        assert!(button.is_held(at(1449)) && !button.is_held(at(1450)));
        button.hear(at(1500), A, true, TERM);
        assert!(!button.is_held(at(1500)), "silence is no release");
        button.hear(at(1550), A, false, TERM);
        assert!(button.hear(at(1600), A, true, TERM) && button.is_held(at(1600)));
    }

    #[test]
    fn a_second_console_ends_it_whatever_it_sends() {
        for second in [true, false] {
            let mut button = ResumeButton::default();
            button.hear(at(1000), A, true, TERM);
            assert!(button.hear(at(1050), B, second, TERM), "to be reported");
            assert!(!button.is_held(at(1050)));
            for millis in [1100, 1200, 1300, 1400, 1500] {
                assert!(!button.hear(at(millis), A, true, TERM), "once");
                assert!(!button.is_held(at(millis)), "held on, {millis} ms");
            }
            button.hear(at(1550), A, false, TERM);
            assert!(button.hear(at(1600), A, true, TERM) && button.is_held(at(1600)), "alone again, and pressed anew");
        }
    }

    #[test]
    fn while_two_send_neither_holds_it() {
        let mut button = ResumeButton::default();
        for step in 0..40 {
            let now = at(1000 + step * 50);
            // One that stands idle, and one that presses again and again.
            button.hear(now, A, false, TERM);
            button.hear(now, B, step % 4 != 0, TERM);
            assert!(!button.is_held(now), "step {step}");
        }
    }

    #[test]
    fn a_console_that_takes_over_what_another_held_has_to_release_it_first() {
        let mut button = ResumeButton::default();
        button.hear(at(1000), A, true, TERM);
        button.hear(at(5000), B, true, TERM);
        assert!(!button.is_held(at(5000)));
        button.hear(at(5050), B, false, TERM);
        button.hear(at(5100), B, true, TERM);
        assert!(button.is_held(at(5100)));
    }

    #[test]
    fn a_message_from_an_unknown_time_and_a_change_of_mode_count_for_nothing() {
        let mut button = ResumeButton::default();
        button.hear_late(at(1000), A, true, TERM);
        button.hear(at(1050), A, true, TERM);
        assert!(!button.is_held(at(1050)));
        button.hear(at(1100), A, false, TERM);
        button.hear(at(1150), A, true, TERM);
        button.disarm();
        button.hear(at(1200), A, true, TERM);
        assert!(!button.is_held(at(1200)));
    }
}
