//! Simulated devices without a manager, from power-on, driven by frames as candump prints them.

use std::time::Duration;

use linewright_canopen::sdo::{Abort, ObjectId, SdoClient, TransferFailure, TransferOptions, TransferProgress};
use linewright_canopen::{CanopenMessage, Frame, NodeId};
use linewright_line::Tick;
use linewright_plant::{CanDevice, DeviceOutbox, Rack};

/// A device, or several.
pub trait OnBus {
    fn handle(&mut self, now: Tick, frame: &Frame, out: &mut Vec<Frame>);
    fn poll(&mut self, now: Tick, out: &mut Vec<Frame>);
    fn next_deadline(&self) -> Option<Tick>;
}

impl<D: CanDevice + ?Sized> OnBus for Box<D> {
    fn handle(&mut self, now: Tick, frame: &Frame, out: &mut Vec<Frame>) {
        let mut outbox = DeviceOutbox::default();
        (**self).handle(now, frame, &mut outbox);
        out.append(&mut outbox.frames);
    }

    fn poll(&mut self, now: Tick, out: &mut Vec<Frame>) {
        let mut outbox = DeviceOutbox::default();
        (**self).poll(now, &mut outbox);
        out.append(&mut outbox.frames);
    }

    fn next_deadline(&self) -> Option<Tick> {
        (**self).next_deadline()
    }
}

impl OnBus for Rack {
    fn handle(&mut self, now: Tick, frame: &Frame, out: &mut Vec<Frame>) {
        Rack::handle(self, now, frame, out);
    }

    fn poll(&mut self, now: Tick, out: &mut Vec<Frame>) {
        Rack::poll(self, now, out);
    }

    fn next_deadline(&self) -> Option<Tick> {
        Rack::next_deadline(self)
    }
}

pub struct Alone<D> {
    pub device: D,
    /// The node that is read and written.
    node: NodeId,
    pub now: Tick,
    pub out: Vec<Frame>,
}

impl<D: OnBus> Alone<D> {
    /// Switched on now.
    pub fn new(node: u8, device: impl FnOnce(Tick, NodeId) -> D) -> Self {
        let (now, node) = (Tick::from_millis(1000), NodeId::new(node).expect("a node id"));
        Alone { device: device(now, node), node, now, out: Vec::new() }
    }

    /// Pre-operational, and what it sent until then is forgotten.
    pub fn booted(node: u8, device: impl FnOnce(Tick, NodeId) -> D) -> Self {
        let mut alone = Alone::new(node, device);
        alone.pass(20);
        alone.out.clear();
        alone
    }

    /// Operational, the same.
    pub fn started(node: u8, device: impl FnOnce(Tick, NodeId) -> D) -> Self {
        let mut alone = Alone::booted(node, device);
        alone.hear(&format!("000#01{node:02X}"));
        alone.out.clear();
        alone
    }

    pub fn pass(&mut self, millis: u64) {
        let until = self.now + Duration::from_millis(millis);
        while let Some(due) = self.device.next_deadline().filter(|due| *due <= until) {
            self.now = due;
            self.device.poll(due, &mut self.out);
        }
        self.now = until;
    }

    pub fn hear(&mut self, text: &str) {
        self.device.handle(self.now, &text.parse().expect("a frame"), &mut self.out);
    }

    /// Frames sent since the last call.
    pub fn take(&mut self) -> Vec<String> {
        std::mem::take(&mut self.out).iter().map(Frame::to_string).collect()
    }

    /// The same without heartbeats.
    pub fn news(&mut self) -> Vec<String> {
        let beat = format!("{:03X}", 0x700 + u16::from(self.node.get()));
        self.take().into_iter().filter(|text| !text.starts_with(&beat)).collect()
    }

    /// Answer on its SDO channel to a frame.
    pub fn ask(&mut self, text: &str) -> String {
        self.out.clear();
        self.hear(text);
        let id = format!("{:03X}", 0x580 + u16::from(self.node.get()));
        self.take().into_iter().find(|frame| frame.starts_with(&id)).unwrap_or_default()
    }

    /// Carries out a transfer. No time passes, except where one side waits.
    pub fn transfer(&mut self, mut client: SdoClient) -> Result<Vec<u8>, TransferFailure> {
        let node = self.node;
        let mut requests = Vec::new();
        client.start(self.now, &mut requests);
        let mut result = None;
        loop {
            let mut out = Vec::new();
            for raw in requests.drain(..) {
                self.device.handle(self.now, &CanopenMessage::SdoRequest { node, raw }.encode(), &mut out);
            }
            if let Some(result) = result {
                self.out.append(&mut out);
                return result;
            }
            let mut progress = TransferProgress::Busy;
            if out.is_empty() {
                let deadlines = client.next_deadline().into_iter().chain(self.device.next_deadline());
                self.now = deadlines.min().expect("somebody waits").max(self.now);
                self.device.poll(self.now, &mut out);
                progress = client.poll(self.now, &mut requests);
            }
            for frame in out {
                match CanopenMessage::decode(&frame) {
                    Ok(CanopenMessage::SdoResponse { raw, .. }) if progress == TransferProgress::Busy => {
                        progress = client.handle(self.now, &raw, &mut requests);
                    }
                    _ => self.out.push(frame),
                }
            }
            if let TransferProgress::Done(ended) = progress {
                result = Some(ended.map_err(|error| error.cause));
            }
        }
    }

    pub fn read(&mut self, object: &str) -> Result<Vec<u8>, TransferFailure> {
        self.transfer(SdoClient::upload(object.parse().expect("an object"), TransferOptions::default()))
    }

    pub fn write(&mut self, object: &str, data: &[u8]) -> Result<(), TransferFailure> {
        let object: ObjectId = object.parse().expect("an object");
        self.transfer(SdoClient::download(object, data, TransferOptions::default())).map(|_| ())
    }
}

pub fn refused<T>(code: Abort) -> Result<T, TransferFailure> {
    Err(TransferFailure::Refused(code))
}
