//! Faults in a device's messages: frames that are ignored, channels without a measurement, messages of a DBC device
//! that do not come as they should.

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
        /// Number of the process data object, 2 to 4.
        object: u8,
    },
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
