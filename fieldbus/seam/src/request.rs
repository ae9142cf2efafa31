//! Requests of operators and programs to a device, beside its process image.

use std::fmt;

/// Codes for answers that have room for a number only: SDO abort codes (CiA 301 §7.2.4.3.17).
pub mod abort {
    /// There is no such device, or it does not answer.
    pub const NO_CONNECTION: u32 = 0x060A_0023;
    /// The value is too long for the answer.
    pub const TOO_LONG: u32 = 0x0607_0012;
    /// The device has no such thing.
    pub const UNSUPPORTED: u32 = 0x0601_0000;
}

/// Device that a request is for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BusTarget {
    Node(u8),
    Device(String),
}

/// An object of a CANopen device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjectAddress {
    pub index: u16,
    pub sub: u8,
}

/// Request to a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusRequest {
    Reset,
    Start,
    Read(ObjectAddress),
    Write {
        object: ObjectAddress,
        /// Value to write; a negative one in two's complement of the object's length.
        value: u32,
        /// Length, 1 to 4 bytes; `None`: that of the object.
        bytes: Option<usize>,
    },
}

/// Result of a request.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BusReply {
    /// The bytes read; none for anything else.
    pub value: Vec<u8>,
    pub text: String,
}

/// Why it was not fulfilled.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BusRefusal {
    /// In words, with the device.
    pub text: String,
    /// For answers that have room for a number only, see [`abort`].
    pub code: u32,
}

/// Result of a request, or its refusal.
pub type Answer = Result<BusReply, BusRefusal>;

impl fmt::Display for BusTarget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BusTarget::Node(node) => write!(f, "node {node:02X}h"),
            BusTarget::Device(name) => f.write_str(name),
        }
    }
}

impl fmt::Display for ObjectAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h:{:02X}", self.index, self.sub)
    }
}

impl fmt::Display for BusRequest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BusRequest::Reset => f.write_str("reset"),
            BusRequest::Start => f.write_str("start"),
            BusRequest::Read(object) => write!(f, "read object {object}"),
            BusRequest::Write { object, value, .. } => write!(f, "write {value} ({value:X}h) to object {object}"),
        }
    }
}
