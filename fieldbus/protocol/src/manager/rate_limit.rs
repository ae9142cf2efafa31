//! Limits on the answers, reports and processing for one node's traffic.
//!
//! A node that babbles, broken or badly configured, may fill the bus. Its frames are then worth nothing, and their cost
//! must be bounded: the frames looked at, the orders sent in return, the events reported. The other devices pay with
//! the bus's time, which is the bus's business, and with nothing else.

use std::time::Duration;

use linewright_line::Tick;

/// Most unsolicited frames of a node within one [`WINDOW`]: process data, heartbeats and emergencies together. A drive
/// that moves sends some forty; two thousand a second is a third of what 500 kbit/s carry.
pub(super) const FRAMES_MAX: u32 = 200;
/// In which they are counted.
pub(super) const WINDOW: Duration = Duration::from_millis(100);
/// Time for which a node has to keep within the limit until its frames are taken again.
const CALM: Duration = Duration::from_secs(1);

/// Frame count of a node.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct NodeRateLimits {
    begun: Tick,
    frames: u32,
    /// It counts as babbling until then.
    until: Option<Tick>,
}

/// Verdict on one more frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RateVerdict {
    /// To be looked at.
    Fine,
    /// The one with which the node begins to babble; not to be looked at.
    Begins,
    /// Not to be looked at.
    TooMuch,
}

impl NodeRateLimits {
    pub fn count(&mut self, now: Tick) -> RateVerdict {
        if self.begun + WINDOW <= now {
            (self.begun, self.frames) = (now, 0);
        }
        self.frames = self.frames.saturating_add(1);
        if self.frames <= FRAMES_MAX {
            return if self.is_on() { RateVerdict::TooMuch } else { RateVerdict::Fine };
        }
        let before = self.until.replace(now + CALM);
        if before.is_none() { RateVerdict::Begins } else { RateVerdict::TooMuch }
    }

    /// Whether it babbles.
    pub fn is_on(&self) -> bool {
        self.until.is_some()
    }

    /// Lets time pass: it may have ceased to.
    pub fn ends(&mut self, now: Tick) {
        self.until = self.until.filter(|until| *until > now);
    }

    /// Time at which the flood may have ended.
    pub fn deadline(&self) -> Tick {
        self.until.unwrap_or(Tick::NEVER)
    }
}
