//! Hand-mode buttons held by message: hold-to-run across a network.
//!
//! A held button counts while it is refreshed. A refresh that comes late finds the motion stopped, and must not start it
//! again, however long the silence was: the finger may never have left the button. Only a release that was received makes
//! the next message a new press.

use std::time::Duration;

use linewright_line::Tick;

/// The buttons one sender holds, a bit each.
#[derive(Clone, Copy, Debug, Default)]
pub struct Buttons {
    said: u32,
    until: Tick,
    /// Expired while they were held, and no release received since.
    unreleased: u32,
}

impl Buttons {
    /// Takes the buttons held now, for `term` from now. Returns whether the buttons in force may have changed.
    pub fn hear(&mut self, now: Tick, held: u32, term: Duration) -> bool {
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
    pub fn hear_late(&mut self, now: Tick, held: u32, term: Duration) {
        self.hear(now, held, term);
        self.unreleased = held;
    }

    /// The buttons in force.
    pub fn held(&self, now: Tick) -> u32 {
        if now < self.until { self.said & !self.unreleased } else { 0 }
    }

    /// Expiry.
    pub fn until(&self) -> Tick {
        self.until
    }
}
