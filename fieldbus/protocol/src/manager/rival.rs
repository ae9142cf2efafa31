//! Another manager on the same bus.
//!
//! Two managers configure, start and command the same devices, each against the other. So a manager listens before it
//! sends anything, for four periods of its own heartbeat. If a manager's heartbeat (77Fh) is received in that time,
//! this one came second and yields: it has sent nothing, sends nothing, and its node ends.
//!
//! ```text
//!            polled            nothing heard, first frame sent         after as long again
//!  Before ──────────▶ Listening ─────────────────────────────▶ Young ─────────────────────▶ Settled
//!     └──────────────────┴─── 77Fh heard ──▶ Yielded ◀─── 77Fh heard ──┘
//! ```
//!
//! Two that began to listen at the same instant receive each other's heartbeat when both are young, and both yield;
//! their supervisors start them again, hardly at the same instant once more. A settled manager that receives another's
//! heartbeat stays, because the other may end, but nothing moves while both are there: every output is let go, every
//! image is invalid, no device is read, ordered or started. Its own heartbeat goes on, so that each of two settled ones
//! detects the other for as long as both are there. When the other has been silent for as long as it takes to miss a
//! manager, the devices are brought up as after a bus that was off.
//!
//! Silence counts only while this manager could have received a heartbeat: a poll that comes late, or an interface that
//! was off the bus, prolongs the listening.

use std::time::Duration;

use linewright_line::{Tick, Timing};

use super::event::{BusEvent, BusOutbox};
use super::texts::{STILL_LISTENING, other_manager};
use super::{MANAGER_NODE, Manager};
use crate::codec::CanopenMessage;
use crate::frame::Frame;

/// Least time between two reports of another manager while it is there.
const REPORTED_EVERY: Duration = Duration::from_secs(5);

/// Stage of taking over the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Takeover {
    /// Not polled yet.
    Before,
    /// It sends nothing until then.
    Listening { until: Tick },
    /// It has begun to send a short time ago; it has settled then.
    Young { until: Tick },
    /// It is the manager of this bus.
    Settled,
    /// It has to end; whether it ever sent anything.
    Yielded { has_sent: bool },
}

/// State of the watch for another manager.
#[derive(Debug)]
pub(super) struct Rival {
    /// Time without frames of its own in which another manager would be noticed.
    listen: Duration,
    /// Time for which it counts as there after its last heartbeat.
    hold: Duration,
    /// Most delay of a poll without missing a heartbeat.
    slack: Duration,
    stage: Takeover,
    /// First and last arrival of its heartbeat; `None` while this manager is alone.
    received: Option<(Tick, Tick)>,
    /// Time of the last report of it.
    reported: Option<Tick>,
}

impl Rival {
    pub fn new(timing: &Timing) -> Self {
        // Four periods: it may be another line's, and a little slower, and a frame may be lost.
        let listen = timing.heartbeat * 4;
        Rival {
            listen,
            hold: timing.heartbeat_timeout.max(listen),
            slack: timing.heartbeat,
            stage: Takeover::Before,
            received: None,
            reported: None,
        }
    }

    /// Whether this manager sends nothing.
    pub fn is_mute(&self) -> bool {
        !matches!(self.stage, Takeover::Young { .. } | Takeover::Settled)
    }

    /// Whether this manager has ever sent anything.
    pub fn has_sent(&self) -> bool {
        !matches!(self.stage, Takeover::Before | Takeover::Listening { .. } | Takeover::Yielded { has_sent: false })
    }

    /// Since when another one has been there.
    pub fn since(&self) -> Option<Tick> {
        self.received.map(|(began, _)| began)
    }

    /// Advances time; whether this manager may send now. `on_the_bus`: whether frames could have been received.
    fn may_send(&mut self, now: Tick, on_the_bus: bool) -> bool {
        match self.stage {
            Takeover::Before => self.stage = Takeover::Listening { until: now + self.listen },
            Takeover::Listening { until } if until > now => {}
            Takeover::Listening { .. } if !on_the_bus => self.stage = Takeover::Listening { until: now + self.listen },
            Takeover::Listening { until } if until + self.slack <= now => {
                self.stage = Takeover::Listening { until: now + self.slack };
            }
            Takeover::Listening { .. } => self.stage = Takeover::Young { until: now + self.listen },
            Takeover::Young { until } if until <= now => self.stage = Takeover::Settled,
            Takeover::Young { .. } | Takeover::Settled | Takeover::Yielded { .. } => {}
        }
        !self.is_mute()
    }

    /// When time alone changes something; `None` before the first look, which is due at once.
    pub fn deadline(&self) -> Option<Tick> {
        Some(match self.stage {
            Takeover::Before => return None,
            Takeover::Listening { until } => until,
            Takeover::Yielded { .. } => Tick::NEVER,
            Takeover::Young { .. } | Takeover::Settled => {
                self.received.map_or(Tick::NEVER, |(_, last)| last + self.hold)
            }
        })
    }

    /// Why no device may be read or ordered at `now`, if so.
    pub fn keeps_off(&self, now: Tick) -> Option<String> {
        self.explain(now).or_else(|| self.is_mute().then(|| STILL_LISTENING.to_owned()))
    }

    /// In one sentence, if another one is there at `now`.
    pub fn explain(&self, now: Tick) -> Option<String> {
        Some(other_manager(now.since(self.since()?)))
    }
}

impl Manager {
    /// Whether this manager has to end, because another one drives its bus; if so, whether it ever sent anything there.
    pub fn yields(&self) -> Option<bool> {
        match self.rival.stage {
            Takeover::Yielded { has_sent } => Some(has_sent),
            _ => None,
        }
    }

    /// Takes the heartbeat of another manager.
    pub(super) fn hear_rival(&mut self, now: Tick, out: &mut BusOutbox) {
        let rival = &mut self.rival;
        if let Takeover::Yielded { .. } = rival.stage {
            return;
        }
        let begins = rival.received.is_none();
        rival.received = Some((rival.since().unwrap_or(now), now));
        if rival.reported.is_none_or(|reported| reported + REPORTED_EVERY <= now) {
            rival.reported = Some(now);
            out.events.push(BusEvent::AnotherManager);
        }
        let has_sent = rival.has_sent();
        if !matches!(rival.stage, Takeover::Settled) {
            rival.stage = Takeover::Yielded { has_sent };
        }
        if begins && has_sent {
            self.cut_off_all(now, out);
            // Outputs may be on whatever this manager assumes: every device is sent its rest values.
            for peer in &self.peers {
                peer.send_rest(out);
            }
        }
    }

    /// Takes a frame while nothing may be sent: of other managers, and of devices that only send.
    pub(super) fn listen(&mut self, now: Tick, frame: &Frame, out: &mut BusOutbox) {
        if self.take_plain(now, frame, out) {
            return;
        }
        match CanopenMessage::decode(frame) {
            Ok(CanopenMessage::Heartbeat { node, .. }) if node == MANAGER_NODE => self.hear_rival(now, out),
            Err(error) => self.undecodable(now, error, *frame, out),
            Ok(_) => {}
        }
    }

    /// Advances the watch for another manager: whether this one may send anything at all.
    pub(super) fn may_send(&mut self, now: Tick, out: &mut BusOutbox) -> bool {
        if !self.rival.may_send(now, self.off.is_none()) {
            return false;
        }
        if self.rival.received.is_some_and(|(_, last)| last + self.rival.hold <= now) {
            self.rival.received = None;
            out.events.push(BusEvent::AloneAgain);
            self.bring_back(now, out);
        }
        true
    }
}
