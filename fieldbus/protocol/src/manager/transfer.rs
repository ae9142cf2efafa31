//! One SDO transfer with one device, as the manager makes it: eight bytes in, frames out.

use std::time::Duration;

use linewright_line::Tick;

use super::event::BusOutbox;
use super::peer::{Peer, PeerPhase};
use crate::codec::{CanopenMessage, NodeId};
use crate::frame::Frame;
use crate::sdo::wire::SdoBytes;
use crate::sdo::{
    Abort, ObjectId, SdoClient, SdoWrite, TransferFailure, TransferMode, TransferOptions, TransferProgress,
};

/// How long a device may take for an answer. Half a second is slow for reading a dictionary, and quick for writing a
/// flash memory; the first frame is repeated once. Segments of blocks wait for [`Transfer::stream`].
const SDO: TransferOptions = TransferOptions {
    timeout: Duration::from_millis(500),
    retries: 1,
    mode: TransferMode::Auto,
    block_above: 64,
    burst: 0,
    len_max: 4096,
};

/// A transfer under way.
#[derive(Debug)]
pub(super) struct Transfer {
    node: NodeId,
    client: SdoClient,
    frames: Vec<SdoBytes>,
}

impl Transfer {
    /// Begins to read an object.
    pub fn read(now: Tick, node: NodeId, object: ObjectId, out: &mut Vec<Frame>) -> Self {
        Transfer::start(now, node, SdoClient::upload(object, SDO), out)
    }

    /// Begins to write one.
    pub fn write(now: Tick, node: NodeId, setting: &SdoWrite, out: &mut Vec<Frame>) -> Self {
        Transfer::start(now, node, SdoClient::download(setting.object, setting.data.clone(), SDO), out)
    }

    fn start(now: Tick, node: NodeId, client: SdoClient, out: &mut Vec<Frame>) -> Self {
        let mut transfer = Transfer { node, client, frames: Vec::new() };
        transfer.client.start(now, &mut transfer.frames);
        transfer.flush(out);
        transfer
    }

    /// Takes eight bytes of the device's SDO server.
    pub fn handle(&mut self, now: Tick, raw: &SdoBytes, out: &mut Vec<Frame>) -> TransferProgress {
        let progress = self.client.handle(now, raw, &mut self.frames);
        self.flush(out);
        progress
    }

    /// Does what is due.
    pub fn poll(&mut self, now: Tick, out: &mut Vec<Frame>) -> TransferProgress {
        let progress = self.client.poll(now, &mut self.frames);
        self.flush(out);
        progress
    }

    /// Whether it has segments of a block to send.
    pub fn streams(&self) -> bool {
        self.client.streams()
    }

    /// Sends one of them.
    pub fn stream(&mut self, now: Tick, out: &mut Vec<Frame>) {
        self.client.stream(now, 1, &mut self.frames);
        self.flush(out);
    }

    /// When [`Transfer::poll`] has something to do next.
    pub fn deadline(&self) -> Tick {
        self.client.next_deadline().unwrap_or(Tick::NEVER)
    }

    /// The object.
    pub fn object(&self) -> ObjectId {
        self.client.object()
    }

    fn flush(&mut self, out: &mut Vec<Frame>) {
        let node = self.node;
        out.extend(self.frames.drain(..).map(|raw| CanopenMessage::SdoRequest { node, raw }.encode()));
    }
}

impl Peer {
    /// Whether a transfer of it has segments of a block to send.
    pub(super) fn streams(&self) -> bool {
        match &self.phase {
            PeerPhase::Booting(boot) => boot.transfer().streams(),
            _ => self.writing.as_ref().is_some_and(|(_, transfer)| transfer.streams()),
        }
    }

    /// Sends one of them.
    pub(super) fn stream(&mut self, now: Tick, out: &mut BusOutbox) {
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
    pub(super) fn write_if_wanted(&mut self, now: Tick, out: &mut BusOutbox) {
        if self.writing.is_some() || self.lent || self.errors.is_reading() || !self.is_operational() {
            return;
        }
        if let Some(setting) = self.process.wants_write() {
            let transfer = Transfer::write(now, self.node, &setting, &mut out.frames);
            self.writing = Some((setting, transfer));
        }
    }

    /// Goes on with that: with what the device has answered, or with the time that has passed.
    pub(super) fn go_on_writing(&mut self, now: Tick, raw: Option<&SdoBytes>, out: &mut BusOutbox) {
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
}
