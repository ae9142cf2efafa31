//! The drive's object dictionary: one table of what is in it, and the values.
//!
//! `launch-config/devices/linewright-drive.eds` is the same table for other people's tools; a test compares them.

use linewright_canopen::codec::{Abort, NodeId};
use linewright_canopen::profile::drive::word::{HOMING, PROFILE_POSITION, PROFILE_VELOCITY, ROTARY_SHORTEST};
use linewright_canopen::sdo::ObjectId;

/// Object 1008h.
pub(super) const NAME: &str = "Linewright simulated drive";
/// Bit 31 of a COB-ID parameter: the object is switched off.
const INVALID: u32 = 1 << 31;
/// Bit 30: it is not sent on remote request.
const NO_REMOTE: u32 = 1 << 30;
/// Objects one PDO carries at most.
const MAPPED_MAX: u32 = 8;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DriveObjectAccess {
    Read,
    Write,
}
use DriveObjectAccess::{Read, Write};

/// Index, subindex, bytes, access, value after a boot.
pub(super) type ObjectRow = (u16, u8, u8, DriveObjectAccess, u32);

/// In the order of index and subindex.
#[rustfmt::skip]
pub(super) const ROWS: &[ObjectRow] = &[
    // Drive profile 402, servo drive.
    (0x1000, 0, 4, Read, 0x0002_0192), (0x1001, 0, 1, Read, 0),
    (0x1018, 0, 1, Read, 4), (0x1018, 1, 4, Read, 0), (0x1018, 2, 4, Read, 402), (0x1018, 3, 4, Read, 0x0001_0000),
    (0x1018, 4, 4, Read, 0),
    (0x1400, 0, 1, Read, 2), (0x1400, 1, 4, Write, 0), (0x1400, 2, 1, Write, 255),
    (0x1600, 0, 1, Write, 1), (0x1600, 1, 4, Write, 0x6040_0010), (0x1600, 2, 4, Write, 0), (0x1600, 3, 4, Write, 0),
    (0x1600, 4, 4, Write, 0), (0x1600, 5, 4, Write, 0), (0x1600, 6, 4, Write, 0), (0x1600, 7, 4, Write, 0),
    (0x1600, 8, 4, Write, 0),
    (0x1800, 0, 1, Read, 5), (0x1800, 1, 4, Write, 0), (0x1800, 2, 1, Write, 255), (0x1800, 3, 2, Write, 0),
    (0x1800, 5, 2, Write, 0),
    (0x1A00, 0, 1, Write, 1), (0x1A00, 1, 4, Write, 0x6041_0010), (0x1A00, 2, 4, Write, 0), (0x1A00, 3, 4, Write, 0),
    (0x1A00, 4, 4, Write, 0), (0x1A00, 5, 4, Write, 0), (0x1A00, 6, 4, Write, 0), (0x1A00, 7, 4, Write, 0),
    (0x1A00, 8, 4, Write, 0),
    (0x6007, 0, 2, Write, 1), (0x603F, 0, 2, Read, 0), (0x6040, 0, 2, Write, 0), (0x6041, 0, 2, Read, 0),
    (0x605A, 0, 2, Write, 2), (0x605B, 0, 2, Write, 0), (0x605C, 0, 2, Write, 1), (0x605D, 0, 2, Write, 1),
    (0x605E, 0, 2, Write, 2), (0x6060, 0, 1, Write, 1), (0x6061, 0, 1, Read, 1), (0x6064, 0, 4, Read, 0),
    (0x6065, 0, 4, Write, 2000), (0x6066, 0, 2, Write, 10), (0x6067, 0, 4, Write, 10), (0x6068, 0, 2, Write, 0),
    (0x606C, 0, 4, Read, 0), (0x606D, 0, 2, Write, 100), (0x607A, 0, 4, Write, 0), (0x607B, 0, 1, Read, 2),
    (0x607B, 1, 4, Write, 0), (0x607B, 2, 4, Write, 0), (0x607C, 0, 4, Write, 0),
    (0x6081, 0, 4, Write, 1000), (0x6083, 0, 4, Write, 10_000), (0x6084, 0, 4, Write, 10_000),
    (0x6085, 0, 4, Write, 50_000), (0x6086, 0, 2, Write, 0), (0x6098, 0, 1, Write, 0), (0x6099, 0, 1, Read, 2),
    (0x6099, 1, 4, Write, 1000), (0x6099, 2, 4, Write, 100), (0x609A, 0, 4, Write, 10_000),
    (0x60F2, 0, 2, Write, 0), (0x60FF, 0, 4, Write, 0),
    // Profile position, profile velocity, homing.
    (0x6502, 0, 4, Read, 0x25),
];

/// Objects that a process data object may carry.
const RECEIVED: &[u16] = &[0x6040, 0x6060, 0x607A, 0x6081, 0x6083, 0x6084, 0x60FF];
const TRANSMITTED: &[u16] = &[0x603F, 0x6041, 0x6061, 0x6064, 0x606C];

#[derive(Debug)]
pub(super) struct DriveObjects {
    values: Vec<u32>,
    node: NodeId,
}

impl DriveObjects {
    /// As after a boot.
    pub fn new(node: NodeId) -> Self {
        let mut objects = DriveObjects { values: ROWS.iter().map(|row| row.4).collect(), node };
        objects.set(0x1400, 1, objects.cob_id(0x1400));
        objects.set(0x1800, 1, NO_REMOTE | objects.cob_id(0x1800));
        objects
    }

    pub fn u32(&self, index: u16, sub: u8) -> u32 {
        at(ObjectId::new(index, sub)).map_or(0, |at| self.values[at])
    }

    pub fn i32(&self, index: u16) -> i32 {
        self.u32(index, 0) as i32
    }

    pub fn i16(&self, index: u16) -> i16 {
        self.u32(index, 0) as i16
    }

    pub fn i8(&self, index: u16) -> i8 {
        self.u32(index, 0) as i8
    }

    /// A speed or an acceleration: one increment at least, since with none nothing would ever end.
    pub fn rate(&self, index: u16, sub: u8) -> f64 {
        f64::from(self.u32(index, sub).max(1))
    }

    /// The least position and how many there are, where it begins anew after the greatest (607Bh).
    pub fn range(&self) -> Option<(f64, f64)> {
        let [least, greatest] = [1, 2].map(|sub| f64::from(self.u32(0x607B, sub) as i32));
        (least < greatest).then_some((least, greatest - least))
    }

    pub fn set(&mut self, index: u16, sub: u8, value: u32) {
        if let Some(at) = at(ObjectId::new(index, sub)) {
            self.values[at] = value;
        }
    }

    pub fn read(&self, object: ObjectId) -> Result<Vec<u8>, Abort> {
        if object == ObjectId::new(0x1008, 0) {
            return Ok(NAME.as_bytes().to_vec());
        }
        let at = known(object)?;
        Ok(self.values[at].to_le_bytes()[..usize::from(ROWS[at].2)].to_vec())
    }

    pub fn write(&mut self, object: ObjectId, data: &[u8]) -> Result<(), Abort> {
        let ObjectId { index, sub } = object;
        if object == ObjectId::new(0x1008, 0) {
            return Err(Abort::READ_ONLY);
        }
        let at = known(object)?;
        let (_, _, len, access, _) = ROWS[at];
        if access == Read {
            return Err(Abort::READ_ONLY);
        }
        if data.len() != usize::from(len) {
            return Err(Abort::LENGTH);
        }
        let value = data.iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte));
        match (index, sub) {
            // Its identifier is fixed.
            (0x1400 | 0x1800, 1) if value & !(INVALID | NO_REMOTE) != self.cob_id(index) => {
                return Err(Abort::VALUE);
            }
            // Event driven only.
            (0x1400 | 0x1800, 2) if value < 254 => return Err(Abort::VALUE),
            (0x1800, 3) if self.is_on(index) => return Err(Abort::DEVICE_STATE),
            (0x1600 | 0x1A00, _) => self.check_mapping(index, sub, value)?,
            // Relative targets go on from the one before, and a set-point replaces another at once: the rest of it it has not.
            (0x60F2, 0) if value & !u32::from(ROTARY_SHORTEST) != 0 => return Err(Abort::VALUE),
            (0x6060, 0) if ![0, PROFILE_POSITION, PROFILE_VELOCITY, HOMING].contains(&(value as i8)) => {
                return Err(Abort::VALUE);
            }
            _ => {}
        }
        self.values[at] = value;
        Ok(())
    }

    /// A mapping is changed while its object is off and its number of entries is zero (CiA 301 §7.5.2.36).
    fn check_mapping(&self, index: u16, sub: u8, value: u32) -> Result<(), Abort> {
        if self.is_on(index - 0x200) || (sub > 0 && self.u32(index, 0) != 0) {
            return Err(Abort::DEVICE_STATE);
        }
        if sub > 0 {
            let ok = value == 0 || mappable(if index == 0x1600 { RECEIVED } else { TRANSMITTED }, value);
            return if ok { Ok(()) } else { Err(Abort::NOT_MAPPABLE) };
        }
        if value > MAPPED_MAX {
            return Err(Abort::VALUE);
        }
        let bits: u32 = (1..=value).map(|sub| self.u32(index, sub as u8) & 0xFF).sum();
        let empty = (1..=value).any(|sub| self.u32(index, sub as u8) == 0);
        if bits > 64 || empty { Err(Abort::PDO_LENGTH) } else { Ok(()) }
    }

    /// Whether the process data object with these communication parameters exchanges data.
    pub fn is_on(&self, parameters: u16) -> bool {
        self.u32(parameters, 1) & INVALID == 0
    }

    /// Index and bytes of every object mapped at `index`, in order.
    pub fn mapped(&self, index: u16) -> impl Iterator<Item = (u16, usize)> {
        let count = self.u32(index, 0).min(MAPPED_MAX);
        (1..=count).map(move |sub| {
            let entry = self.u32(index, sub as u8);
            ((entry >> 16) as u16, (entry & 0xFF) as usize / 8)
        })
    }

    fn cob_id(&self, parameters: u16) -> u32 {
        u32::from(self.node.get()) + if parameters == 0x1400 { 0x200 } else { 0x180 }
    }
}

/// Whether a mapping entry is a whole object of the list: index, subindex 0, its bits.
fn mappable(list: &[u16], entry: u32) -> bool {
    let index = (entry >> 16) as u16;
    let len = at(ObjectId::new(index, 0)).map(|at| u32::from(ROWS[at].2) * 8);
    list.contains(&index) && len == Some(entry & 0xFFFF)
}

fn at(ObjectId { index, sub }: ObjectId) -> Option<usize> {
    ROWS.binary_search_by_key(&(index, sub), |row| (row.0, row.1)).ok()
}

fn known(object: ObjectId) -> Result<usize, Abort> {
    let other = if ROWS.iter().any(|row| row.0 == object.index) { Abort::NO_SUBINDEX } else { Abort::NO_OBJECT };
    at(object).ok_or(other)
}
