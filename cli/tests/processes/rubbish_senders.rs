//! Senders of rubbish: ROS publishers and bus members that say what no honest one says.
//!
//! A publisher announces a message type by name and then sends bytes; nothing but the reader checks that they are one.

use std::marker::PhantomData;

use linewright_msgs::{Invalid, RosField, RosMessage};
use linewright_node_shell::{Publisher, RosNode, qos};
use ros2_client::QosProfile;
use serde::de::Error as _;
use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::support::bus::{Member, frame};

/// Any bytes, sent under the name of `M`.
pub struct Raw<M> {
    bytes: Vec<u8>,
    of: PhantomData<M>,
}

impl<M> Serialize for Raw<M> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(self.bytes.len())?;
        for byte in &self.bytes {
            tuple.serialize_element(byte)?;
        }
        tuple.end()
    }
}

impl<'de, M> Deserialize<'de> for Raw<M> {
    fn deserialize<D: Deserializer<'de>>(_: D) -> Result<Self, D::Error> {
        Err(D::Error::custom("rubbish is only sent"))
    }
}

impl<M> RosField for Raw<M> {
    fn check_bounds(&self, _path: &str) -> Result<(), Invalid> {
        Ok(())
    }
}

impl<M: RosMessage> RosMessage for Raw<M> {
    const PACKAGE: &'static str = M::PACKAGE;
    const NAME: &'static str = M::NAME;
    fn validate(&self) -> Result<(), Invalid> {
        Ok(())
    }
}

/// Sends truncated, overlong and lying bytes on a topic.
pub struct Vandal<M: RosMessage> {
    publisher: Publisher<Raw<M>>,
}

impl<M: RosMessage> Vandal<M> {
    /// Opens the topic under its true type and quality of service.
    pub fn open(node: &mut RosNode, topic: &str, qos: QosProfile) -> Self {
        Vandal { publisher: node.publisher(topic, qos).expect("a topic") }
    }

    /// One round of rubbish.
    pub fn send(&self) {
        let lengths_that_lie = [0xFF; 64];
        for bytes in [&[][..], &[1], &[0; 3], &[0; 24], &lengths_that_lie, &[7; 3000]] {
            self.publisher.send(Raw { bytes: bytes.to_vec(), of: PhantomData });
        }
    }
}

/// A publisher of well-formed messages on a command topic.
pub fn commander<M: RosMessage>(node: &mut RosNode, topic: &str) -> Publisher<M> {
    node.publisher(topic, qos::command()).expect("a topic")
}

/// One round of rubbish on the bus: nothing here is a frame that a device or a manager should act upon.
pub fn litter(member: &Member, round: u32) {
    const EXTENDED: u32 = 0x8000_0000;
    const REMOTE: u32 = 0x4000_0000;
    const ERROR: u32 = 0x2000_0000;
    // Datagrams that are no frames: too short, too long, a length of more than eight bytes.
    for length in [0, 1, 8, 15, 17, 64] {
        member.send(&vec![0xA5; length]);
    }
    let mut overlong = frame(0x211, &[0xFF; 8]);
    overlong[4] = 200;
    member.send(&overlong);
    // What would be outputs, inputs, an emergency stop or a command to stop, were the identifier not extended, or the
    // frame not a request or a kernel's report.
    for flags in [EXTENDED, REMOTE, ERROR, EXTENDED | REMOTE] {
        for identifier in [0x000, 0x201, 0x211, 0x221, 0x222, 0x223, 0x181, 0x191, 0x1A1, 0x1A2, 0x1A4, 0x721] {
            member.send(&frame(flags | identifier, &[0xFF, 0xFF, 0xFF]));
        }
    }
    // Identifiers and nodes that nobody has; lengths that fit nothing.
    for identifier in [0x100, 0x280 + 0x11, 0x380 + 0x21, 0x480 + 0x22, 0x1D5, 0x255, 0x755, 0x0D5, 0x5D5, 0x7E5] {
        member.send(&frame(identifier, &[5]));
    }
    for node in [0x01, 0x11, 0x21, 0x22, 0x24] {
        member.send(&frame(0x180 + node, &[]));
        member.send(&frame(0x200 + node, &[]));
        member.send(&frame(0x700 + node, &[5, 5, 5]));
        member.send(&frame(0x580 + node, &[0x60, 0x00, 0x10]));
        member.send(&frame(0x600 + node, &[0x2F, 0x00]));
        member.send(&frame(0x600 + node, &[0x40, 0x34, 0x12, round as u8, 0, 0, 0, 0]));
    }
    member.send(&frame(0x000, &[1]));
    member.send(&frame(0x000, &[0x77, 0x00]));
}
