//! What a device is told: the value of one of its objects.

use super::{Abort, ObjectId};

/// One object to be written by SDO.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Which.
    pub object: ObjectId,
    /// Its bytes, least significant first.
    pub data: Vec<u8>,
    /// Whether a device may do without the object. One that refuses any other setting is not to be started.
    pub optional: bool,
}

impl Setting {
    pub(crate) fn new(index: u16, sub: u8, data: impl Into<Vec<u8>>) -> Self {
        Setting { object: ObjectId::new(index, sub), data: data.into(), optional: false }
    }

    pub(crate) fn u8(index: u16, sub: u8, value: u8) -> Self {
        Setting::new(index, sub, [value])
    }

    pub(crate) fn u16(index: u16, sub: u8, value: u16) -> Self {
        Setting::new(index, sub, value.to_le_bytes())
    }

    pub(crate) fn i16(index: u16, value: i16) -> Self {
        Setting::new(index, 0, value.to_le_bytes())
    }

    pub(crate) fn u32(index: u16, sub: u8, value: u32) -> Self {
        Setting::new(index, sub, value.to_le_bytes())
    }

    pub(crate) fn optional(self) -> Self {
        Setting { optional: true, ..self }
    }

    /// Whether this answer may be passed over: the device does not have the object, and can do without it.
    pub fn may_be_refused(&self, code: Abort) -> bool {
        self.optional && matches!(code, Abort::NO_OBJECT | Abort::NO_SUBINDEX)
    }
}
