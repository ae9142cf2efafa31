//! Emergencies: a device's own report of an error (CiA 301 §7.2.7).

use std::fmt;

use super::{CanopenMessage, FrameDecodeError, NodeId, emcy_codes};
use crate::profile::drive;

/// Error code "life guard error or heartbeat error" (CiA 301 table 26).
pub const HEARTBEAT_LOST: u16 = 0x8130;
/// Error code "recovered from bus off" (CiA 301 table 26).
pub const BUS_OFF_RECOVERED: u16 = 0x8140;
/// Error code "error reset or no error" (CiA 301 table 26).
pub const NO_ERROR: u16 = 0x0000;

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

/// By which table an error code is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Profile {
    /// CiA 301 alone: the device's profile is unknown.
    #[default]
    Unknown,
    /// CiA 401, digital and analogue inputs and outputs.
    Io,
    /// CiA 402, drives.
    Drive,
}

impl Emergency {
    /// Meaning of its code for such a device; `None` for a code no table has.
    pub fn meaning(&self, profile: Profile) -> Option<&'static str> {
        match profile {
            Profile::Unknown => emcy_codes::general(self.code),
            Profile::Io => emcy_codes::io(self.code),
            // The general table has what concerns the bus.
            Profile::Drive if self.code >> 12 == 8 && self.code < 0x8300 => emcy_codes::general(self.code),
            Profile::Drive => drive::meaning(self.code),
        }
    }

    /// In words, for such a device: code, meaning, error register.
    pub fn text(&self, profile: Profile) -> String {
        let meaning = self.meaning(profile).unwrap_or("unknown error");
        format!("{:04X}h ({meaning}), register {:02X}h", self.code, self.register)
    }
}

impl fmt::Display for Emergency {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text(Profile::Unknown))
    }
}

pub(super) fn decode(cob_id: u16, node: NodeId, data: &[u8]) -> Result<CanopenMessage, FrameDecodeError> {
    let &[low, high, register, a, b, c, d, e] = data else {
        return Err(FrameDecodeError::Length { cob_id, expected: "8", actual: data.len() });
    };
    let emergency = Emergency { code: u16::from_le_bytes([low, high]), register, vendor: [a, b, c, d, e] };
    Ok(CanopenMessage::Emergency { node, emergency })
}

/// The bits of the error register, in words (CiA 301 table 50).
pub(crate) fn error_register_text(register: u8) -> String {
    const NAMES: [&str; 8] =
        ["generic", "current", "voltage", "temperature", "communication", "device profile", "reserved", "manufacturer"];
    let on = NAMES.iter().enumerate().filter(|(bit, _)| register >> bit & 1 == 1);
    on.map(|(_, name)| *name).collect::<Vec<_>>().join(", ")
}
