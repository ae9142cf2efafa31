//! The bytes that are written to an object, as numbers.

use linewright_canopen::codec::Abort;

/// The bytes of an object of `N` bytes.
pub(super) fn exactly<const N: usize>(data: &[u8]) -> Result<[u8; N], Abort> {
    data.try_into().map_err(|_| Abort::LENGTH)
}

/// A number of one to four bytes: the simulation's own objects are not particular about their size.
pub(super) fn number(data: &[u8]) -> Result<u32, Abort> {
    let mut bytes = [0; 4];
    bytes.get_mut(..data.len()).filter(|b| !b.is_empty()).ok_or(Abort::LENGTH)?.copy_from_slice(data);
    Ok(u32::from_le_bytes(bytes))
}
