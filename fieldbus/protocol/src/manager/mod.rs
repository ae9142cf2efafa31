//! The CANopen manager of one bus.
//!
//! Pure: it is called with the time and a frame, and fills an [`BusOutbox`] with frames to send and events to report.
//! It brings every device of the description up (configure, start), watches its heartbeat, and moves bits between the
//! devices' PDOs and their owners' process images. The meaning of a bit and whether a motion is allowed are not its
//! concern; it decides only which bits can be trusted.
//!
//! One rule stands above the others: **an output is energised only by an image that its owner set after the last time
//! one of the owner's devices was lost.** When a device is lost, reboots or leaves the operational state, the image is
//! forgotten and the owner's other devices get zero at once; what is then set again is set by a controller that was
//! informed of the loss.

mod boot;
mod build;
mod bus_off;
mod channels;
mod dbc_device;
mod device_request;
mod errors;
mod event;
mod fault;
mod not_operational;
mod on_error;
mod pace;
mod peer;
mod process;
mod protected_objects;
mod rate_limit;
mod request;
mod rival;
mod status;
mod sync;
mod texts;
mod transfer;

use std::time::Duration;

use linewright_fieldbus_seam::{Budget, InputImage};
use linewright_line::{Owner, Tick, Timing};

pub use boot::{BootError, BootStage};
pub use build::ManagerError;
pub use dbc_device::DbcDeviceState;
pub use device_request::{DeviceRequest, DeviceRequestError, RequestResult};
pub use event::{BusEvent, BusOutbox};
pub use fault::{ChannelFault, FrameFault, IgnoreReason};
pub use protected_objects::WriteProtection;
pub use status::{DeviceCondition, DeviceStatus};
pub use texts::{DbcDeviceText, StartReply};

use crate::codec::{CanopenMessage, FrameDecodeError, NmtState, NodeId};
use crate::frame::{Frame, FrameKind};
use dbc_device::DbcDevice;
use fault::IGNORE_REASONS;
use pace::SendQueue;
use peer::{Peer, PeerChange};
use request::Requests;
use rival::Rival;
use status::DeviceMemory;

/// The manager's own node id: the highest one, so that every device's traffic wins arbitration against it except its
/// network management orders, which have COB-ID 0.
pub const MANAGER_NODE: NodeId = match NodeId::new(127) {
    Some(node) => node,
    None => panic!("127 is a node id"),
};

struct ManagedImage {
    owner: Owner,
    /// Image last set by the owner; zero from the start and after every loss.
    outputs: u128,
    inputs: InputImage,
}

pub struct Manager {
    timing: Timing,
    peers: Vec<Peer>,
    /// Devices without CANopen.
    plains: Vec<DbcDevice>,
    /// Memory of each, in the same order.
    records: Vec<DeviceMemory>,
    requests: Requests,
    images: Vec<ManagedImage>,
    /// `None` until the first poll: nothing has been sent yet.
    next_heartbeat: Option<Tick>,
    next_sync: Option<Tick>,
    /// Since when the interface is off the bus.
    off: Option<Tick>,
    ignored: [u64; IGNORE_REASONS],
    pace: SendQueue,
    /// Next peer to send a segment of a block.
    turn: usize,
    /// Limits of the reports of ignored frames, by reason, and at the end of bus errors.
    reports: [Budget; IGNORE_REASONS + 1],
    rival: Rival,
}

impl Manager {
    /// Takes one frame received at `now`.
    pub fn handle(&mut self, now: Tick, frame: &Frame, out: &mut BusOutbox) {
        let (start, reported) = (out.frames.len(), out.events.len());
        self.pace.received(now);
        if self.rival.is_mute() {
            self.listen(now, frame, out);
            return self.pass(now, start, out);
        }
        self.take(now, frame, out);
        self.requests.poll(now, &mut self.peers, out);
        self.record(now, &out.events[reported..]);
        self.pass(now, start, out);
    }

    fn take(&mut self, now: Tick, frame: &Frame, out: &mut BusOutbox) {
        if !matches!(frame.kind(), FrameKind::Error(_)) {
            self.back_on_the_bus(now, out);
        }
        if self.take_plain(now, frame, out) {
            return;
        }
        let message = match CanopenMessage::decode(frame) {
            Ok(message) => message,
            Err(error) => return self.undecodable(now, error, *frame, out),
        };
        match message {
            CanopenMessage::Heartbeat { node, .. } if node == MANAGER_NODE => self.hear_rival(now, out),
            // It may be an effect of the other manager: nothing follows from it until this one is alone.
            _ if self.rival.since().is_some() => self.ignored[IgnoreReason::NotForManager as usize] += 1,
            CanopenMessage::Heartbeat { node, state } => {
                if let Some(record) = self.record_of(node.get()) {
                    record.nmt = Some(state);
                }
                self.unless_babbling(now, node, frame, out, |peer, out| peer.heartbeat(now, state, out));
            }
            CanopenMessage::Tpdo1 { node, payload } => {
                self.unless_babbling(now, node, frame, out, |peer, out| peer.take_inputs(now, 1, payload, out));
            }
            CanopenMessage::Tpdo { node, number, payload } => {
                self.unless_babbling(now, node, frame, out, |peer, out| peer.take_inputs(now, number, payload, out));
            }
            CanopenMessage::Emergency { node, emergency } => {
                self.unless_babbling(now, node, frame, out, |peer, out| peer.emergency(now, emergency, out));
            }
            CanopenMessage::SdoResponse { node, raw } => {
                let asked = self.peers.iter_mut().find(|peer| peer.node == node);
                if asked.is_some_and(|peer| self.requests.answered(now, peer, &raw, out)) {
                    return;
                }
                self.with_peer(now, node, frame, out, |peer, out| peer.sdo_answer(now, &raw, out));
            }
            // Orders and outputs from a technician's tool or another client; the devices answer for themselves.
            CanopenMessage::Nmt { .. }
            | CanopenMessage::Sync { .. }
            | CanopenMessage::Rpdo1 { .. }
            | CanopenMessage::Rpdo { .. }
            | CanopenMessage::SdoRequest { .. } => {
                self.ignored[IgnoreReason::NotForManager as usize] += 1;
            }
        }
    }

    /// Does what is due at `now`: own heartbeat, probing, retries, refreshing outputs, detecting silence. For the first
    /// four periods of its heartbeat that is listening alone.
    pub fn poll(&mut self, now: Tick, out: &mut BusOutbox) {
        let (start, reported) = (out.frames.len(), out.events.len());
        if !self.may_send(now, out) {
            return;
        }
        if self.next_heartbeat.is_none() {
            self.first_poll(out);
        }
        // A beat missed by a late caller is not made up for: the next one counts from now.
        if self.next_heartbeat.is_none_or(|due| due <= now) {
            let state = NmtState::Operational;
            out.frames.push(CanopenMessage::Heartbeat { node: MANAGER_NODE, state }.encode());
            self.next_heartbeat = Some(now + self.timing.heartbeat);
        }
        self.send_sync(now, out);
        if self.rival.since().is_none() {
            for at in 0..self.peers.len() {
                let outcome = self.peers[at].poll(now, out);
                self.settle(now, at, outcome, out);
            }
        }
        self.poll_plain(now, out);
        self.requests.poll(now, &mut self.peers, out);
        self.record(now, &out.events[reported..]);
        self.forget_states(now);
        self.pass(now, start, out);
    }

    /// When [`Manager::poll`] has something to do next. `None` before the first poll, which is due at once.
    pub fn next_deadline(&self) -> Option<Tick> {
        let rival = self.rival.deadline()?;
        if self.rival.is_mute() {
            return Some(rival);
        }
        let heartbeat = self.next_heartbeat?;
        let pace = self.pace.deadline(self.peers.iter().any(Peer::streams) || self.requests.streaming(0).is_some());
        let first = heartbeat.min(pace).min(self.requests.deadline());
        let first = first.min(self.next_sync.unwrap_or(Tick::NEVER)).min(self.plain_deadline()).min(rival);
        if self.rival.since().is_some() {
            return Some(first);
        }
        Some(self.peers.iter().map(Peer::deadline).fold(first, Tick::min))
    }

    /// Sets the output image of `owner`: bit `i` is its output `i`. Sent at once where it differs from what a device
    /// has, and repeated every [`Timing::refresh`].
    ///
    /// A device that is not operational gets nothing, and once it is operational again the image set *since*. An
    /// owner unknown on this bus is ignored.
    pub fn set_outputs(&mut self, now: Tick, owner: Owner, image: u128, out: &mut BusOutbox) {
        let start = out.frames.len();
        self.give_image(now, owner, image, out);
        self.pass(now, start, out);
    }

    fn give_image(&mut self, now: Tick, owner: Owner, outputs: u128, out: &mut BusOutbox) {
        let Some(image) = self.images.iter_mut().find(|i| i.owner == owner) else { return };
        // With another manager on the bus nothing is energised, nor later: outputs must then be set anew.
        let outputs = if self.rival.since().is_some() { 0 } else { outputs };
        image.outputs = outputs;
        for peer in self.peers.iter_mut().filter(|p| p.owner == owner) {
            peer.set_image(now, outputs, out);
        }
        for plain in self.plains.iter_mut().filter(|p| p.owner == owner) {
            plain.set_image(now, outputs, out);
        }
    }

    /// Takes frames back that the interface had no room for, in the order in which they were to be sent. They go as
    /// soon as there may be room, unless newer ones have taken their place.
    pub fn return_unsent(&mut self, now: Tick, frames: Vec<Frame>) {
        self.pace.give_back(now, frames);
    }

    /// Lets go of every output of every device: for an orderly end, so nothing waits, and what waited is not sent.
    /// (After any other end the devices' own heartbeat consumers do it; those without CANopen have none and come
    /// first.)
    ///
    /// A manager that has never sent anything, because another one was there first, disturbs nothing by ending either.
    pub fn release_outputs(&mut self, now: Tick, out: &mut BusOutbox) {
        if !self.rival.has_sent() {
            return;
        }
        self.pace.forget_all();
        for image in &mut self.images {
            image.outputs = 0;
        }
        for plain in &mut self.plains {
            plain.release(now, out);
        }
        // The outputs last sent may still have waited: zero is sent to each device, whatever it seems to have.
        let mut differing = BusOutbox::default();
        for peer in &mut self.peers {
            peer.set_image(now, 0, &mut differing);
            peer.send_rest(out);
        }
    }

    /// The inputs of `owner` as they stand at `now`.
    pub fn inputs(&self, now: Tick, owner: Owner) -> InputImage {
        let image = self.images.iter().find(|i| i.owner == owner).map_or(InputImage::NEVER, |i| i.inputs);
        // Checked again here, so that a caller that polls late does not read a dead device as a live one.
        InputImage { valid: image.valid && self.are_trusted(now, owner), ..image }
    }

    /// Whether every device of an owner that may not be lost can be acted upon.
    fn are_trusted(&self, now: Tick, owner: Owner) -> bool {
        self.rival.since().is_none()
            && self.peers.iter().filter(|p| p.owner == owner && p.is_vital).all(|p| p.trusted(now))
            && self.plains.iter().filter(|p| p.owner == owner).all(|p| p.trusted(now))
    }

    /// Every device: its node id, its name, and whether it is operational.
    pub fn devices(&self) -> impl Iterator<Item = (NodeId, &str, bool)> {
        self.peers.iter().map(|peer| (peer.node, peer.name.as_str(), peer.is_operational()))
    }

    /// Number of frames ignored for `reason`.
    pub fn ignored(&self, reason: IgnoreReason) -> u64 {
        self.ignored[reason as usize]
    }

    /// The owners whose images this bus carries.
    pub fn owners(&self) -> impl Iterator<Item = Owner> {
        self.images.iter().map(|i| i.owner)
    }

    /// Before anything else every output is let go: a manager that ended a moment ago may have left some energised that
    /// are unknown to this one. Zero (for a drive: quick stop) is safe in every state of the device.
    fn first_poll(&mut self, out: &mut BusOutbox) {
        out.frames.push(CanopenMessage::Heartbeat { node: MANAGER_NODE, state: NmtState::BootUp }.encode());
        for peer in &self.peers {
            peer.send_rest(out);
        }
    }

    /// Sends SYNC if it is due. One that a late caller missed is not made up for.
    fn send_sync(&mut self, now: Tick, out: &mut BusOutbox) {
        let Some(period) = self.timing.sync else { return };
        let due = *self.next_sync.get_or_insert(now);
        if due <= now {
            out.frames.push(CanopenMessage::Sync { counter: None }.encode());
            // In step with the last one, as long as it is no whole period late.
            self.next_sync = Some(if due + period > now { due + period } else { now + period });
        }
    }

    /// Lets pass those of the frames from `start` on that may go now, and those of the waiting ones whose turn it is.
    fn pass(&mut self, now: Tick, start: usize, out: &mut BusOutbox) {
        self.pace.pass(now, start, &mut out.frames);
        while self.pace.may_stream(now) {
            // One after the other, and then a request's.
            let next = |from: usize| (from..self.peers.len()).find(|at| self.peers[*at].streams());
            match next(self.turn) {
                Some(at) => {
                    self.peers[at].stream(now, out);
                    self.turn = at + 1;
                }
                None => {
                    let first = next(0).is_some();
                    let streamed = self.requests.stream(now, out);
                    if !first && !streamed {
                        return;
                    }
                    self.turn = 0;
                    if !streamed {
                        continue;
                    }
                }
            }
            self.pace.streamed(now);
        }
    }

    /// For unsolicited frames of a device: those of a babbling one are ignored.
    fn unless_babbling(
        &mut self,
        now: Tick,
        node: NodeId,
        frame: &Frame,
        out: &mut BusOutbox,
        act: impl FnOnce(&mut Peer, &mut BusOutbox) -> PeerChange,
    ) {
        self.with_peer(now, node, frame, out, |peer, out| peer.unless_babbling(now, out, act));
    }

    fn with_peer(
        &mut self,
        now: Tick,
        node: NodeId,
        frame: &Frame,
        out: &mut BusOutbox,
        act: impl FnOnce(&mut Peer, &mut BusOutbox) -> PeerChange,
    ) {
        match self.peers.iter().position(|p| p.node == node) {
            Some(at) => match act(&mut self.peers[at], out) {
                PeerChange::Ignored(reason) => self.ignore(now, reason, *frame, out),
                outcome => self.settle(now, at, outcome, out),
            },
            None => self.ignore(now, IgnoreReason::UnknownNode, *frame, out),
        }
    }

    /// Effect of a change of one device on its owner's images.
    fn settle(&mut self, now: Tick, at: usize, outcome: PeerChange, out: &mut BusOutbox) {
        let owner = self.peers[at].owner;
        match outcome {
            PeerChange::Unchanged | PeerChange::Ignored(_) => return,
            PeerChange::Inputs => {}
            PeerChange::Up => {
                // Operational at last: it starts from zero and gets what the owner has set since its last loss.
                self.peers[at].send_outputs(now, out);
            }
            PeerChange::Lost => {
                self.forget_what_waits(at);
                self.records[at].losses += 1;
                // On one that may be lost nothing depends.
                if self.peers[at].is_vital {
                    self.let_go(now, owner, out);
                }
            }
        }
        self.gather(now, owner, out);
    }

    /// Drops the frames waiting for a device that is gone: they are obsolete. To one that is only not trusted they are
    /// sent: among them may be the order to let go, and a newer one replaces it.
    fn forget_what_waits(&mut self, at: usize) {
        if !self.peers[at].is_operational() {
            self.pace.forget(self.peers[at].node);
        }
    }

    /// One of an owner's devices is lost. Its controller decided before the loss was known: none of its outputs counts.
    pub(super) fn let_go(&mut self, now: Tick, owner: Owner, out: &mut BusOutbox) {
        self.give_image(now, owner, 0, out);
    }

    /// Recomputes an owner's input image, and reports a change. However it came to be invalid, outputs are let go.
    fn gather(&mut self, now: Tick, owner: Owner, out: &mut BusOutbox) {
        let peers = || self.peers.iter().filter(|p| p.owner == owner);
        let plains = || self.plains.iter().filter(|p| p.owner == owner);
        let own = peers().map(|peer| peer.input_bits(now)).chain(plains().map(DbcDevice::input_bits));
        let bits = own.fold(0, |all, bits| all | bits);
        let valid = self.are_trusted(now, owner);
        let updated = peers().filter_map(Peer::updated).chain(plains().filter_map(DbcDevice::updated)).max();
        let Some(image) = self.images.iter_mut().find(|i| i.owner == owner) else { return };
        let before = image.inputs;
        image.inputs = before.followed_by(now, bits, valid, updated);
        if (before.bits, before.valid) != (bits, valid) {
            out.events.push(BusEvent::InputsChanged { owner });
        }
        if before.valid && !valid {
            self.let_go(now, owner, out);
        }
    }

    fn undecodable(&mut self, now: Tick, error: FrameDecodeError, frame: Frame, out: &mut BusOutbox) {
        let reason = match error {
            FrameDecodeError::Extended { .. } => IgnoreReason::Extended,
            FrameDecodeError::Remote { .. } => IgnoreReason::Remote,
            FrameDecodeError::ErrorFrame { class } => {
                self.ignored[IgnoreReason::ErrorFrame as usize] += 1;
                if self.reports[IGNORE_REASONS].take(now) {
                    out.events.push(BusEvent::BusError { class });
                }
                return self.bus_error(now, class, out);
            }
            FrameDecodeError::UnknownCobId { .. } => IgnoreReason::UnknownCobId,
            FrameDecodeError::Length { .. } | FrameDecodeError::Field { .. } => IgnoreReason::Malformed,
        };
        self.ignore(now, reason, frame, out);
    }

    fn ignore(&mut self, now: Tick, reason: IgnoreReason, frame: Frame, out: &mut BusOutbox) {
        self.ignored[reason as usize] += 1;
        // An answer to another node's request is normal traffic, not worth an event. Of the rest, enough is reported to
        // understand it; the counters have all of it.
        let everyday = matches!(reason, IgnoreReason::NotForManager | IgnoreReason::Babbling);
        if !everyday && self.reports[reason as usize].take(now) {
            out.events.push(BusEvent::Ignored { reason, frame });
        }
    }
}

/// Limit on reports of a repeated event.
const REPORTS: Budget = Budget::new(20, Duration::from_millis(100));

/// Time until an unanswered order is repeated, and between probes of an absent device. Twice a second is soon enough
/// for an operator who plugs it in, and no load for the bus.
const RETRY: Duration = Duration::from_millis(500);

#[cfg(test)]
mod tests;
