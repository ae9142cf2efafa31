//! Buttons that are held by message, by one console at a time.
//!
//! A finger that holds a button leads what moves by it. Two consoles whose messages come in turn would each end and begin that anew: a
//! release of the one looks like that of the other, and the message after it like a press. So it has to be known whose it is: while one
//! console holds a button a message of another one, held or released, ends that, and neither counts before it was released by the console
//! itself. A message that only stops is always obeyed.
//!
//! How long a held button counts after its last message is no question of this: the controllers decide it.

use std::time::Duration;

use linewright_line::Tick;

/// Consoles that have to release a button before it counts, at most; of more the latest are remembered.
const OWING_MAX: usize = 8;

/// What a message of a held button counts for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeldPass {
    /// For what is in it.
    Taken,
    /// For a release: another console held the button, and both have to let go.
    Second,
    /// For a release: its console has to let go first.
    Unreleased,
}

/// One button, or several that are one message.
#[derive(Clone, Debug, Default)]
pub struct HeldByOne {
    /// The console that holds it, and until when its last message counts.
    holder: Option<(u64, Tick)>,
    /// Consoles that have held it while it could not count, and have not released it since.
    owing: Vec<u64>,
}

impl HeldByOne {
    /// Takes a message of a console, which counts for `term`.
    pub fn offer(&mut self, now: Tick, console: u64, held: bool, term: Duration) -> HeldPass {
        let other = self.holder.filter(|(of, _)| *of != console);
        if let Some((of, _)) = other {
            self.holder = None;
            self.owes(of);
        }
        let is_ended = other.is_some_and(|(_, until)| now < until);
        if !held {
            self.holder = None;
            self.owing.retain(|of| *of != console);
        } else if is_ended {
            self.owes(console);
        } else if !self.owing.contains(&console) {
            self.holder = Some((console, now + term));
        }
        match () {
            () if is_ended => HeldPass::Second,
            () if held && self.owing.contains(&console) => HeldPass::Unreleased,
            () => HeldPass::Taken,
        }
    }

    /// A message of an unknown time: its console has to release the button before it counts.
    pub fn offer_late(&mut self, console: u64, held: bool) {
        if held {
            self.holder = self.holder.filter(|(of, _)| *of != console);
            self.owes(console);
        }
    }

    fn owes(&mut self, console: u64) {
        self.owing.retain(|of| *of != console);
        if self.owing.len() == OWING_MAX {
            self.owing.remove(0);
        }
        self.owing.push(console);
    }
}
