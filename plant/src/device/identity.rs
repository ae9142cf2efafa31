//! Identity of a simulated device: the objects a manager compares with its description, and a technician reads.
//!
//! The names are longer than four bytes, so that reading them takes a segmented transfer as with a real device.

use linewright_canopen::codec::{Abort, NodeId};
use linewright_canopen::sdo::ObjectId;

/// Vendor: none was ever assigned to a simulation.
const VENDOR: u32 = 0;
/// Product: the profile it has.
const PRODUCT: u32 = 401;
/// Revision: major 1 in the upper half, minor 0 in the lower (CiA 301 §7.5.2.19).
const REVISION: u32 = 0x0001_0000;

/// Objects 1008h, 1009h, 100Ah and 1018h; `None` for any other.
pub(super) fn read(node: NodeId, object: ObjectId) -> Option<Result<Vec<u8>, Abort>> {
    Some(match (object.index, object.sub) {
        (0x1008, 0) => Ok(b"Linewright simulated I/O".into()),
        (0x1009, 0) => Ok(b"simulated".into()),
        (0x100A, 0) => Ok(env!("CARGO_PKG_VERSION").into()),
        (0x1018, 0) => Ok(vec![4]),
        (0x1018, 1) => Ok(VENDOR.to_le_bytes().into()),
        (0x1018, 2) => Ok(PRODUCT.to_le_bytes().into()),
        (0x1018, 3) => Ok(REVISION.to_le_bytes().into()),
        // Serial number: no two of a bus are the same.
        (0x1018, 4) => Ok(u32::from(node.get()).to_le_bytes().into()),
        (0x1008..=0x100A | 0x1018, _) => Err(Abort::NO_SUBINDEX),
        _ => return None,
    })
}
