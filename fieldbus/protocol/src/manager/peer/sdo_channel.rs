//! The one SDO channel of a device: what the manager writes there while the device runs, and what requests may do with it.

use linewright_line::Tick;

use super::super::event::BusOutbox;
use super::super::transfer::Transfer;
use super::{Peer, PeerPhase};
use crate::sdo::wire::SdoBytes;
use crate::sdo::{Abort, TransferFailure, TransferProgress};

/// Whether a request may use a device's SDO channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::manager) enum SdoChannelState {
    /// Now.
    Free,
    /// Later: the manager has something to do there.
    Busy,
    /// Without an answer.
    None,
}

impl Peer {
    /// Whether a transfer of it has segments of a block to send.
    pub(in crate::manager) fn streams(&self) -> bool {
        match &self.phase {
            PeerPhase::Booting(boot) => boot.transfer().streams(),
            _ => self.writing.as_ref().is_some_and(|(_, transfer)| transfer.streams()),
        }
    }

    /// Sends one of them.
    pub(in crate::manager) fn stream(&mut self, now: Tick, out: &mut BusOutbox) {
        match &mut self.phase {
            PeerPhase::Booting(boot) => boot.transfer_mut().stream(now, &mut out.frames),
            _ => {
                if let Some((_, transfer)) = &mut self.writing {
                    transfer.stream(now, &mut out.frames);
                }
            }
        }
    }

    /// Writes an object that it needs written while it runs.
    pub(in crate::manager) fn write_if_wanted(&mut self, now: Tick, out: &mut BusOutbox) {
        if self.writing.is_some() || self.lent || self.errors.is_reading() || !self.is_operational() {
            return;
        }
        if let Some(setting) = self.process.wants_write() {
            let transfer = Transfer::write(now, self.node, &setting, &mut out.frames);
            self.writing = Some((setting, transfer));
        }
    }

    /// Goes on with that: with what the device has answered, or with the time that has passed.
    pub(in crate::manager) fn go_on_writing(&mut self, now: Tick, raw: Option<&SdoBytes>, out: &mut BusOutbox) {
        let Some((_, transfer)) = &mut self.writing else { return };
        let progress = match raw {
            Some(raw) => transfer.handle(now, raw, &mut out.frames),
            None => transfer.poll(now, &mut out.frames),
        };
        if let TransferProgress::Done(result) = progress
            && let Some((setting, _)) = self.writing.take()
        {
            let answer = result.map(|_| ()).map_err(|error| match error.cause {
                TransferFailure::Refused(code) => code,
                other => other.abort().unwrap_or(Abort::GENERAL),
            });
            self.process.written(now, &setting, answer);
        }
    }

    /// Whether a request may use its SDO channel.
    pub(in crate::manager) fn channel(&self) -> SdoChannelState {
        match self.phase {
            // A stopped device answers no SDO (CiA 301 §7.3.2.2.4).
            PeerPhase::Absent { .. } | PeerPhase::Stopped => SdoChannelState::None,
            PeerPhase::Booting(_) => SdoChannelState::Busy,
            _ if self.lent || self.writing.is_some() || self.errors.want_channel() => SdoChannelState::Busy,
            PeerPhase::Refused { .. } | PeerPhase::Starting { .. } | PeerPhase::Operational => SdoChannelState::Free,
        }
    }

    /// The channel is the manager's again; its delayed transfers come first.
    pub(in crate::manager) fn give_back(&mut self, now: Tick, out: &mut BusOutbox) {
        self.lent = false;
        if self.writing.is_none() && self.is_operational() {
            self.errors.ask(now, self.node, &mut out.frames);
        }
        self.write_if_wanted(now, out);
    }
}
