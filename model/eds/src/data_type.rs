//! The basic data types of CiA 301 (§7.4.7, table 44), and values as the bytes of a transfer.
//!
//! Types of a profile or a manufacturer survive as numbers: their bytes mean nothing here.

use std::fmt;

use crate::value::ObjectValue;

/// Declares the types with their number, their name in the standard and their shape.
macro_rules! data_types {
    ($($variant:ident = $code:literal $name:literal $shape:expr;)*) => {
        /// Type of the bytes of an entry.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum DataType {
            $(#[doc = $name] $variant,)*
            /// A type this crate does not support, by its number.
            Other(u16),
        }

        impl DataType {
            /// All types this crate supports.
            pub const ALL: &[DataType] = &[$(DataType::$variant),*];

            /// The type with this number in an object dictionary.
            pub fn from_code(code: u16) -> Self {
                match code {
                    $($code => DataType::$variant,)*
                    other => DataType::Other(other),
                }
            }

            /// Its number in an object dictionary.
            pub fn code(self) -> u16 {
                match self {
                    $(DataType::$variant => $code,)*
                    DataType::Other(code) => code,
                }
            }

            pub(crate) fn shape(self) -> ValueShape {
                match self {
                    $(DataType::$variant => $shape,)*
                    DataType::Other(_) => ValueShape::Unknown,
                }
            }
        }

        impl fmt::Display for DataType {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                match self {
                    $(DataType::$variant => f.write_str($name),)*
                    DataType::Other(code) => write!(f, "data type 0x{code:04X}"),
                }
            }
        }
    };
}

data_types! {
    Boolean = 0x01 "BOOLEAN" ValueShape::Boolean;
    Integer8 = 0x02 "INTEGER8" ValueShape::Signed(1);
    Integer16 = 0x03 "INTEGER16" ValueShape::Signed(2);
    Integer32 = 0x04 "INTEGER32" ValueShape::Signed(4);
    Unsigned8 = 0x05 "UNSIGNED8" ValueShape::Unsigned(1);
    Unsigned16 = 0x06 "UNSIGNED16" ValueShape::Unsigned(2);
    Unsigned32 = 0x07 "UNSIGNED32" ValueShape::Unsigned(4);
    Real32 = 0x08 "REAL32" ValueShape::Real32;
    VisibleString = 0x09 "VISIBLE_STRING" ValueShape::Text;
    OctetString = 0x0A "OCTET_STRING" ValueShape::Bytes;
    UnicodeString = 0x0B "UNICODE_STRING" ValueShape::Utf16;
    TimeOfDay = 0x0C "TIME_OF_DAY" ValueShape::Unsigned(6);
    TimeDifference = 0x0D "TIME_DIFFERENCE" ValueShape::Unsigned(6);
    Domain = 0x0F "DOMAIN" ValueShape::Bytes;
    Integer24 = 0x10 "INTEGER24" ValueShape::Signed(3);
    Real64 = 0x11 "REAL64" ValueShape::Real64;
    Integer40 = 0x12 "INTEGER40" ValueShape::Signed(5);
    Integer48 = 0x13 "INTEGER48" ValueShape::Signed(6);
    Integer56 = 0x14 "INTEGER56" ValueShape::Signed(7);
    Integer64 = 0x15 "INTEGER64" ValueShape::Signed(8);
    Unsigned24 = 0x16 "UNSIGNED24" ValueShape::Unsigned(3);
    Unsigned40 = 0x18 "UNSIGNED40" ValueShape::Unsigned(5);
    Unsigned48 = 0x19 "UNSIGNED48" ValueShape::Unsigned(6);
    Unsigned56 = 0x1A "UNSIGNED56" ValueShape::Unsigned(7);
    Unsigned64 = 0x1B "UNSIGNED64" ValueShape::Unsigned(8);
}

/// Common shape of types. Numbers carry their size in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ValueShape {
    Boolean,
    Signed(u8),
    Unsigned(u8),
    Real32,
    Real64,
    Text,
    Bytes,
    Utf16,
    Unknown,
}

impl ValueShape {
    /// The least and the greatest value of a whole number.
    pub(crate) fn limits(self) -> Option<(i128, i128)> {
        match self {
            ValueShape::Boolean => Some((0, 1)),
            ValueShape::Signed(bytes) => {
                Some((-(1 << (8 * u32::from(bytes) - 1)), (1 << (8 * u32::from(bytes) - 1)) - 1))
            }
            ValueShape::Unsigned(bytes) => Some((0, (1 << (8 * u32::from(bytes))) - 1)),
            _ => None,
        }
    }
}

/// Reason why a value has no bytes of a type.
#[derive(Clone, Debug, PartialEq)]
pub enum EncodeError {
    /// The number is not among those of the type.
    OutOfRange { data_type: DataType, value: ObjectValue },
    /// A value of another kind is needed, such as a number instead of a text.
    WrongKind { data_type: DataType, value: ObjectValue },
    /// A VISIBLE_STRING has one byte per character.
    NoSuchCharacter(char),
    /// Only bytes can be given for a type this crate does not support.
    UnknownType(u16),
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EncodeError::OutOfRange { data_type, value } => match data_type.shape().limits() {
                Some((least, most)) => write!(f, "{value} is no {data_type}, which is {least} to {most}"),
                None => write!(f, "{value} is no {data_type}"),
            },
            EncodeError::WrongKind { data_type, value } => write!(f, "{value} is no value of {data_type}"),
            EncodeError::NoSuchCharacter(c) => write!(f, "VISIBLE_STRING has no character `{c}`"),
            EncodeError::UnknownType(code) => write!(f, "data type 0x{code:04X} is not known; give bytes"),
        }
    }
}

impl std::error::Error for EncodeError {}

/// Reason why bytes are no value of a type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueDecodeError {
    /// Another number of bytes is needed.
    Length {
        data_type: DataType,
        /// Number of bytes expected.
        expected: usize,
        /// Number of bytes found.
        actual: usize,
    },
    /// A UNICODE_STRING that is no UTF-16.
    NoText,
}

impl fmt::Display for ValueDecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ValueDecodeError::Length { data_type, expected, actual } => {
                write!(f, "{data_type} has {expected} bytes, not {actual}")
            }
            ValueDecodeError::NoText => f.write_str("these bytes are no UNICODE_STRING"),
        }
    }
}

impl std::error::Error for ValueDecodeError {}

impl DataType {
    /// Number of bytes of a value; `None` if that depends on the value or is not known.
    pub fn size(self) -> Option<usize> {
        match self.shape() {
            ValueShape::Boolean => Some(1),
            ValueShape::Signed(bytes) | ValueShape::Unsigned(bytes) => Some(bytes.into()),
            ValueShape::Real32 => Some(4),
            ValueShape::Real64 => Some(8),
            ValueShape::Text | ValueShape::Bytes | ValueShape::Utf16 | ValueShape::Unknown => None,
        }
    }

    /// The bytes of a value, as SDO and PDO carry them: little endian (CiA 301 §7.1.4).
    ///
    /// Whole numbers may be given as either kind of [`ObjectValue`]; of a type this crate does not support, bytes
    /// alone.
    ///
    /// # Errors
    /// The value is of another kind, or out of the range of the type.
    pub fn encode(self, value: &ObjectValue) -> Result<Vec<u8>, EncodeError> {
        let wrong = || EncodeError::WrongKind { data_type: self, value: value.clone() };
        match (self.shape(), value) {
            (ValueShape::Unknown, ObjectValue::Bytes(bytes)) | (ValueShape::Bytes, ObjectValue::Bytes(bytes)) => {
                Ok(bytes.clone())
            }
            (ValueShape::Unknown, _) => Err(EncodeError::UnknownType(self.code())),
            (ValueShape::Real32, ObjectValue::Real32(real)) => Ok(real.to_le_bytes().to_vec()),
            (ValueShape::Real64, ObjectValue::Real64(real)) => Ok(real.to_le_bytes().to_vec()),
            (ValueShape::Text, ObjectValue::Text(text)) => {
                text.chars().map(|c| u8::try_from(u32::from(c)).map_err(|_| EncodeError::NoSuchCharacter(c))).collect()
            }
            (ValueShape::Utf16, ObjectValue::Text(text)) => {
                Ok(text.encode_utf16().flat_map(u16::to_le_bytes).collect())
            }
            (shape, value) => {
                let ((least, most), number) = shape.limits().zip(value.whole()).ok_or_else(wrong)?;
                if !(least..=most).contains(&number) {
                    return Err(EncodeError::OutOfRange { data_type: self, value: value.clone() });
                }
                Ok(number.to_le_bytes()[..self.size().unwrap_or_default()].to_vec())
            }
        }
    }

    /// The value of bytes. Bytes of a type this crate does not support are their own value; zeros behind a
    /// VISIBLE_STRING, with which some devices fill it up, are none of its characters.
    ///
    /// # Errors
    /// A number of another length, or a UNICODE_STRING that is no text.
    pub fn decode(self, bytes: &[u8]) -> Result<ObjectValue, ValueDecodeError> {
        if let Some(expected) = self.size().filter(|expected| *expected != bytes.len()) {
            return Err(ValueDecodeError::Length { data_type: self, expected, actual: bytes.len() });
        }
        let mut raw = [0; 8];
        raw.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
        let unsigned = u64::from_le_bytes(raw);
        Ok(match self.shape() {
            ValueShape::Boolean => ObjectValue::Boolean(unsigned != 0),
            ValueShape::Unsigned(_) => ObjectValue::Unsigned(unsigned),
            ValueShape::Signed(bytes) => {
                let unused = 64 - 8 * u32::from(bytes);
                ObjectValue::Integer((unsigned << unused) as i64 >> unused)
            }
            ValueShape::Real32 => ObjectValue::Real32(f32::from_bits(unsigned as u32)),
            ValueShape::Real64 => ObjectValue::Real64(f64::from_bits(unsigned)),
            ValueShape::Text => {
                let text: String = bytes.iter().map(|&byte| char::from(byte)).collect();
                ObjectValue::Text(text.trim_end_matches('\0').to_owned())
            }
            ValueShape::Bytes | ValueShape::Unknown => ObjectValue::Bytes(bytes.to_vec()),
            ValueShape::Utf16 => {
                let (units, rest) = bytes.as_chunks::<2>();
                let units: Vec<u16> = units.iter().map(|unit| u16::from_le_bytes(*unit)).collect();
                let text =
                    String::from_utf16(&units).ok().filter(|_| rest.is_empty()).ok_or(ValueDecodeError::NoText)?;
                ObjectValue::Text(text)
            }
        })
    }
}
