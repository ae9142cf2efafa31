//! Emergencies: a device's own report of an error (CiA 301 §7.2.7).

use std::fmt;

use super::{DecodeError, Message, NodeId};

/// Error code "life guard error or heartbeat error" (CiA 301 table 26).
pub const HEARTBEAT_LOST: u16 = 0x8130;
/// Error code "error reset or no error" (CiA 301 table 26).
pub const NO_ERROR: u16 = 0x0000;

/// What an emergency frame says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Emergency {
    /// Error code by CiA 301 table 26; 0x0000 reports that errors are gone.
    pub code: u16,
    /// The device's error register, object 0x1001: bit 0 generic, bit 4 communication.
    pub register: u8,
    /// Bytes the manufacturer defines.
    pub vendor: [u8; 5],
}

impl Emergency {
    pub(super) fn to_bytes(self) -> [u8; 8] {
        let [low, high] = self.code.to_le_bytes();
        let [a, b, c, d, e] = self.vendor;
        [low, high, self.register, a, b, c, d, e]
    }

    /// Whether it reports that errors are gone.
    pub fn is_reset(&self) -> bool {
        self.code == NO_ERROR
    }
}

impl fmt::Display for Emergency {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The classes of CiA 301 table 26, by their high byte.
        let class = match self.code >> 8 {
            0x00 => "errors gone",
            0x10 => "generic error",
            0x20..=0x23 => "current",
            0x30..=0x33 => "voltage",
            0x40..=0x42 => "temperature",
            0x50 => "device hardware",
            0x60..=0x63 => "device software",
            0x70 => "additional modules",
            0x81 => "communication",
            0x82 => "protocol",
            0x90 => "external error",
            0xF0 => "additional functions",
            0xFF => "device specific",
            _ => "unknown class",
        };
        write!(f, "{:04X}h {class}, register {:02X}h", self.code, self.register)
    }
}

pub(super) fn decode(cob_id: u16, node: NodeId, data: &[u8]) -> Result<Message, DecodeError> {
    let &[low, high, register, a, b, c, d, e] = data else {
        return Err(DecodeError::Length { cob_id, expected: "8", actual: data.len() });
    };
    let emergency = Emergency { code: u16::from_le_bytes([low, high]), register, vendor: [a, b, c, d, e] };
    Ok(Message::Emergency { node, emergency })
}
