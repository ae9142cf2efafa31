//! A setting of a device: the value of one of its objects.

use super::{Abort, ObjectId};

/// One object to be written by SDO.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SdoWrite {
    pub object: ObjectId,
    /// Its bytes, least significant first.
    pub data: Vec<u8>,
    /// Whether a device may lack the object. One that refuses any other setting is not to be started.
    pub optional: bool,
    /// Bits that must be read back as written, byte by byte; `None`: it is not read back.
    pub compared: Option<Vec<u8>>,
    /// Whether the device may be started even if it does not keep it: the description has the reason.
    pub excused: bool,
}

impl SdoWrite {
    pub(crate) fn new(index: u16, sub: u8, data: impl Into<Vec<u8>>) -> Self {
        SdoWrite {
            object: ObjectId::new(index, sub),
            data: data.into(),
            optional: false,
            compared: None,
            excused: false,
        }
    }

    pub(crate) fn u8(index: u16, sub: u8, value: u8) -> Self {
        SdoWrite::new(index, sub, [value])
    }

    pub(crate) fn u16(index: u16, sub: u8, value: u16) -> Self {
        SdoWrite::new(index, sub, value.to_le_bytes())
    }

    pub(crate) fn i16(index: u16, value: i16) -> Self {
        SdoWrite::new(index, 0, value.to_le_bytes())
    }

    pub(crate) fn u32(index: u16, sub: u8, value: u32) -> Self {
        SdoWrite::new(index, sub, value.to_le_bytes())
    }

    pub(crate) fn optional(self) -> Self {
        SdoWrite { optional: true, ..self }
    }

    /// To be read back after it is written, all of it.
    pub(crate) fn read_back(self) -> Self {
        SdoWrite { compared: Some(vec![0xFF; self.data.len()]), ..self }
    }

    /// To be read back, these bits of its one byte.
    pub(crate) fn read_back_bits(self, mask: u8) -> Self {
        SdoWrite { compared: Some(vec![mask]), ..self }
    }

    /// Whether the value read back equals the written one, as far as it is compared.
    pub fn is_kept(&self, found: &[u8]) -> bool {
        let Some(mask) = &self.compared else { return true };
        let mut bytes = found.iter().zip(&self.data).zip(mask);
        found.len() == self.data.len() && bytes.all(|((found, written), mask)| (found ^ written) & mask == 0)
    }

    /// Whether this answer may be ignored: the device lacks the object, and may.
    pub fn may_be_refused(&self, code: Abort) -> bool {
        self.excused || self.optional && matches!(code, Abort::NO_OBJECT | Abort::NO_SUBINDEX)
    }
}
