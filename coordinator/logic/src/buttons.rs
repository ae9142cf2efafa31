//! Hand-mode buttons held by message: hold-to-run across a network.
//!
//! A held button counts while it is refreshed. A refresh that comes late finds the motion stopped, and must not start it
//! again, however long the silence was: the finger may never have left the button. Only a release that was received makes
//! the next message a new press.

use std::time::Duration;

use linewright_line::Tick;

/// The buttons one sender holds, a bit each.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Buttons {
    said: u32,
    until: Tick,
    /// Expired while they were held, and no release received since.
    unreleased: u32,
}

impl Buttons {
    /// Takes the buttons held now, for `term` from now. Returns whether the buttons in force may have changed.
    pub(crate) fn hear(&mut self, now: Tick, held: u32, term: Duration) -> bool {
        let ran_out = now >= self.until;
        let changed = held != self.said || ran_out;
        if ran_out {
            self.unreleased |= self.said;
        }
        self.unreleased &= held;
        self.said = held;
        self.until = now + term;
        changed
    }

    /// Takes the buttons held at an unknown time. They count neither as held nor as released; the finger may never have left
    /// the button.
    pub(crate) fn hear_late(&mut self, now: Tick, held: u32, term: Duration) {
        self.hear(now, held, term);
        self.unreleased = held;
    }

    /// The buttons in force.
    pub(crate) fn held(&self, now: Tick) -> u32 {
        if now < self.until { self.said & !self.unreleased } else { 0 }
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

    fn at(millis: u64) -> Tick {
        Tick::from_millis(millis)
    }

    #[test]
    fn held_while_refreshed() {
        let mut buttons = Buttons::default();
        assert!(buttons.hear(at(1000), 0b11, TERM));
        assert!(!buttons.hear(at(1200), 0b11, TERM));
        assert_eq!(buttons.held(at(1449)), 0b11);
        assert_eq!(buttons.held(at(1450)), 0);
        assert_eq!(buttons.until(), at(1450));
    }

    #[test]
    fn a_late_refresh_is_no_new_press_until_the_button_was_released() {
        let mut buttons = Buttons::default();
        buttons.hear(at(1000), 0b01, TERM);
        assert!(buttons.hear(at(1300), 0b11, TERM));
        assert_eq!(buttons.held(at(1300)), 0b10, "the other button is pressed, this one lapsed");
        buttons.hear(at(1350), 0b11, TERM);
        assert_eq!(buttons.held(at(1350)), 0b10, "and stays so however often it is said");
        buttons.hear(at(1400), 0b10, TERM);
        buttons.hear(at(1450), 0b11, TERM);
        assert_eq!(buttons.held(at(1450)), 0b11, "released and pressed again");
    }

    #[test]
    fn no_silence_is_a_release() {
        let mut buttons = Buttons::default();
        buttons.hear(at(1000), 1, TERM);
        for late in [2000, 4000, 3_600_000] {
            buttons.hear(at(late), 1, TERM);
            assert_eq!(buttons.held(at(late)), 0, "after {late} ms");
        }
        buttons.hear(at(3_600_100), 0, TERM);
        buttons.hear(at(3_600_200), 1, TERM);
        assert_eq!(buttons.held(at(3_600_200)), 1);
    }
}
