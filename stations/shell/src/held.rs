//! Buttons that are held by message, by one console at a time.
//!
//! Messages of two consoles may alternate: the release of one would look like that of the other, and the next message like a press. So
//! while one console holds a button, a message of another one, held or released, ends that. Each console that holds it must release it
//! itself before it counts.

use std::time::Duration;

use linewright_line::Tick;

/// Consoles that have to release a button before it counts, at most; of more the latest are remembered.
const OWING_MAX: usize = 8;

/// What a message of a held button counts for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeldPass {
    /// For what is in it.
    Taken,
    /// For a release: another console held the button. Each that holds it must release it.
    Second,
    /// For a release: its console has to let go first.
    Unreleased,
}

/// One button, or several that are one message.
#[derive(Clone, Debug, Default)]
pub struct HeldByOne {
    /// The console that holds it, and until when its last message counts.
    holder: Option<(u64, Tick)>,
    /// Consoles that have held it while it could not count, and have not released it since, each with the time until which its last
    /// message shows it held. The one received last stands last.
    owing: Vec<(u64, Tick)>,
}

impl HeldByOne {
    /// Takes a message of a console, which counts for `term`.
    pub fn offer(&mut self, now: Tick, console: u64, held: bool, term: Duration) -> HeldPass {
        let other = self.holder.filter(|(of, _)| *of != console);
        if let Some((of, until)) = other {
            self.holder = None;
            self.owes(of, until);
        }
        let is_ended = other.is_some_and(|(_, until)| now < until);
        // One that does not count and is still held: with another press beside it a motion would begin, and end with its next message.
        let is_beside = held && self.owing.iter().any(|(of, until)| *of != console && now < *until);
        let is_owing = self.owing.iter().any(|(of, _)| *of == console);
        if !held {
            self.holder = None;
            self.owing.retain(|(of, _)| *of != console);
        } else if is_ended || is_beside || is_owing {
            self.owes(console, now + term);
        } else {
            self.holder = Some((console, now + term));
        }
        match () {
            () if is_ended => HeldPass::Second,
            () if held && is_owing => HeldPass::Unreleased,
            () if is_beside => HeldPass::Second,
            () => HeldPass::Taken,
        }
    }

    /// A message of an unknown time: the console that held the button before, and this one if it holds it, have to release it before it
    /// counts.
    pub fn offer_late(&mut self, now: Tick, console: u64, held: bool, term: Duration) {
        if let Some((of, until)) = self.holder.take() {
            self.owes(of, until);
        }
        if held {
            self.owes(console, now + term);
        }
    }

    fn owes(&mut self, console: u64, until: Tick) {
        self.owing.retain(|(of, _)| *of != console);
        if self.owing.len() == OWING_MAX {
            self.owing.remove(0);
        }
        self.owing.push((console, until));
    }
}
