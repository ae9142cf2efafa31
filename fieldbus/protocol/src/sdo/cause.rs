//! Failures of a transfer.

use std::time::Duration;

use thiserror::Error;

use super::{Abort, ObjectId};

/// A transfer that ended without result. After a failed write the object holds its old value or the new one: the
/// confirmation alone may have been lost.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("object {object}: {cause}")]
pub struct TransferError {
    pub object: ObjectId,
    pub cause: TransferFailure,
}

/// Cause of a failed transfer.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum TransferFailure {
    /// The other side aborted it.
    #[error("refused: {0}")]
    Refused(Abort),
    /// Nothing came from the other side.
    #[error("no answer within {} ms{}", waited.as_millis(), circumstances(*done, *asked))]
    Silent {
        /// For how long it was waited each time.
        waited: Duration,
        /// Bytes transferred until then.
        done: usize,
        /// Number of times the last frame was sent. More than once only for the first of a transfer.
        asked: u8,
    },
    /// A segment came twice, or one is missing.
    #[error("a segment came twice or is missing (toggle bit) after {done} bytes")]
    Toggle {
        /// Bytes transferred until then.
        done: usize,
    },
    /// A block was acknowledged beyond what was sent of it, or makes no progress.
    #[error("segment {number} of the block is out of sequence")]
    Sequence { number: u8 },
    /// A block of no segments, or more than 127.
    #[error("{size} segments in a block, expected 1 to 127")]
    BlockSize { size: u8 },
    /// The checksum of a block transfer does not fit its bytes.
    #[error("checksum {sent:04X}h, but the bytes received have {computed:04X}h")]
    Crc {
        /// That of the sender.
        sent: u16,
        /// That of the bytes that came.
        computed: u16,
    },
    /// More or fewer bytes than were announced.
    #[error("{announced} bytes were announced, {came} came")]
    Length {
        announced: u32,
        /// Came, or at least so many.
        came: usize,
    },
    #[error("longer than the {len_max} bytes that are taken")]
    TooLong {
        /// Most bytes taken.
        len_max: usize,
    },
    /// An answer that fits no request made.
    #[error("answer {command:02X}h does not fit the transfer, after {done} bytes")]
    Command {
        /// The first byte of the answer.
        command: u8,
        /// Bytes transferred until then.
        done: usize,
    },
    /// Another client has begun a transfer on the same channel, which ends this one.
    #[error("somebody else has asked the device for {by}")]
    Interrupted {
        /// The other's object.
        by: ObjectId,
    },
    #[error("given up")]
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

fn circumstances(done: usize, asked: u8) -> String {
    match (done, asked) {
        (0, 0 | 1) => String::new(),
        (0, _) => format!(", asked {asked} times"),
        (_, _) => format!(" after {done} bytes"),
    }
}
