//! A device that loses SYNC; why that matters is in `manager/sync.rs`.

use linewright_line::Tick;

use super::super::boot::BootError;
use super::super::event::{BusEvent, BusOutbox};
use super::boot::REFUSED_RETRY;
use super::{NotOperationalReason, Peer, PeerChange, PeerPhase};
use crate::codec::NmtCommand;

/// So often in a row SYNC may be lost.
const LOSSES: u32 = 3;
/// Losses are no longer consecutive after inputs have come for this many times their time-out.
const CLEAR: u32 = 10;

impl Peer {
    /// When inputs that come with SYNC are missed.
    pub(in crate::manager) fn misses_inputs_at(&self) -> Tick {
        let last = self.updated.unwrap_or(self.up_since);
        self.inputs_within.map_or(Tick::NEVER, |within| last + within)
    }

    /// Inputs have come. A peer that has sent them long enough since it came up has no losses of SYNC in a row.
    pub(in crate::manager) fn sync_holds(&mut self, now: Tick) {
        if self.sync_losses > 0
            && self.is_operational()
            && self.inputs_within.is_some_and(|within| self.up_since + within * CLEAR <= now)
        {
            self.sync_losses = 0;
        }
    }

    /// It receives no SYNC, so outputs that wait for one stay as they are whatever it is sent. It is stopped, by which
    /// they take their error values, and brought up anew, or left stopped for a while.
    pub(in crate::manager) fn lose_sync(&mut self, now: Tick, out: &mut BusOutbox) -> PeerChange {
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
