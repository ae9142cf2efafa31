//! Service data objects, expedited transfers (CiA 301 §7.2.4.3): up to four bytes of one object in one frame.
//!
//! Segmented and block transfers are decoded to an error: nothing Linewright configures is longer than four bytes.

use std::fmt;

use super::DecodeError;

/// One to four bytes of an object, least significant first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SdoData {
    len: u8,
    bytes: [u8; 4],
}

impl SdoData {
    /// An object of one byte.
    pub fn u8(value: u8) -> Self {
        SdoData { len: 1, bytes: [value, 0, 0, 0] }
    }

    /// An object of two bytes.
    pub fn u16(value: u16) -> Self {
        let [a, b] = value.to_le_bytes();
        SdoData { len: 2, bytes: [a, b, 0, 0] }
    }

    /// An object of four bytes.
    pub fn u32(value: u32) -> Self {
        SdoData { len: 4, bytes: value.to_le_bytes() }
    }

    /// One to four bytes, or `None` for any other number of them.
    pub fn new(data: &[u8]) -> Option<Self> {
        let mut bytes = [0; 4];
        bytes.get_mut(..data.len()).filter(|b| !b.is_empty())?.copy_from_slice(data);
        Some(SdoData { len: data.len() as u8, bytes })
    }

    /// The bytes as sent.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..usize::from(self.len)]
    }

    /// The value as an unsigned number.
    pub fn value(&self) -> u32 {
        u32::from_le_bytes(self.bytes)
    }
}

/// What a client asks of a device's object dictionary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SdoRequest {
    /// Write an object.
    Download {
        /// Index of the object.
        index: u16,
        /// Subindex.
        sub: u8,
        /// The value.
        data: SdoData,
    },
    /// Read an object.
    Upload {
        /// Index of the object.
        index: u16,
        /// Subindex.
        sub: u8,
    },
    /// Give up a transfer.
    Abort {
        /// Index of the object.
        index: u16,
        /// Subindex.
        sub: u8,
        /// Why.
        code: Abort,
    },
}

/// What the device answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SdoResponse {
    /// The object was written.
    Downloaded {
        /// Index of the object.
        index: u16,
        /// Subindex.
        sub: u8,
    },
    /// The object's value.
    Uploaded {
        /// Index of the object.
        index: u16,
        /// Subindex.
        sub: u8,
        /// The value.
        data: SdoData,
    },
    /// The request is refused.
    Aborted {
        /// Index of the object.
        index: u16,
        /// Subindex.
        sub: u8,
        /// Why.
        code: Abort,
    },
}

/// An abort code (CiA 301 table 22).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Abort(pub u32);

impl Abort {
    /// Client or server command specifier not valid or unknown.
    pub const COMMAND: Abort = Abort(0x0504_0001);
    /// Attempt to write a read only object.
    pub const READ_ONLY: Abort = Abort(0x0601_0002);
    /// Attempt to read a write only object.
    pub const WRITE_ONLY: Abort = Abort(0x0601_0001);
    /// The object does not exist in the dictionary.
    pub const NO_OBJECT: Abort = Abort(0x0602_0000);
    /// Data type does not match, length of service parameter does not match.
    pub const LENGTH: Abort = Abort(0x0607_0010);
    /// Subindex does not exist.
    pub const NO_SUBINDEX: Abort = Abort(0x0609_0011);
    /// Invalid value for parameter.
    pub const VALUE: Abort = Abort(0x0609_0030);
}

impl fmt::Display for Abort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let meaning = match *self {
            Abort::COMMAND => "unknown command",
            Abort::READ_ONLY => "object is read only",
            Abort::WRITE_ONLY => "object is write only",
            Abort::NO_OBJECT => "no such object",
            Abort::LENGTH => "wrong length",
            Abort::NO_SUBINDEX => "no such subindex",
            Abort::VALUE => "invalid value",
            _ => "see CiA 301 table 22",
        };
        write!(f, "{:08X}h ({meaning})", self.0)
    }
}

// Command bytes: specifier in bits 7 to 5; for an expedited transfer bits 1 and 0 set, bits 3 and 2 the number of
// bytes not used (§7.2.4.3).
const DOWNLOAD: u8 = 0x20;
const UPLOAD: u8 = 0x40;
const DOWNLOADED: u8 = 0x60;
const UPLOADED: u8 = 0x40;
const ABORT: u8 = 0x80;
const EXPEDITED: u8 = 0x02;
const SIZED: u8 = 0x01;

impl SdoRequest {
    pub(super) fn to_bytes(self) -> [u8; 8] {
        match self {
            SdoRequest::Download { index, sub, data } => build(expedited(DOWNLOAD, data), index, sub, data.bytes),
            SdoRequest::Upload { index, sub } => build(UPLOAD, index, sub, [0; 4]),
            SdoRequest::Abort { index, sub, code } => build(ABORT, index, sub, code.0.to_le_bytes()),
        }
    }
}

impl SdoResponse {
    pub(super) fn to_bytes(self) -> [u8; 8] {
        match self {
            SdoResponse::Downloaded { index, sub } => build(DOWNLOADED, index, sub, [0; 4]),
            SdoResponse::Uploaded { index, sub, data } => build(expedited(UPLOADED, data), index, sub, data.bytes),
            SdoResponse::Aborted { index, sub, code } => build(ABORT, index, sub, code.0.to_le_bytes()),
        }
    }

    /// The object the answer is about.
    pub fn object(&self) -> (u16, u8) {
        match *self {
            SdoResponse::Downloaded { index, sub }
            | SdoResponse::Uploaded { index, sub, .. }
            | SdoResponse::Aborted { index, sub, .. } => (index, sub),
        }
    }
}

fn expedited(command: u8, data: SdoData) -> u8 {
    command | EXPEDITED | SIZED | ((4 - data.len) << 2)
}

fn build(command: u8, index: u16, sub: u8, data: [u8; 4]) -> [u8; 8] {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = data;
    [command, low, high, sub, a, b, c, d]
}

struct Parts {
    command: u8,
    index: u16,
    sub: u8,
    data: [u8; 4],
}

fn parts(cob_id: u16, data: &[u8]) -> Result<Parts, DecodeError> {
    let &[command, low, high, sub, a, b, c, d] = data else {
        return Err(DecodeError::Length { cob_id, expected: "8", actual: data.len() });
    };
    Ok(Parts { command, index: u16::from_le_bytes([low, high]), sub, data: [a, b, c, d] })
}

impl Parts {
    /// The bytes of an expedited transfer; one without a size carries all four.
    fn expedited(&self, cob_id: u16) -> Result<SdoData, DecodeError> {
        if self.command & EXPEDITED == 0 {
            let expected = "an expedited transfer (bit 1 set)";
            return Err(DecodeError::Field { cob_id, field: "SDO command", expected, actual: self.command });
        }
        let len = if self.command & SIZED != 0 { 4 - ((self.command >> 2) & 3) } else { 4 };
        let mut bytes = [0; 4];
        bytes[..usize::from(len)].copy_from_slice(&self.data[..usize::from(len)]);
        Ok(SdoData { len, bytes })
    }
}

pub(super) fn decode_request(cob_id: u16, data: &[u8]) -> Result<SdoRequest, DecodeError> {
    let parts = parts(cob_id, data)?;
    let Parts { command, index, sub, data } = parts;
    match command & 0xE0 {
        DOWNLOAD => Ok(SdoRequest::Download { index, sub, data: parts.expedited(cob_id)? }),
        UPLOAD => Ok(SdoRequest::Upload { index, sub }),
        ABORT => Ok(SdoRequest::Abort { index, sub, code: Abort(u32::from_le_bytes(data)) }),
        _ => Err(DecodeError::Field {
            cob_id,
            field: "SDO command",
            expected: "download, upload or abort",
            actual: command,
        }),
    }
}

pub(super) fn decode_response(cob_id: u16, data: &[u8]) -> Result<SdoResponse, DecodeError> {
    let parts = parts(cob_id, data)?;
    let Parts { command, index, sub, data } = parts;
    match command & 0xE0 {
        DOWNLOADED => Ok(SdoResponse::Downloaded { index, sub }),
        UPLOADED => Ok(SdoResponse::Uploaded { index, sub, data: parts.expedited(cob_id)? }),
        ABORT => Ok(SdoResponse::Aborted { index, sub, code: Abort(u32::from_le_bytes(data)) }),
        _ => Err(DecodeError::Field {
            cob_id,
            field: "SDO command",
            expected: "downloaded, uploaded or aborted",
            actual: command,
        }),
    }
}
