//! Why a transfer ends without result, in the words of the standard.

use std::fmt;

/// An abort code (CiA 301 table 22). A code that is not in the table survives as a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Abort(pub u32);

/// Declares the codes of the table, with a description of each.
macro_rules! codes {
    ($($name:ident = $code:literal, $words:literal;)*) => {
        impl Abort {
            $(#[doc = concat!("`", stringify!($code), "`: ", $words, ".")]
            pub const $name: Abort = Abort($code);)*

            /// Every code of the table, in its order.
            pub const ALL: &[Abort] = &[$(Abort::$name),*];

            /// Meaning of the code; `None` for one that is not in the table.
            pub fn meaning(self) -> Option<&'static str> {
                match self {
                    $(Abort::$name => Some($words),)*
                    _ => None,
                }
            }
        }
    };
}

codes! {
    TOGGLE = 0x0503_0000, "toggle bit not alternated";
    TIMEOUT = 0x0504_0000, "SDO protocol timed out";
    COMMAND = 0x0504_0001, "unknown command";
    BLOCK_SIZE = 0x0504_0002, "invalid block size";
    SEQUENCE = 0x0504_0003, "invalid sequence number";
    CRC = 0x0504_0004, "checksum error";
    OUT_OF_MEMORY = 0x0504_0005, "out of memory";
    ACCESS = 0x0601_0000, "unsupported access to the object";
    WRITE_ONLY = 0x0601_0001, "object is write only";
    READ_ONLY = 0x0601_0002, "object is read only";
    NO_OBJECT = 0x0602_0000, "no such object";
    NOT_MAPPABLE = 0x0604_0041, "object cannot be mapped to the PDO";
    PDO_LENGTH = 0x0604_0042, "objects mapped are longer than the PDO";
    PARAMETER = 0x0604_0043, "parameter incompatible";
    INTERNAL = 0x0604_0047, "device internally incompatible";
    HARDWARE = 0x0606_0000, "access failed, hardware error";
    LENGTH = 0x0607_0010, "wrong length";
    TOO_LONG = 0x0607_0012, "wrong length, too long";
    TOO_SHORT = 0x0607_0013, "wrong length, too short";
    NO_SUBINDEX = 0x0609_0011, "no such subindex";
    VALUE = 0x0609_0030, "invalid value";
    VALUE_HIGH = 0x0609_0031, "value too high";
    VALUE_LOW = 0x0609_0032, "value too low";
    MAX_BELOW_MIN = 0x0609_0036, "maximum is less than minimum";
    NO_CONNECTION = 0x060A_0023, "no SDO connection available";
    GENERAL = 0x0800_0000, "general error";
    NOT_STORED = 0x0800_0020, "data cannot be transferred or stored";
    LOCAL_CONTROL = 0x0800_0021, "data cannot be stored, local control";
    DEVICE_STATE = 0x0800_0022, "data cannot be stored in the present device state";
    NO_DICTIONARY = 0x0800_0023, "no object dictionary";
    NO_DATA = 0x0800_0024, "no data available";
}

impl fmt::Display for Abort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let meaning = self.meaning().unwrap_or("a code of the manufacturer's own");
        write!(f, "{:08X}h ({meaning})", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_whole_and_in_order() {
        assert_eq!(Abort::ALL.len(), 31);
        assert!(Abort::ALL.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert_eq!(Abort::NO_OBJECT.to_string(), "06020000h (no such object)");
        assert_eq!(Abort(0x1234_5678).to_string(), "12345678h (a code of the manufacturer's own)");
    }
}
