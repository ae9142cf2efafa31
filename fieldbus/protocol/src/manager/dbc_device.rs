//! A device without CANopen, as the manager sees it: messages that have to come in time, and messages it is sent.
//!
//! ```text
//!  Lost ──every page of every message has come──▶ Live
//!    ▲                                              │
//!    └────────── one has not come in time ──────────┘
//! ```
//!
//! There is no boot, no state to read and no heartbeat: only its messages show that the device is alive. A frame that
//! is too short, or has a wrong checksum, the counter of the one before it, or a value that is not a number, is
//! ignored. What it is sent goes out again and again from the beginning, with every output off until the device is
//! live, and at once when something changes. Nor does the device watch a heartbeat of the manager: to switch its
//! outputs off when these frames stop is up to the device.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_line::{Device, FrameBinding, FrameId, Owner, ReceivedFrameBinding, SentFrameBinding, Tick};

use super::channels::AnalogueChannels;
use super::event::{BusEvent, BusOutbox};
use super::fault::{FrameFault, IgnoreReason};
use super::peer::{Peer, PeerChange};
use super::texts::DbcDeviceText;
use super::{Manager, ManagerError};
use crate::frame::Frame;

/// State of a device without CANopen, as its manager has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DbcDeviceState<'a> {
    pub name: &'a str,
    pub owner: Owner,
    /// All its messages come in time, and make sense; true of one that is only sent to.
    pub live: bool,
    /// Something of it has come in time, whatever it was.
    pub received: bool,
    /// Number of times it was live and then was not.
    pub losses: u32,
    pub is: String,
}

struct ReceivedMessage {
    frame: ReceivedFrameBinding,
    counter: Option<u64>,
    /// For each page, when it last came, and which of its inputs are on.
    pages: Vec<(Option<Tick>, Vec<bool>)>,
    /// Time of the message's last arrival, faulty or not, and its fault.
    last: Option<(Tick, FrameFault)>,
}

struct PublishedMessage {
    frame: SentFrameBinding,
    due: Tick,
    /// Data last sent, without the counter.
    sent: Option<[u8; 8]>,
}

pub(super) struct DbcDevice {
    pub name: String,
    pub owner: Owner,
    received: Vec<ReceivedMessage>,
    published: Vec<PublishedMessage>,
    /// Number of times each message has been sent: in several forms it is one to the device.
    counts: BTreeMap<FrameId, u64>,
    live: bool,
    losses: u32,
    image: u128,
    updated: Option<Tick>,
}

impl DbcDevice {
    pub fn new(device: &Device, binding: &FrameBinding) -> Self {
        let received = |frame: &ReceivedFrameBinding| ReceivedMessage {
            frame: frame.clone(),
            counter: None,
            pages: frame.pages.iter().map(|page| (None, vec![false; page.inputs.len()])).collect(),
            last: None,
        };
        let published =
            |frame: &SentFrameBinding| PublishedMessage { frame: frame.clone(), due: Tick::ZERO, sent: None };
        DbcDevice {
            name: device.name.clone(),
            owner: device.owner,
            received: binding.heard.iter().map(received).collect(),
            published: binding.told.iter().map(published).collect(),
            counts: BTreeMap::new(),
            // A device that sends nothing counts as live.
            live: binding.heard.is_empty(),
            losses: 0,
            image: 0,
            updated: None,
        }
    }

    /// Identifiers of the messages it sends and receives.
    fn ids(&self) -> impl Iterator<Item = FrameId> {
        self.received
            .iter()
            .map(|received| received.frame.id)
            .chain(self.published.iter().map(|published| published.frame.id))
    }

    pub fn updated(&self) -> Option<Tick> {
        self.updated
    }

    pub fn trusted(&self, now: Tick) -> bool {
        self.live && self.late(now).is_none()
    }

    pub fn input_bits(&self) -> u128 {
        let pages = self.received.iter().flat_map(|received| received.frame.pages.iter().zip(&received.pages));
        let inputs = pages.flat_map(|(page, (_, on))| page.inputs.iter().zip(on));
        inputs.filter(|(_, on)| **on).fold(0, |bits, ((input, _, _), _)| bits | input.bit())
    }

    /// A message that has not come in time, how long it has not, and why.
    fn late(&self, now: Tick) -> Option<(&ReceivedMessage, Option<Duration>, FrameFault)> {
        self.received.iter().find_map(|received| {
            let timeout = received.frame.timeout;
            let stale = |at: &Option<Tick>| at.is_none_or(|at| at + timeout <= now);
            let (at, _) = received.pages.iter().find(|(at, _)| stale(at))?;
            let fault = match received.last {
                Some((last, fault)) if last + timeout > now => fault,
                _ => FrameFault::Silent,
            };
            Some((received, at.map(|at| now.since(at)), fault))
        })
    }

    /// Takes a frame, if it is one of this device's.
    fn take(&mut self, now: Tick, id: FrameId, frame: &Frame, out: &mut BusOutbox) -> Option<PeerChange> {
        let received = self.received.iter_mut().find(|received| received.frame.id == id)?;
        if let Err(fault) = received.take(now, frame) {
            received.last = Some((now, fault));
            return Some(if fault == FrameFault::Short {
                PeerChange::Ignored(IgnoreReason::ShortPdo)
            } else {
                PeerChange::Unchanged
            });
        }
        received.last = Some((now, FrameFault::Page));
        self.updated = Some(now);
        if self.live || self.late(now).is_some() {
            return Some(PeerChange::Inputs);
        }
        self.live = true;
        out.events.push(BusEvent::FramesUp { id });
        Some(PeerChange::Up)
    }

    /// Does what is due: detects silence, sends again.
    fn poll(&mut self, now: Tick, out: &mut BusOutbox) -> PeerChange {
        let mut outcome = PeerChange::Unchanged;
        if self.live
            && let Some((received, silent_for, why)) = self.late(now)
        {
            let (id, silent_for) = (received.frame.id, silent_for.unwrap_or_default());
            out.events.push(BusEvent::FramesLost { id, silent_for, why });
            self.live = false;
            self.losses += 1;
            self.image = 0;
            outcome = PeerChange::Lost;
        }
        let image = self.vouched();
        for published in &mut self.published {
            if published.due <= now {
                published.send(now, image, &mut self.counts, out);
            }
        }
        outcome
    }

    fn deadline(&self) -> Tick {
        let late = self.received.iter().filter(|_| self.live).flat_map(|received| {
            received.pages.iter().map(|(at, _)| at.map_or(Tick::NEVER, |at| at + received.frame.timeout))
        });
        late.chain(self.published.iter().map(|published| published.due)).fold(Tick::NEVER, Tick::min)
    }

    /// Takes the image its owner has set, and sends the changes.
    pub fn set_image(&mut self, now: Tick, image: u128, out: &mut BusOutbox) {
        self.image = image;
        self.send_changes(now, out);
    }

    /// Sends every message with everything off, whatever it was sent before.
    pub fn release(&mut self, now: Tick, out: &mut BusOutbox) {
        self.image = 0;
        for published in &mut self.published {
            published.send(now, 0, &mut self.counts, out);
        }
    }

    /// Frames that [`DbcDevice::release`] would send now.
    fn release_frames(&self, frames: &mut Vec<Frame>) {
        for (nth, published) in self.published.iter().enumerate() {
            // Forms of one message that come before it in the same go are counted as well.
            let before =
                self.published[..nth].iter().filter(|other| other.frame.id == published.frame.id).count() as u64;
            let count = self.counts.get(&published.frame.id).copied().unwrap_or_default();
            frames.extend(published.frame_of(0, count.wrapping_add(before)));
        }
    }

    fn send_changes(&mut self, now: Tick, out: &mut BusOutbox) {
        let image = self.vouched();
        for published in &mut self.published {
            if published.sent.is_some_and(|sent| sent != published.frame.bytes(image, 0)) {
                published.send(now, image, &mut self.counts, out);
            }
        }
    }

    /// The image that may be sent: none of it before the device is live.
    fn vouched(&self) -> u128 {
        if self.live { self.image } else { 0 }
    }

    pub fn explain(&self, now: Tick) -> String {
        match self.late(now) {
            None if self.received.is_empty() => DbcDeviceText::NotHeard.to_string(),
            None => DbcDeviceText::Live.to_string(),
            Some((received, since, why)) => {
                DbcDeviceText::Missing { message: &received.frame.name, id: received.frame.id, since, why }.to_string()
            }
        }
    }
}

impl ReceivedMessage {
    fn take(&mut self, now: Tick, frame: &Frame) -> Result<(), FrameFault> {
        let (bytes, definition) = (frame.data(), &self.frame);
        if bytes.len() < usize::from(definition.len) {
            return Err(FrameFault::Short);
        }
        let mut data = [0; 8];
        data[..bytes.len()].copy_from_slice(bytes);
        if let Some((at, checksum)) = definition.checksum
            && data[usize::from(at.min(7))] != checksum.of(&data, definition.len, at)
        {
            return Err(FrameFault::Checksum);
        }
        // Before anything of it is kept.
        if let Some(unsound) =
            definition.pages.iter().filter(|page| page.is_in(&data)).find_map(|page| page.unsound(&data))
        {
            return Err(FrameFault::Value(unsound));
        }
        if let Some(counter) = &definition.counter {
            let count = counter.get(&data);
            if self.counter.replace(count) == Some(count) {
                return Err(FrameFault::Counter);
            }
        }
        for (page, (seen, on)) in definition.pages.iter().zip(&mut self.pages) {
            if page.is_in(&data) {
                // After a silence, a value between two limits does not keep its earlier state.
                let goes_on = seen.replace(now).is_some_and(|last| now < last + definition.timeout);
                for ((_, field, when), on) in page.inputs.iter().zip(on) {
                    *on = when.holds(field, field.get(&data), goes_on && *on);
                }
            }
        }
        Ok(())
    }
}

impl PublishedMessage {
    fn send(&mut self, now: Tick, image: u128, counts: &mut BTreeMap<FrameId, u64>, out: &mut BusOutbox) {
        let count = counts.entry(self.frame.id).or_default();
        let frame = self.frame_of(image, *count);
        out.frames.extend(frame);
        *count = count.wrapping_add(1);
        self.sent = Some(self.frame.bytes(image, 0));
        self.due = now + self.frame.every;
    }

    /// By construction of the binding there is one.
    fn frame_of(&self, image: u128, count: u64) -> Option<Frame> {
        let data = self.frame.bytes(image, count);
        Frame::of_id(self.frame.id, &data[..usize::from(self.frame.len.min(8))])
    }
}

impl Manager {
    /// The frames that turn off every output of the plain CAN devices, as they would be sent now. CANopen devices turn theirs
    /// off when the manager's heartbeat is missing. Empty while this manager has not sent anything yet.
    pub fn release_frames(&self, frames: &mut Vec<Frame>) {
        if self.rival.has_sent() {
            self.plains.iter().for_each(|plain| plain.release_frames(frames));
        }
    }

    pub(super) fn add_plain(&mut self, device: &Device, binding: &FrameBinding) {
        let plain = DbcDevice::new(device, binding);
        for published in &plain.published {
            self.pace.treat_as_process_data(Frame::of_id(published.frame.id, &[]).map_or(0, |frame| frame.id_word()));
        }
        self.plains.push(plain);
    }

    /// That no identifier has two meanings on this bus.
    pub(super) fn check_ids(&self) -> Result<(), ManagerError> {
        for (nth, plain) in self.plains.iter().enumerate() {
            for id in plain.ids() {
                let refuse = |other: String| Err(ManagerError::FrameId { device: plain.name.clone(), id, other });
                if let Some(other) = self.plains[..nth].iter().find(|other| other.ids().any(|own| own == id)) {
                    return refuse(format!("device `{}`", other.name));
                }
                if plain.received.iter().any(|received| received.frame.id == id)
                    && plain.published.iter().any(|published| published.frame.id == id)
                {
                    return refuse("a message it is sent".to_owned());
                }
                if id.extended {
                    continue;
                }
                let node = id.id & 0x7F;
                let of_node = matches!(id.id & 0x780, 0x080 | 0x180 | 0x200 | 0x580 | 0x600 | 0x700);
                let of_channels = matches!(id.id & 0x780, 0x280 | 0x300 | 0x380 | 0x400 | 0x480 | 0x500);
                if id.id == 0 || id.id == 0x080 || id.id == 0x77F {
                    return refuse("the manager".to_owned());
                }
                let uses = |peer: &&Peer| {
                    of_node || of_channels && peer.process.channels().is_some_and(AnalogueChannels::is_any)
                };
                if let Some(peer) = self.peers.iter().filter(uses).find(|peer| u32::from(peer.node.get()) == node) {
                    return refuse(format!("device `{}`", peer.name));
                }
            }
        }
        Ok(())
    }

    /// Takes a frame of a device without CANopen; false if it is none.
    pub(super) fn take_plain(&mut self, now: Tick, frame: &Frame, out: &mut BusOutbox) -> bool {
        let Some(id) = frame.frame_id().filter(|_| !self.plains.is_empty()) else { return false };
        let Some((at, outcome)) =
            self.plains.iter_mut().enumerate().find_map(|(at, plain)| Some((at, plain.take(now, id, frame, out)?)))
        else {
            return false;
        };
        match outcome {
            PeerChange::Ignored(reason) => self.ignore(now, reason, *frame, out),
            outcome => self.settle_plain(now, at, outcome, out),
        }
        true
    }

    pub(super) fn poll_plain(&mut self, now: Tick, out: &mut BusOutbox) {
        for at in 0..self.plains.len() {
            let outcome = self.plains[at].poll(now, out);
            self.settle_plain(now, at, outcome, out);
        }
    }

    pub(super) fn plain_deadline(&self) -> Tick {
        self.plains.iter().map(DbcDevice::deadline).fold(Tick::NEVER, Tick::min)
    }

    /// Every device without CANopen as it is at `now`, in the order of the description.
    pub fn plain_statuses(&self, now: Tick) -> impl Iterator<Item = DbcDeviceState<'_>> {
        self.plains.iter().map(move |plain| DbcDeviceState {
            name: &plain.name,
            owner: plain.owner,
            live: plain.trusted(now),
            received: plain
                .received
                .iter()
                .any(|received| received.last.is_some_and(|(at, _)| now < at + received.frame.timeout)),
            losses: plain.losses,
            is: plain.explain(now),
        })
    }

    /// Effect of a change of one of them on its owner's images.
    fn settle_plain(&mut self, now: Tick, at: usize, outcome: PeerChange, out: &mut BusOutbox) {
        let owner = self.plains[at].owner;
        match outcome {
            PeerChange::Unchanged | PeerChange::Ignored(_) => return,
            PeerChange::Inputs => {}
            PeerChange::Up => self.plains[at].send_changes(now, out),
            // Its outputs are let go as well: it may still receive.
            PeerChange::Lost => self.let_go(now, owner, out),
        }
        self.gather(now, owner, out);
    }
}
