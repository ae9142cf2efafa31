//! SYNC: the manager sends it (CiA 301 §7.2.5), and tells devices what waits for it.
//!
//! A device that hears no SYNC keeps its outputs, whatever it is sent, and hears every heartbeat of a manager that is
//! alive: its own watch of the manager does not help. Two things do. It is told how often SYNC comes (object 1006h), so
//! that it can take its absence for an error, if it is one of those that do. And its inputs must come with SYNC as well
//! (the description's rules see to that): when they stop, the manager stops the device, by which its outputs take their
//! error values, and brings it up anew. One that loses SYNC again and again has a cause that bringing it up does not
//! mend, and is not worth a boot every few hundred milliseconds: after the third time it stays stopped, and is tried again
//! like one that was refused.

use std::time::Duration;

use linewright_line::{Device, DeviceSetup, Tick, Timing};

use super::boot::{BootError, REFUSED_RETRY};
use super::event::BusEvent;
use super::not_operational::NotOperationalReason;
use super::peer::{Peer, PeerChange, PeerPhase};
use super::{BusOutbox, Manager};
use crate::codec::{CanopenMessage, NmtCommand};
use crate::sdo::SdoWrite;

/// So many frames of inputs in a row may be missing.
const MISSING: u32 = 3;
/// So often in a row SYNC may be lost.
const LOSSES: u32 = 3;
/// It has not been lost in a row when inputs came for so many times what they may stay away.
const CLEAR: u32 = 10;

/// How long inputs that come with SYNC may stay away: three frames, and no shorter than a heartbeat may.
pub(super) fn inputs_within(device: &Device, timing: &Timing) -> Option<Duration> {
    let every = device.canopen()?.setup.transmission.inputs_every()?;
    let period = timing.sync?;
    (!device.input_bits().is_empty()).then(|| (period * u32::from(every) * MISSING).max(timing.heartbeat_timeout))
}

/// What a device is told of SYNC before it is started.
pub(super) fn settings(setup: &DeviceSetup, timing: &Timing) -> Vec<SdoWrite> {
    let transmission = setup.transmission;
    let mut settings = Vec::new();
    if let Some(period) = timing.sync.filter(|_| transmission.is_synchronous()) {
        let micros = u32::try_from(period.as_micros()).unwrap_or(u32::MAX);
        // A device need not know how often SYNC comes: its inputs show whether it does.
        settings.push(SdoWrite { optional: true, ..SdoWrite::new(0x1006, 0, micros.to_le_bytes()) });
    }
    settings.extend(transmission.outputs.map(|kind| SdoWrite::new(0x1400, 2, [kind])));
    settings.extend(transmission.inputs.map(|kind| SdoWrite::new(0x1800, 2, [kind])));
    settings
}

impl Peer {
    /// When inputs that come with SYNC are missed.
    pub(super) fn misses_inputs_at(&self) -> Tick {
        let last = self.updated.unwrap_or(self.up_since);
        self.inputs_within.map_or(Tick::NEVER, |within| last + within)
    }

    /// Inputs have come: after a while, what was before is no row any more.
    pub(super) fn hears_sync(&mut self, now: Tick) {
        if self.sync_losses > 0
            && self.is_operational()
            && self.inputs_within.is_some_and(|within| self.up_since + within * CLEAR <= now)
        {
            self.sync_losses = 0;
        }
    }

    /// It hears no SYNC, so outputs that wait for one stay as they are whatever it is sent. It is stopped, by which they
    /// take their error values, and brought up anew, or left stopped for a while.
    pub(super) fn lose_sync(&mut self, now: Tick, out: &mut BusOutbox) -> PeerChange {
        let silent_for = now.since(self.updated.unwrap_or(self.up_since));
        out.events.push(BusEvent::NoSync { node: self.node, silent_for });
        self.sync_losses += 1;
        let outcome = self.leave(now, PeerPhase::Stopped, NotOperationalReason::NoSync);
        self.order(NmtCommand::Stop, out);
        if self.sync_losses < LOSSES {
            self.boot(now, out);
        } else {
            let why = BootError::NoSync { times: self.sync_losses };
            if self.sync_losses == LOSSES {
                out.events.push(BusEvent::BootFailed { node: self.node, why });
            }
            self.phase = PeerPhase::Refused { why, retry: now + REFUSED_RETRY };
        }
        outcome
    }
}

impl Manager {
    /// Sends SYNC if it is due. One that a late caller missed is not made up for.
    pub(super) fn send_sync(&mut self, now: Tick, out: &mut BusOutbox) {
        let Some(period) = self.timing.sync else { return };
        let due = *self.next_sync.get_or_insert(now);
        if due <= now {
            out.frames.push(CanopenMessage::Sync { counter: None }.encode());
            // In step with the last one, as long as it is no whole period late.
            self.next_sync = Some(if due + period > now { due + period } else { now + period });
        }
    }
}
