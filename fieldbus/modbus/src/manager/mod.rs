//! The manager of a node's Modbus devices.
//!
//! Each device has a connection of its own and one request at a time. There is no heartbeat in Modbus: the device is
//! alive because it answers, and it lets go of its outputs by itself only if it has a watchdog register, which is
//! written with another number in each cycle.

mod peer;
mod words;

use std::time::Duration;

use linewright_fieldbus_seam::{Answer, BusRefusal, BusReply, BusTarget, InputImage, News, abort};
use linewright_line::{Device, DeviceKind, Owner, Tick};

use crate::message::{ModbusFailure, ModbusRequest};
use crate::texts::ModbusServiceReply;
use peer::ModbusPeer;

/// Task of one connection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkAct {
    /// Index of the device.
    pub device: usize,
    /// Number of that device's connection: outcomes of older ones are ignored.
    pub link: u32,
    pub what: LinkTask,
}

/// Task of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkTask {
    /// To be made.
    Connect,
    /// To send this request and bring the answer.
    Ask(ModbusRequest),
    /// To be closed, whatever it is doing; before that, to send this without waiting for the answer.
    Close {
        /// Request that turns the outputs off.
        last: Option<ModbusRequest>,
    },
}

/// Outcome from a connection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LinkOutcome {
    Connected,
    Read(u64),
    Written,
    Failed(ModbusFailure),
}

/// Tasks of connections, in order, and reports.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModbusOutbox {
    pub acts: Vec<LinkAct>,
    pub news: Vec<News>,
    /// Results of requests.
    pub answers: Vec<(u64, Answer)>,
}

struct OwnerImage {
    owner: Owner,
    /// Image last set by the owner; zero from the start and after every loss.
    outputs: u128,
    inputs: InputImage,
}

/// The manager of a node's Modbus devices.
pub struct ModbusManager {
    peers: Vec<ModbusPeer>,
    images: Vec<OwnerImage>,
    requests: u64,
    has_ended: bool,
}

/// Change of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ModbusChange {
    Nothing,
    /// It has sent its inputs, or has come up.
    Inputs,
    /// It has ceased to be operational.
    Lost,
}

impl ModbusManager {
    /// The manager of the Modbus devices among these. Nothing is done before the first [`ModbusManager::poll`].
    pub fn new<'a>(devices: impl IntoIterator<Item = &'a Device>) -> Self {
        let mut peers = Vec::new();
        let mut images: Vec<OwnerImage> = Vec::new();
        for device in devices {
            let DeviceKind::Modbus(modbus) = &device.kind else { continue };
            if !images.iter().any(|image| image.owner == device.owner) {
                images.push(OwnerImage { owner: device.owner, outputs: 0, inputs: InputImage::NEVER });
            }
            peers.push(ModbusPeer::new(peers.len(), &device.name, device.owner, modbus));
        }
        ModbusManager { peers, images, requests: 0, has_ended: false }
    }

    /// Takes what a connection has brought at `now`.
    pub fn handle(&mut self, now: Tick, device: usize, link: u32, outcome: LinkOutcome, out: &mut ModbusOutbox) {
        let Some(peer) = self.peers.get_mut(device).filter(|peer| peer.link == link) else { return };
        let change = peer.take(now, outcome, out);
        self.settle(now, device, change, out);
        self.peers[device].go_on(now, out);
    }

    /// Does what is due at `now`: connecting, requests, missing answers.
    pub fn poll(&mut self, now: Tick, out: &mut ModbusOutbox) {
        if self.has_ended {
            return;
        }
        for at in 0..self.peers.len() {
            let change = self.peers[at].poll(now, out);
            self.settle(now, at, change, out);
            self.peers[at].go_on(now, out);
        }
    }

    /// When [`ModbusManager::poll`] has something to do next; [`Tick::NEVER`] without devices.
    pub fn next_deadline(&self) -> Tick {
        if self.has_ended {
            return Tick::NEVER;
        }
        self.peers.iter().map(ModbusPeer::deadline).min().unwrap_or(Tick::NEVER)
    }

    /// Sets the output image of `owner`: bit `i` is its output `i`. What changes is written with the next request, and all of
    /// it again in each cycle.
    ///
    /// A device that is not operational gets nothing, and once it is operational again the image set *since*.
    pub fn set_outputs(&mut self, now: Tick, owner: Owner, image: u128, out: &mut ModbusOutbox) {
        let Some(own) = self.images.iter_mut().find(|own| own.owner == owner) else { return };
        if self.has_ended {
            return;
        }
        own.outputs = image;
        for peer in self.peers.iter_mut().filter(|peer| peer.owner == owner) {
            peer.want(image);
            peer.go_on(now, out);
        }
    }

    /// Lets go of every output and closes every connection, for an orderly end. Nothing is done after it.
    pub fn release_outputs(&mut self, out: &mut ModbusOutbox) {
        self.has_ended = true;
        for image in &mut self.images {
            image.outputs = 0;
            image.inputs.valid = false;
        }
        for peer in &mut self.peers {
            peer.close(out);
        }
    }

    /// For each device, what turns its outputs off.
    pub fn last_requests(&self) -> impl Iterator<Item = Option<ModbusRequest>> {
        self.peers.iter().map(ModbusPeer::rest)
    }

    /// For each device, its address, its unit, and how long an answer may take.
    pub fn addresses(&self) -> impl Iterator<Item = (&str, u8, Duration)> {
        self.peers.iter().map(|peer| (peer.modbus.address.as_str(), peer.modbus.unit, peer.modbus.timeout))
    }

    /// The inputs of `owner` as they stand at `now`; `None` if none of its devices is here.
    pub fn inputs(&self, now: Tick, owner: Owner) -> Option<InputImage> {
        let image = self.images.iter().find(|image| image.owner == owner)?.inputs;
        // Checked again here, so that a caller that polls late does not read a dead device as a live one.
        Some(InputImage { valid: image.valid && self.are_trusted(now, owner), ..image })
    }

    fn are_trusted(&self, now: Tick, owner: Owner) -> bool {
        self.peers.iter().filter(|peer| peer.owner == owner).all(|peer| peer.is_trusted(now))
    }

    /// Effect of a change of one device on its owner's images.
    fn settle(&mut self, now: Tick, at: usize, change: ModbusChange, out: &mut ModbusOutbox) {
        let owner = self.peers[at].owner;
        let Some(image) = self.images.iter_mut().find(|image| image.owner == owner) else { return };
        match change {
            ModbusChange::Nothing => return,
            ModbusChange::Inputs => self.peers[at].want(image.outputs),
            ModbusChange::Lost => {}
        }
        let is_invalid_now = self.gather(now, owner, out);
        if change == ModbusChange::Lost || is_invalid_now {
            self.let_go(now, owner, out);
        }
    }

    /// Turns all outputs of an owner off: they were set before a loss was known.
    fn let_go(&mut self, now: Tick, owner: Owner, out: &mut ModbusOutbox) {
        self.images.iter_mut().filter(|image| image.owner == owner).for_each(|image| image.outputs = 0);
        for peer in self.peers.iter_mut().filter(|peer| peer.owner == owner) {
            peer.want(0);
            peer.go_on(now, out);
        }
    }

    /// Recomputes an owner's input image, and reports a change. True if the image was valid and is not.
    fn gather(&mut self, now: Tick, owner: Owner, out: &mut ModbusOutbox) -> bool {
        let valid = self.are_trusted(now, owner);
        let peers = || self.peers.iter().filter(|peer| peer.owner == owner);
        let bits = peers().map(ModbusPeer::input_bits).fold(0, |all, bits| all | bits);
        let updated = peers().filter_map(|peer| peer.updated).max();
        let Some(image) = self.images.iter_mut().find(|image| image.owner == owner) else { return false };
        let before = image.inputs;
        image.inputs = before.followed_by(now, bits, valid, updated);
        if (before.bits, before.valid) != (bits, valid) {
            out.news.push(News::InputsChanged { owner });
        }
        before.valid && !valid
    }

    /// Sends a request to a device; the answer is in the outbox at once. `None` if it is not one of these.
    pub fn ask(
        &mut self,
        now: Tick,
        target: &BusTarget,
        request: linewright_fieldbus_seam::BusRequest,
        out: &mut ModbusOutbox,
    ) -> Option<u64> {
        use linewright_fieldbus_seam::BusRequest as Asked;
        let BusTarget::Device(name) = target else { return None };
        let at = self.peers.iter().position(|peer| peer.name == *name)?;
        self.requests += 1;
        let done = |reply: ModbusServiceReply| Ok(BusReply { value: Vec::new(), text: reply.text().to_owned() });
        let answer = match request {
            Asked::Reset => {
                let change = self.peers[at].reset(now, out);
                self.settle(now, at, change, out);
                done(ModbusServiceReply::Reset)
            }
            Asked::Start if self.peers[at].is_operational() => done(ModbusServiceReply::Started),
            Asked::Start => {
                self.peers[at].retry_now(now);
                done(ModbusServiceReply::TriedAgain)
            }
            Asked::Read(_) | Asked::Write { .. } => Err(BusRefusal {
                text: format!("{target}, {request}: {}", ModbusServiceReply::NoObjects.text()),
                code: abort::UNSUPPORTED,
            }),
        };
        out.answers.push((self.requests, answer));
        out.news.push(News::Answered);
        Some(self.requests)
    }
}
