//! Failures of a transfer.

use std::time::Duration;

use super::{Abort, ObjectId};

/// A transfer that ended without result. After a failed write the object holds its old value or the new one: the
/// confirmation alone may have been lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TransferError {
    pub object: ObjectId,
    pub cause: TransferFailure,
}

/// Cause of a failed transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransferFailure {
    /// The other side aborted it.
    Refused(Abort),
    /// Nothing came from the other side.
    Silent {
        /// For how long it was waited each time.
        waited: Duration,
        /// Bytes transferred until then.
        done: usize,
        /// Number of times the last frame was sent. More than once only for the first of a transfer.
        asked: u8,
    },
    /// A segment came twice, or one is missing.
    Toggle {
        /// Bytes transferred until then.
        done: usize,
    },
    /// A block was acknowledged beyond what was sent of it, or makes no progress.
    Sequence { number: u8 },
    /// A block of no segments, or more than 127.
    BlockSize { size: u8 },
    /// The checksum of a block transfer does not fit its bytes.
    Crc {
        /// Checksum by the sender.
        sent: u16,
        /// Checksum of the received bytes.
        computed: u16,
    },
    /// More or fewer bytes than were announced.
    Length {
        announced: u32,
        /// Came, or at least so many.
        came: usize,
    },
    /// More bytes than are taken.
    TooLong {
        /// Most bytes taken.
        len_max: usize,
    },
    /// An answer that fits no request made.
    Command {
        /// The first byte of the answer.
        command: u8,
        /// Bytes transferred until then.
        done: usize,
    },
    /// Another client has begun a transfer on the same channel, which ends this one.
    Interrupted {
        /// The other's object.
        by: ObjectId,
    },
    /// By this side.
    Cancelled,
}

impl TransferFailure {
    /// The code with which this side aborts the transfer. `None` where the other side has ended it, or no longer
    /// listens.
    pub fn abort(&self) -> Option<Abort> {
        match self {
            TransferFailure::Refused(_) | TransferFailure::Interrupted { .. } => None,
            TransferFailure::Silent { .. } => Some(Abort::TIMEOUT),
            TransferFailure::Toggle { .. } => Some(Abort::TOGGLE),
            TransferFailure::Sequence { .. } => Some(Abort::SEQUENCE),
            TransferFailure::BlockSize { .. } => Some(Abort::BLOCK_SIZE),
            TransferFailure::Crc { .. } => Some(Abort::CRC),
            TransferFailure::Length { announced, came } if *came > *announced as usize => Some(Abort::TOO_LONG),
            TransferFailure::Length { .. } => Some(Abort::TOO_SHORT),
            TransferFailure::TooLong { .. } => Some(Abort::OUT_OF_MEMORY),
            TransferFailure::Command { .. } => Some(Abort::COMMAND),
            TransferFailure::Cancelled => Some(Abort::GENERAL),
        }
    }
}
