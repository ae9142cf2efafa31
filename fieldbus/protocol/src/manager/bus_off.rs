//! The manager's own interface has left the bus.
//!
//! After too many errors a CAN controller switches itself off (bus-off) and neither sends nor receives until it is
//! restarted; the kernel reports it by error frames. Devices are then lost at once, for that reason and not for two
//! hundred milliseconds of silence: their frames would not be received. Nothing has to be restarted here afterwards.
//! The first frame received, or the kernel's report, ends it; every output is let go before anything else, since a
//! device that waits longer for its manager than the interruption lasted still has the outputs from before; and every
//! device is brought up as one that was lost.

use linewright_line::Tick;

use super::peer::{NotOperationalReason, PeerPhase};
use super::{BusOutbox, Manager, RETRY};
use crate::frame::{BUS_OFF, RESTARTED};

impl Manager {
    /// Since when the interface has been off the bus; `None` while it is on it.
    pub fn off_the_bus(&self) -> Option<Tick> {
        self.off
    }

    /// The kernel reports these error classes.
    pub(super) fn bus_error(&mut self, now: Tick, class: u32, out: &mut BusOutbox) {
        if class & BUS_OFF != 0 {
            if self.off.is_some() {
                return;
            }
            self.off = Some(now);
            self.cut_off_all(now, out);
        }
        if class & RESTARTED != 0 {
            self.back_on_the_bus(now, out);
        }
    }

    /// The interface is on the bus: a frame has been received.
    pub(super) fn back_on_the_bus(&mut self, now: Tick, out: &mut BusOutbox) {
        if self.off.take().is_none() || self.rival.is_mute() {
            return;
        }
        self.bring_back(now, out);
    }

    /// From here on the state of every device is unknown, and every output is let go.
    pub(super) fn cut_off_all(&mut self, now: Tick, out: &mut BusOutbox) {
        let why = if self.off.is_some() { NotOperationalReason::BusOff } else { NotOperationalReason::Contested };
        for at in 0..self.peers.len() {
            let outcome = self.peers[at].leave(now, PeerPhase::Absent { probe: now + RETRY }, why);
            self.settle(now, at, outcome, out);
        }
        // Also of owners without CANopen devices: these may be silent for longer than the bus was off.
        for owner in self.images.iter().map(|image| image.owner).collect::<Vec<_>>() {
            self.let_go(now, owner, out);
            self.gather(now, owner, out);
        }
    }

    /// Every output is let go, and every device brought up as one that was lost.
    pub(super) fn bring_back(&mut self, now: Tick, out: &mut BusOutbox) {
        self.next_heartbeat = Some(now);
        for peer in &mut self.peers {
            peer.send_rest(out);
            peer.ask_soon(now);
        }
        for owner in self.images.iter().map(|image| image.owner).collect::<Vec<_>>() {
            self.gather(now, owner, out);
        }
    }
}
