//! *Resume*, held at a console by message: hold-to-run across a network, by one console at a time.
//!
//! As with [`crate::buttons`] only a release that was received makes the next message a new press. Besides, one finger starts
//! several stations by it, so that it has to be known whose it is: a message of another console, held or released, ends it. It
//! counts again when one console alone has been received for as long as a message counts, and has released it since.

use std::time::Duration;

use linewright_line::Tick;

/// The button, and the console that was received last.
#[derive(Clone, Copy, Debug, Default)]
pub struct ResumeButton {
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
    pub fn hear(&mut self, now: Tick, console: u64, held: bool, term: Duration) -> bool {
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
    pub fn hear_late(&mut self, now: Tick, console: u64, held: bool, term: Duration) {
        self.hear(now, console, held, term);
        self.unreleased = held;
    }

    /// What is held now does not count before it was released.
    pub fn disarm(&mut self) {
        self.unreleased |= self.said;
    }

    pub fn is_held(&self, now: Tick) -> bool {
        now < self.until && self.said && !self.unreleased
    }

    pub fn is_contested(&self, now: Tick) -> bool {
        now < self.contested_until
    }

    /// Held, and not counted before it was released.
    pub fn is_unreleased(&self) -> bool {
        self.unreleased
    }

    /// Expiry.
    pub fn until(&self) -> Tick {
        self.until
    }
}
