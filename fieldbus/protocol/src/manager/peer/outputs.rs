//! A device's share of the outputs of its owner.

use linewright_line::Tick;

use super::super::event::BusOutbox;
use super::Peer;
use crate::codec::{CanopenMessage, NodeId, Payload};

impl Peer {
    /// Takes the image its owner has set, and sends its share if it is operational and has something else.
    pub(in crate::manager) fn set_image(&mut self, now: Tick, image: u128, out: &mut BusOutbox) {
        self.process.set_image(now, image);
        self.send_if_wanted(now, out);
    }

    /// Sends its share of the image if that is something else than it has.
    pub(in crate::manager) fn send_if_wanted(&mut self, now: Tick, out: &mut BusOutbox) {
        if self.process.wants_to_send() {
            self.send_outputs(now, out);
        }
        self.write_if_wanted(now, out);
    }

    /// Sends its share of the image, provided it is operational: before that the device would drop the frame, and the
    /// manager would take it as applied.
    pub(in crate::manager) fn send_outputs(&mut self, now: Tick, out: &mut BusOutbox) {
        if self.is_operational() && self.process.has_outputs() {
            let node = self.node;
            self.process.give(|object, payload| out.frames.push(rpdo(node, object, payload)));
            self.sent = Some(now);
        }
    }

    /// Lets go of all outputs, whatever state it is in.
    pub(in crate::manager) fn send_rest(&self, out: &mut BusOutbox) {
        if self.process.has_outputs() {
            self.process.rest(|object, payload| out.frames.push(rpdo(self.node, object, payload)));
        }
    }
}

/// A process data object for a device: its first, or one with channels, 2 to 4.
fn rpdo(node: NodeId, object: u8, payload: Payload) -> crate::Frame {
    match object {
        1 => CanopenMessage::Rpdo1 { node, payload },
        number => CanopenMessage::Rpdo { node, number, payload },
    }
    .encode()
}
