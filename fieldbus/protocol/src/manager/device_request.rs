//! Requests to a device, and their results.

use std::time::Duration;

use super::protected_objects::WriteProtection;
use crate::sdo::{Abort, ObjectId, TransferError, TransferFailure};

/// Requests that may wait, for all devices together.
pub const WAITING_MAX: usize = 32;
/// Most time for which a request waits for the channel. A boot of some twenty objects takes a fifth of a second.
pub const PATIENCE: Duration = Duration::from_secs(5);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceRequest {
    Read(ObjectId),
    Write {
        object: ObjectId,
        /// Value to write; a negative one in two's complement of the object's length.
        value: u32,
        /// Length, 1 to 4 bytes; `None`: that of the object.
        bytes: Option<usize>,
    },
}

impl DeviceRequest {
    pub fn object(&self) -> ObjectId {
        match self {
            DeviceRequest::Read(object) | DeviceRequest::Write { object, .. } => *object,
        }
    }
}

/// Reason why a request was not fulfilled.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DeviceRequestError {
    /// No device of this bus has that node id.
    UnknownNode {
        node: u8,
    },
    Full,
    /// The device cannot answer now.
    NotReady(String),
    /// The channel was not free for too long.
    Waited(String),
    /// The manager needed the channel before the transfer was done.
    Overtaken(String),
    /// Not to be written for others.
    Guarded {
        object: ObjectId,
        /// Reason of the protection.
        why: WriteProtection,
    },
    /// The number is too large for the object.
    TooLarge {
        object: ObjectId,
        value: u32,
        /// Length of the object.
        bytes: usize,
    },
    /// The device refused, or did not answer.
    Transfer(TransferError),
}

impl From<TransferError> for DeviceRequestError {
    fn from(error: TransferError) -> Self {
        DeviceRequestError::Transfer(error)
    }
}

impl DeviceRequestError {
    /// The closest abort code, for answers that have only room for a number.
    pub fn abort(&self) -> Abort {
        match self {
            DeviceRequestError::UnknownNode { .. } | DeviceRequestError::NotReady(_) => Abort::NO_CONNECTION,
            DeviceRequestError::Full => Abort::OUT_OF_MEMORY,
            DeviceRequestError::Waited(_) => Abort::TIMEOUT,
            DeviceRequestError::Overtaken(_) => Abort::DEVICE_STATE,
            DeviceRequestError::Guarded { .. } => Abort::LOCAL_CONTROL,
            DeviceRequestError::TooLarge { .. } => Abort::VALUE_HIGH,
            DeviceRequestError::Transfer(TransferError { cause: TransferFailure::Refused(code), .. }) => *code,
            DeviceRequestError::Transfer(TransferError { cause, .. }) => cause.abort().unwrap_or(Abort::GENERAL),
        }
    }
}

/// Result of a request: the bytes read, or nothing for a write.
pub type RequestResult = Result<Vec<u8>, DeviceRequestError>;
