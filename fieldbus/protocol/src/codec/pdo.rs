//! The bytes of a process data object, seen as bits (CiA 301 §7.2.2; default mapping of CiA 401).

use std::fmt;

/// Up to eight bytes of process data. Bit `i` is in byte `i / 8` at weight `i % 8` (CiA 301 §7.1.4).
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Payload {
    len: u8,
    data: [u8; 8],
}

impl Payload {
    /// The first `count` bits of `bits`, in as few bytes as hold them, but at least one.
    pub fn from_bits(bits: u64, count: usize) -> Self {
        let count = count.clamp(1, 64);
        let kept = bits & (u64::MAX >> (64 - count));
        Payload { len: count.div_ceil(8) as u8, data: kept.to_le_bytes() }
    }

    /// The bytes of a frame; what exceeds eight is cut off, which a classic frame never has.
    pub(super) fn of(bytes: &[u8]) -> Self {
        let len = bytes.len().min(8);
        let mut data = [0; 8];
        data[..len].copy_from_slice(&bytes[..len]);
        Payload { len: len as u8, data }
    }

    pub fn bytes(&self) -> &[u8] {
        &self.data[..usize::from(self.len)]
    }

    /// All 64 bits; those beyond the bytes sent are 0.
    pub fn bits(&self) -> u64 {
        u64::from_le_bytes(self.data)
    }
}

impl fmt::Debug for Payload {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Payload({:02X?})", self.bytes())
    }
}
