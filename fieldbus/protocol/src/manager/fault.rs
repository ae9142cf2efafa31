//! Faults in a device's messages: frames that are ignored, channels without a measurement, messages of a DBC device
//! that do not come as they should.

use std::fmt;

use linewright_line::SignalError;

/// Reason for ignoring a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum IgnoreReason {
    /// It has a 29-bit identifier.
    Extended,
    Remote,
    /// It is the kernel's report about the bus; reported as [`BusEvent::BusError`](super::BusEvent::BusError).
    ErrorFrame,
    /// Its COB-ID has no meaning here.
    UnknownCobId,
    /// Its bytes do not fit its COB-ID.
    Malformed,
    /// Its sender is not in the description.
    UnknownNode,
    /// Process data from a device that was not started by this manager.
    NotOperational,
    /// Process data shorter than the device's inputs.
    ShortPdo,
    /// From a device that sends too much; counted without an event.
    Babbling,
    /// Addressed to others; counted without an event.
    NotForManager,
}

pub(super) const IGNORE_REASONS: usize = IgnoreReason::NotForManager as usize + 1;

impl IgnoreReason {
    /// All reasons, for counters on a page or a topic.
    pub const ALL: [IgnoreReason; IGNORE_REASONS] = [
        IgnoreReason::Extended,
        IgnoreReason::Remote,
        IgnoreReason::ErrorFrame,
        IgnoreReason::UnknownCobId,
        IgnoreReason::Malformed,
        IgnoreReason::UnknownNode,
        IgnoreReason::NotOperational,
        IgnoreReason::ShortPdo,
        IgnoreReason::Babbling,
        IgnoreReason::NotForManager,
    ];
}

impl fmt::Display for IgnoreReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            IgnoreReason::Extended => "extended identifier",
            IgnoreReason::Remote => "remote request",
            IgnoreReason::ErrorFrame => "error frame",
            IgnoreReason::UnknownCobId => "unknown COB-ID",
            IgnoreReason::Malformed => "malformed",
            IgnoreReason::UnknownNode => "node not in the description",
            IgnoreReason::NotOperational => "process data from a device that was not started",
            IgnoreReason::ShortPdo => "process data too short",
            IgnoreReason::Babbling => "from a device that sends too much",
            IgnoreReason::NotForManager => "not addressed to the manager",
        })
    }
}

/// Why nothing follows from a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelFault {
    /// It is no measurement.
    Number {
        /// The channel: subindex of object 6401h.
        channel: u8,
        /// The number it gave.
        number: i16,
    },
    /// The process data object that carries it has not come for too long.
    Late {
        /// Which: 2 to 4.
        object: u8,
    },
}

impl fmt::Display for ChannelFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ChannelFault::Number { channel, number: i16::MIN | i16::MAX } => {
                write!(
                    f,
                    "analogue input {channel} (6401h:{channel:02X}) is at the end of its range: is its wire broken?"
                )
            }
            ChannelFault::Number { channel, number } => {
                write!(f, "analogue input {channel} (6401h:{channel:02X}) is {number}, which is no measurement")
            }
            ChannelFault::Late { object } => write!(f, "its analogue inputs (TPDO{object}) do not come"),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameFault {
    /// None came.
    Silent,
    Short,
    Checksum,
    /// Its counter stands still.
    Counter,
    /// A signal that an input follows has no value.
    Value(SignalError),
    /// Nothing is wrong with it, but one of its multiplexed parts has not come.
    Page,
}

impl fmt::Display for FrameFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            FrameFault::Value(unsound) => return unsound.fmt(f),
            FrameFault::Silent => "it does not come",
            FrameFault::Short => "it has too few bytes",
            FrameFault::Checksum => "its checksum is wrong",
            FrameFault::Counter => "its counter stands still",
            FrameFault::Page => "a multiplexed part of it does not come",
        })
    }
}
