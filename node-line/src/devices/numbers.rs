//! Numbers of objects, as the services have them.

use linewright_msgs::CoReadIdRequest;

/// Length of an object of this type (CiA 301 table 44), in bytes; `None` for a type the service does not support.
pub fn bytes_of(datatype: u8) -> Option<usize> {
    match datatype {
        CoReadIdRequest::CANOPEN_DATATYPE_INT8 | CoReadIdRequest::CANOPEN_DATATYPE_UINT8 => Some(1),
        CoReadIdRequest::CANOPEN_DATATYPE_INT16 | CoReadIdRequest::CANOPEN_DATATYPE_UINT16 => Some(2),
        CoReadIdRequest::CANOPEN_DATATYPE_INT32 | CoReadIdRequest::CANOPEN_DATATYPE_UINT32 => Some(4),
        _ => None,
    }
}

/// Whether it is one of the signed types.
pub fn is_signed(datatype: u8) -> bool {
    (CoReadIdRequest::CANOPEN_DATATYPE_INT8..=CoReadIdRequest::CANOPEN_DATATYPE_INT32).contains(&datatype)
}

/// A negative number of a short type without its sign in the bytes above it; any other value as it is.
pub fn low_bytes(value: u32, bytes: Option<usize>) -> u32 {
    match bytes {
        Some(bytes @ 1..=3) if value >> (8 * bytes - 1) == u32::MAX >> (8 * bytes - 1) => {
            value & ((1 << (8 * bytes)) - 1)
        }
        _ => value,
    }
}

/// A value that has been read, as a number; `None` if it is longer.
pub fn number(bytes: &[u8]) -> Option<u32> {
    let mut all = [0; 4];
    all.get_mut(..bytes.len())?.copy_from_slice(bytes);
    Some(u32::from_le_bytes(all))
}
