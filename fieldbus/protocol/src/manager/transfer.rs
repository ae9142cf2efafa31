//! One SDO transfer with one device, as the manager makes it: eight bytes in, frames out.

use std::time::Duration;

use linewright_line::Tick;

use crate::codec::{CanopenMessage, NodeId};
use crate::frame::Frame;
use crate::sdo::wire::SdoBytes;
use crate::sdo::{ObjectId, SdoClient, SdoWrite, TransferMode, TransferOptions, TransferProgress};

/// Most time for a device's answer. Half a second is slow for reading a dictionary, and quick for writing a flash
/// memory; the first frame is repeated once. Segments of blocks wait for [`Transfer::stream`].
const SDO: TransferOptions = TransferOptions {
    timeout: Duration::from_millis(500),
    retries: 1,
    mode: TransferMode::Auto,
    block_above: 64,
    burst: 0,
    len_max: 4096,
};

#[derive(Debug)]
pub(super) struct Transfer {
    node: NodeId,
    client: SdoClient,
    frames: Vec<SdoBytes>,
}

impl Transfer {
    pub fn read(now: Tick, node: NodeId, object: ObjectId, out: &mut Vec<Frame>) -> Self {
        Transfer::start(now, node, SdoClient::upload(object, SDO), out)
    }

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

    pub fn deadline(&self) -> Tick {
        self.client.next_deadline().unwrap_or(Tick::NEVER)
    }

    pub fn object(&self) -> ObjectId {
        self.client.object()
    }

    fn flush(&mut self, out: &mut Vec<Frame>) {
        let node = self.node;
        out.extend(self.frames.drain(..).map(|raw| CanopenMessage::SdoRequest { node, raw }.encode()));
    }
}
