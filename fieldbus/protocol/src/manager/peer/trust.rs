//! Why an operational device is not trusted: errors of its own, channels without a measurement, too many frames.

use linewright_line::Tick;

use super::super::RETRY;
use super::super::event::{BusEvent, BusOutbox};
use super::super::fault::IgnoreReason;
use super::super::rate_limit::RateVerdict;
use super::{NotOperationalReason, Peer, PeerChange, PeerPhase};
use crate::codec::{BUS_OFF_RECOVERED, Emergency, HEARTBEAT_LOST};

impl Peer {
    pub(in crate::manager) fn emergency(&mut self, now: Tick, emergency: Emergency, out: &mut BusOutbox) -> PeerChange {
        self.report(now, BusEvent::Emergency { node: self.node, emergency, profile: self.process.profile() }, out);
        // It has let go of its outputs because it missed the manager's heartbeat; its own next heartbeat would show it,
        // later. While it was away it may have booted unheard, so it is not started as it is.
        if matches!(emergency.code, HEARTBEAT_LOST | BUS_OFF_RECOVERED) && self.is_operational() {
            let outcome = self.leave(now, PeerPhase::Stopped, NotOperationalReason::Reported(emergency));
            self.boot(now, out);
            return outcome;
        }
        self.process.emergency(now, emergency.code);
        let stood = self.errors.stand();
        self.errors.take(now, emergency);
        self.send_if_wanted(now, out);
        match (stood, self.errors.stand()) {
            (false, true) if self.is_operational() => PeerChange::Lost,
            (true, false) => PeerChange::Inputs,
            _ => PeerChange::Unchanged,
        }
    }

    /// Its error register has been read, or not. Whether it can be trusted has changed by that.
    pub(in crate::manager) fn register_read(&mut self, now: Tick, register: Option<u8>, out: &mut BusOutbox) -> bool {
        let Some(register) = register else { return false };
        let news = self.errors.register(now, register);
        if news {
            self.report(now, BusEvent::ErrorRegister { node: self.node, register }, out);
        }
        news
    }

    /// Checks its channels again: whether they are received and measured, and the effect if that has changed.
    pub(in crate::manager) fn judge_channels(&mut self, now: Tick, out: &mut BusOutbox) -> PeerChange {
        if !self.is_operational() {
            return PeerChange::Unchanged;
        }
        let Some(channels) = self.process.channels_mut() else { return PeerChange::Unchanged };
        let mended = channels.mend(now);
        match channels.news(now) {
            // One with an input of its own for it.
            None if mended => PeerChange::Inputs,
            None => PeerChange::Unchanged,
            Some(Ok(())) => PeerChange::Inputs,
            Some(Err(fault)) => {
                out.events.push(BusEvent::ChannelFault { node: self.node, fault });
                PeerChange::Lost
            }
        }
    }

    /// Takes an unsolicited frame of the device, unless there are too many of them.
    pub(in crate::manager) fn unless_babbling(
        &mut self,
        now: Tick,
        out: &mut BusOutbox,
        act: impl FnOnce(&mut Peer, &mut BusOutbox) -> PeerChange,
    ) -> PeerChange {
        match self.flood.count(now) {
            RateVerdict::Fine => act(self, out),
            RateVerdict::Begins => {
                out.events.push(BusEvent::Babbles { node: self.node });
                self.send_rest(out);
                self.leave(now, PeerPhase::Absent { probe: now + RETRY }, NotOperationalReason::Babbled)
            }
            RateVerdict::TooMuch => PeerChange::Ignored(IgnoreReason::Babbling),
        }
    }

    /// Reports something, unless there was too much of it.
    pub(in crate::manager) fn report(&mut self, now: Tick, event: BusEvent, out: &mut BusOutbox) {
        if self.reports.take(now) {
            out.events.push(event);
        }
    }
}
