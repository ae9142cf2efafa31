//! Texts of faults in a device's messages.

use std::fmt;

use crate::manager::fault::{ChannelFault, FrameFault, IgnoreReason};

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
