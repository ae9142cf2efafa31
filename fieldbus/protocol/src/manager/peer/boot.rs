//! Booting a device: effects of the steps of a boot.

use std::time::Duration;

use linewright_line::Tick;

use super::super::RETRY;
use super::super::boot::{Boot, BootError, BootStep};
use super::super::event::{BusEvent, BusOutbox};
use super::super::texts::StartReply;
use super::{Peer, PeerPhase};
use crate::codec::NmtCommand;
use crate::sdo::TransferFailure;

/// Time until a refused device is looked at again. Seldom enough that a person reads the reason in peace, often enough
/// that a repair needs no further action.
pub(in crate::manager) const REFUSED_RETRY: Duration = Duration::from_secs(5);

impl Peer {
    pub(in crate::manager) fn order_start(&mut self, now: Tick, out: &mut BusOutbox) {
        self.phase = PeerPhase::Starting { retry: now + RETRY };
        if self.orders.take(now) {
            self.order(NmtCommand::Start, out);
        }
    }

    /// Begins, or begins again, to bring it up.
    pub(in crate::manager) fn boot(&mut self, now: Tick, out: &mut BusOutbox) {
        self.process.lost(now);
        self.lent = false;
        self.held = false;
        if !self.orders.take(now) {
            // It boots again and again: it is probed after a while, like one that is absent.
            self.phase = PeerPhase::Absent { probe: now + RETRY };
            return;
        }
        self.phase = PeerPhase::Booting(Boot::start(now, self.node, &mut out.frames));
    }

    /// Takes a step of its boot.
    pub(in crate::manager) fn booted(&mut self, now: Tick, step: BootStep, out: &mut BusOutbox) {
        let why = match step {
            BootStep::Busy => return,
            BootStep::Done(register) => {
                self.refusal = None;
                self.register_read(now, register, out);
                return self.order_start(now, out);
            }
            BootStep::Failed(why) => why,
        };
        if self.refusal != Some(why) {
            self.refusal = Some(why);
            out.events.push(BusEvent::BootFailed { node: self.node, why });
        }
        let silent = matches!(
            why,
            BootError::Transfer { error, .. } | BootError::NotReadBack(error) if matches!(error.cause, TransferFailure::Silent { .. })
        );
        self.phase = if silent && self.alive_at + self.timeout <= now {
            PeerPhase::Absent { probe: now + RETRY }
        } else {
            PeerPhase::Refused { why, retry: now + if silent { RETRY } else { REFUSED_RETRY } }
        };
    }

    /// Reads its device type at once, if it is absent.
    pub(in crate::manager) fn ask_soon(&mut self, now: Tick) {
        if let PeerPhase::Absent { probe } = &mut self.phase {
            *probe = now;
        }
    }

    /// Start on request. It never is started before it is identified and configured.
    pub(in crate::manager) fn start_by_request(&mut self, now: Tick, out: &mut BusOutbox) -> Result<String, String> {
        let text = self.explain(now);
        match self.phase {
            PeerPhase::Operational | PeerPhase::Starting { .. } => Ok(text),
            // Not as it is: its state since it was stopped is unknown. And a stopped device answers no SDO.
            PeerPhase::Stopped => {
                self.order(NmtCommand::EnterPreOperational, out);
                self.boot(now, out);
                Ok(StartReply::Woken.text(&text))
            }
            PeerPhase::Refused { .. } => {
                self.boot(now, out);
                Err(StartReply::LookedAtAgain.text(&text))
            }
            PeerPhase::Absent { .. } | PeerPhase::Booting(_) => Err(text),
        }
    }
}
