//! The texts of this crate for operators. All of them are here; `tests/texts.rs` keeps a list of them. What the system
//! reports is quoted.

use std::error::Error;
use std::fmt;
use std::path::Path;

use linewright_canopen::manager::MANAGER_NODE;

use crate::bus::BusError;
use crate::driver::DriverError;
use crate::sdo_client::SdoError;

impl fmt::Display for BusError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BusError::Name { name } => {
                write!(
                    f,
                    "`{name}` is not a bus name: 1 to 15 letters, digits, `.`, `_` or `-`, not starting with a dot"
                )
            }
            BusError::Kernel { name, error } => write!(f, "cannot open CAN interface {name}: {error}"),
            BusError::Missing { name, error } => write!(
                f,
                "there is no CAN interface {name} ({error}): see `ip link show {name}` and the name given; without CAN hardware \
                 `linewright run` and nodes started with --virtual-bus use a virtual bus"
            ),
            BusError::Gone { name, error } => write!(
                f,
                "CAN interface {name} is gone ({error}): nothing can be sent or received; bring it up again \
                 (`ip link set {name} up`) and start this again"
            ),
            BusError::Virtual { name, path, error } => {
                write!(f, "cannot use {path} for virtual bus '{name}': {error}")
            }
        }
    }
}

impl Error for BusError {}

impl fmt::Display for DriverError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DriverError::Bus(error) => error.fmt(f),
            DriverError::AnotherManager { bus, has_sent } => {
                let when = if *has_sent {
                    "just after this one had begun, which has let go of every output"
                } else {
                    "before this one had sent anything"
                };
                write!(
                    f,
                    "{bus}: another CANopen manager (node {MANAGER_NODE}) drives this bus: its heartbeat (77Fh) was received \
                     {when}; one bus has one manager: end that one, or give this one a bus of its own"
                )
            }
        }
    }
}

impl Error for DriverError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            DriverError::Bus(error) => error.source(),
            DriverError::AnotherManager { .. } => None,
        }
    }
}

impl fmt::Display for SdoError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SdoError::Transfer { node, error } => write!(f, "node {node}, {error}"),
            SdoError::Bus(error) => error.fmt(f),
        }
    }
}

impl Error for SdoError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            SdoError::Bus(error) => error.source(),
            SdoError::Transfer { .. } => None,
        }
    }
}

/// The wire of a bus.
#[derive(Clone, Copy, Debug)]
pub enum BusDescription<'a> {
    SocketCan {
        name: &'a str,
    },
    Virtual {
        name: &'a str,
        dir: &'a Path,
        /// Whether the kernel has CAN.
        has_can: bool,
    },
}

impl fmt::Display for BusDescription<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BusDescription::SocketCan { name } => write!(f, "SocketCAN {name}"),
            BusDescription::Virtual { name, dir, has_can } => {
                let why = if *has_can { "no CAN interface of that name" } else { "this kernel has no CAN" };
                write!(f, "virtual bus '{name}' in {} ({why})", dir.display())
            }
        }
    }
}

/// Reply to a request that needs no frame of the device.
#[derive(Clone, Copy, Debug)]
pub enum RequestReply {
    ResetOrdered,
    /// The device has no CANopen.
    NoCanopen,
}

impl RequestReply {
    /// The text.
    pub fn text(self) -> &'static str {
        match self {
            RequestReply::ResetOrdered => "ordered to reset",
            RequestReply::NoCanopen => "it speaks plain CAN frames, and has no objects and no states",
        }
    }
}

/// Warning in the log of a node.
#[derive(Clone, Copy, Debug)]
pub enum BusWarning {
    NothingReceived,
    NotReleased,
    NoLastWire,
}

impl fmt::Display for BusWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            BusWarning::NothingReceived => "nothing can be received on the CAN interface",
            BusWarning::NotReleased => "the interface does not take the orders to let go",
            BusWarning::NoLastWire => "no way to let go of outputs when stuck",
        })
    }
}
