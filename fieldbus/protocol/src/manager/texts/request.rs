//! Texts of requests that are refused, and of descriptions for which there is no manager.

use std::error::Error;
use std::fmt;

use crate::manager::MANAGER_NODE;
use crate::manager::build::ManagerError;
use crate::manager::device_request::{DeviceRequestError, PATIENCE, WAITING_MAX};
use crate::manager::protected_objects::WriteProtection;

impl Error for DeviceRequestError {}

impl fmt::Display for DeviceRequestError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DeviceRequestError::UnknownNode { node } => f.write_str(&unknown_node(*node)),
            DeviceRequestError::Full => write!(f, "{WAITING_MAX} requests are waiting already"),
            DeviceRequestError::NotReady(why) => write!(f, "the device {why}"),
            DeviceRequestError::Waited(why) => {
                write!(f, "not begun within {} s: the device {why}", PATIENCE.as_secs())
            }
            DeviceRequestError::Overtaken(why) => write!(f, "interrupted by the manager: the device {why}"),
            DeviceRequestError::Guarded { object, why } => {
                write!(f, "object {object} is not written for others: {}", why.text())
            }
            DeviceRequestError::TooLarge { object, value, bytes } => {
                write!(f, "{value} ({value:X}h) does not fit object {object}, which has {bytes} byte(s)")
            }
            DeviceRequestError::Transfer(error) => error.fmt(f),
        }
    }
}

/// No device has this node id.
pub(in crate::manager) fn unknown_node(node: u8) -> String {
    format!("no device of this bus has node id {node:02X}h")
}

impl WriteProtection {
    pub fn text(self) -> &'static str {
        match self {
            WriteProtection::Described => "the manager has set it, by the line's description",
            WriteProtection::Heartbeat => "the watch between device and manager rests on it",
            WriteProtection::Mapping => "the process image rests on the mapping of the PDOs",
            WriteProtection::Communication => "it decides how the device communicates",
            WriteProtection::Process => "it belongs to the process: outputs, targets and what the inputs mean",
            WriteProtection::Unknown => "its meaning is not known to be harmless",
        }
    }
}

/// Reply to a request to start a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartReply {
    /// It was stopped, and is configured and started.
    Woken,
    /// It was refused, and is compared with its description again.
    LookedAtAgain,
}

impl StartReply {
    /// The text; `state` is that of the device before.
    pub fn text(self, state: &str) -> String {
        match self {
            StartReply::Woken => "woken, to be configured and started".to_owned(),
            StartReply::LookedAtAgain => format!("{state}. It is being looked at again"),
        }
    }
}

impl Error for ManagerError {}

impl fmt::Display for ManagerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ManagerError::NodeId { device, node } => {
                write!(
                    f,
                    "device `{device}` has node id {node:02X}h; devices have 01h to 7Eh, the manager itself is {MANAGER_NODE}"
                )
            }
            ManagerError::Duplicate { first, second, node } => {
                write!(f, "devices `{first}` and `{second}` share node id {node:02X}h")
            }
            ManagerError::Unread { device, file } => {
                write!(f, "device `{device}`: its file {file} has not been read")
            }
            ManagerError::FrameId { device, id, other } => {
                write!(f, "device `{device}` has messages with identifier {id}, which is that of {other}")
            }
            ManagerError::TooWide { device, bits } => {
                write!(f, "device `{device}` has {bits} bits in one direction; one PDO carries 64")
            }
        }
    }
}
