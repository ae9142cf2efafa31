//! Values, and their form in a file.

use std::fmt;
use std::fmt::Write as _;

use linewright_diagnostics::shown;

use crate::data_type::{DataType, EncodeError, ValueShape};
use crate::number::{self, NotANumber};

/// A CANopen node id: 1 to 127.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(u8);

impl NodeId {
    /// The lowest one.
    pub const FIRST: NodeId = NodeId(1);

    /// The node id of this number; `None` if there is none.
    pub fn new(id: u8) -> Option<Self> {
        (1..=127).contains(&id).then_some(NodeId(id))
    }

    /// The node id, 1 to 127.
    pub fn get(self) -> u8 {
        self.0
    }
}

impl fmt::Display for NodeId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:02X}h", self.0)
    }
}

/// Value of an entry.
#[derive(Clone, Debug, PartialEq)]
pub enum ObjectValue {
    Boolean(bool),
    /// The signed types.
    Integer(i64),
    /// The unsigned types, and the two times as they are transferred.
    Unsigned(u64),
    Real32(f32),
    Real64(f64),
    /// VISIBLE_STRING and UNICODE_STRING.
    Text(String),
    /// OCTET_STRING, DOMAIN, and every type this crate does not support.
    Bytes(Vec<u8>),
}

impl ObjectValue {
    /// The whole number it is.
    pub(crate) fn whole(&self) -> Option<i128> {
        match *self {
            ObjectValue::Boolean(value) => Some(value.into()),
            ObjectValue::Integer(value) => Some(value.into()),
            ObjectValue::Unsigned(value) => Some(value.into()),
            ObjectValue::Real32(_) | ObjectValue::Real64(_) | ObjectValue::Text(_) | ObjectValue::Bytes(_) => None,
        }
    }

    /// The unsigned number it is, if it is one.
    pub fn as_u64(&self) -> Option<u64> {
        self.whole().and_then(|value| u64::try_from(value).ok())
    }

    /// Whether it is real and no number: it has no order, and is between no limits.
    pub(crate) fn is_no_number(&self) -> bool {
        match self {
            ObjectValue::Real32(value) => value.is_nan(),
            ObjectValue::Real64(value) => value.is_nan(),
            ObjectValue::Boolean(_)
            | ObjectValue::Integer(_)
            | ObjectValue::Unsigned(_)
            | ObjectValue::Text(_)
            | ObjectValue::Bytes(_) => false,
        }
    }

    /// Whether it is less than `other`; `None` between values that have no order.
    pub(crate) fn is_less(&self, other: &ObjectValue) -> Option<bool> {
        match (self, other) {
            (ObjectValue::Real32(a), ObjectValue::Real32(b)) => Some(a < b),
            (ObjectValue::Real64(a), ObjectValue::Real64(b)) => Some(a < b),
            _ => Some(self.whole()? < other.whole()?),
        }
    }
}

impl fmt::Display for ObjectValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ObjectValue::Boolean(value) => write!(f, "{}", u8::from(*value)),
            ObjectValue::Integer(value) => write!(f, "{value}"),
            ObjectValue::Unsigned(value) if *value > 9 => write!(f, "{value} (0x{value:X})"),
            ObjectValue::Unsigned(value) => write!(f, "{value}"),
            ObjectValue::Real32(value) => write!(f, "{value}"),
            ObjectValue::Real64(value) => write!(f, "{value}"),
            ObjectValue::Text(text) => write!(f, "`{}`", shown(text)),
            ObjectValue::Bytes(bytes) => {
                const SHOWN: usize = 16;
                let shown = bytes.iter().take(SHOWN).map(|byte| format!("{byte:02X}")).collect::<Vec<_>>().join(" ");
                write!(f, "{shown}{}", if bytes.len() > SHOWN { " …" } else { "" })
            }
        }
    }
}

/// A value as a file states it: itself, or to be added to the node id the device will have.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueSetting {
    pub(crate) value: ObjectValue,
    pub(crate) plus_node_id: bool,
}

impl ValueSetting {
    /// A value that is the same for every node id.
    pub fn fixed(value: ObjectValue) -> Self {
        ValueSetting { value, plus_node_id: false }
    }

    pub fn for_node(&self, node: NodeId) -> ObjectValue {
        match self.value {
            // What is read fits its type with every node id.
            ObjectValue::Integer(value) if self.plus_node_id => {
                ObjectValue::Integer(value.saturating_add(node.get().into()))
            }
            ObjectValue::Unsigned(value) if self.plus_node_id => {
                ObjectValue::Unsigned(value.saturating_add(node.get().into()))
            }
            _ => self.value.clone(),
        }
    }

    /// The value, if it is the same for every node id.
    pub fn constant(&self) -> Option<&ObjectValue> {
        (!self.plus_node_id).then_some(&self.value)
    }
}

/// Reason why a text is no value of a type.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum BadValue {
    Number(NotANumber),
    /// A number, but not one of the type; true if only with some node ids.
    Range {
        text: String,
        data_type: DataType,
        with_node_id: bool,
    },
    /// A number that a type of this kind is not written as.
    Real(String),
    Hex(String),
    /// A character that a VISIBLE_STRING does not have.
    Character(char),
    Unknown(u16),
}

impl BadValue {
    /// Advice.
    pub(crate) fn hint(&self) -> String {
        match self {
            BadValue::Number(number) => number.hint().to_owned(),
            BadValue::Range { data_type, with_node_id, .. } => match data_type.shape().limits() {
                Some((least, most)) if *with_node_id => {
                    format!("with every node id up to 127 it must be {least} to {most}, or the DataType is wrong")
                }
                Some((least, most)) => format!("it must be {least} to {most}, or the DataType is wrong"),
                None => "the DataType may be wrong".to_owned(),
            },
            BadValue::Real(_) => "write it as 1.5 or 15e-1, or in hexadecimal with all of its bits".to_owned(),
            BadValue::Hex(_) => "write the bytes as pairs of hexadecimal digits, such as 01 2A FF".to_owned(),
            BadValue::Character(_) => "a VISIBLE_STRING has one byte per character; write it with others".to_owned(),
            BadValue::Unknown(_) => "give the entry a data type of CiA 301, or set it by other means".to_owned(),
        }
    }

    /// Whether it is about a number, which every tool reads in the same way.
    pub(crate) fn is_certain(&self) -> bool {
        matches!(self, BadValue::Number(_) | BadValue::Range { .. })
    }
}

impl fmt::Display for BadValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BadValue::Number(number) => number.fmt(f),
            BadValue::Range { text, data_type, .. } => write!(f, "`{}` does not fit into {data_type}", shown(text)),
            BadValue::Real(text) => write!(f, "`{}` is not understood as a real number", shown(text)),
            BadValue::Hex(text) => write!(f, "`{}` is not understood as bytes", shown(text)),
            BadValue::Character(c) => write!(f, "VISIBLE_STRING has no character `{c}`"),
            BadValue::Unknown(code) => {
                write!(f, "a value of data type 0x{code:04X}, which is not known, means nothing")
            }
        }
    }
}

/// Value of a text for a type, and whether it was octal.
pub(crate) fn read(text: &str, data_type: DataType) -> Result<(ValueSetting, bool), BadValue> {
    let fixed = |value| Ok((ValueSetting::fixed(value), false));
    match data_type.shape() {
        ValueShape::Text => match text.chars().find(|c| u32::from(*c) > 0xFF) {
            Some(c) => Err(BadValue::Character(c)),
            None => fixed(ObjectValue::Text(text.to_owned())),
        },
        ValueShape::Utf16 => fixed(ObjectValue::Text(text.to_owned())),
        ValueShape::Bytes => match hex_bytes(text) {
            Some(bytes) => fixed(ObjectValue::Bytes(bytes)),
            None => Err(BadValue::Hex(text.to_owned())),
        },
        ValueShape::Real32 => match bits(text, 4)? {
            Some(bits) => fixed(ObjectValue::Real32(f32::from_bits(bits as u32))),
            None => fixed(ObjectValue::Real32(text.trim().parse().map_err(|_| BadValue::Real(text.to_owned()))?)),
        },
        ValueShape::Real64 => match bits(text, 8)? {
            Some(bits) => fixed(ObjectValue::Real64(f64::from_bits(bits))),
            None => fixed(ObjectValue::Real64(text.trim().parse().map_err(|_| BadValue::Real(text.to_owned()))?)),
        },
        ValueShape::Unknown => Err(BadValue::Unknown(data_type.code())),
        shape @ (ValueShape::Boolean | ValueShape::Signed(_) | ValueShape::Unsigned(_)) => {
            if matches!(data_type, DataType::TimeOfDay | DataType::TimeDifference)
                && let Some(time) = days_and_millis(text)
            {
                return fixed(ObjectValue::Unsigned(time));
            }
            let (number, plus_node_id) = number::sum(text).map_err(BadValue::Number)?;
            let range = || BadValue::Range { text: text.to_owned(), data_type, with_node_id: plus_node_id };
            let (least, most) = shape.limits().ok_or_else(range)?;
            let mut value = number.value;
            if let ValueShape::Signed(bytes) = shape
                && number.is_hex
                && (most + 1..1 << (8 * u32::from(bytes))).contains(&value)
            {
                // Hexadecimal of a signed type is also written as its bits: 0xFF is −1 of eight.
                value -= 1 << (8 * u32::from(bytes));
            }
            let largest = value + if plus_node_id { 127 } else { 0 };
            if value < least || largest > most || (plus_node_id && shape == ValueShape::Boolean) {
                return Err(range());
            }
            let value = match shape {
                ValueShape::Boolean => ObjectValue::Boolean(value != 0),
                ValueShape::Signed(_) => ObjectValue::Integer(i64::try_from(value).map_err(|_| range())?),
                _ => ObjectValue::Unsigned(u64::try_from(value).map_err(|_| range())?),
            };
            Ok((ValueSetting { value, plus_node_id }, number.is_octal))
        }
    }
}

/// Text of a value of a type, such that [`read`] gives the same value.
pub(crate) fn write(value: &ObjectValue, data_type: DataType) -> Result<String, EncodeError> {
    let bytes = data_type.encode(value)?;
    Ok(match value {
        ObjectValue::Boolean(_) | ObjectValue::Integer(_) | ObjectValue::Unsigned(_) => {
            let number = value.whole().unwrap_or_default();
            match data_type.shape() {
                ValueShape::Unsigned(size) if number > 9 => {
                    format!("0x{number:0width$X}", width = 2 * usize::from(size))
                }
                _ => number.to_string(),
            }
        }
        ObjectValue::Real32(real) => format!("{real:?}"),
        ObjectValue::Real64(real) => format!("{real:?}"),
        ObjectValue::Text(text) => text.clone(),
        ObjectValue::Bytes(_) => bytes.iter().fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02X}");
            text
        }),
    })
}

/// Hexadecimal of a real type is its bits, all of them; a shorter one might be anything, unless it is zero.
fn bits(text: &str, bytes: usize) -> Result<Option<u64>, BadValue> {
    let text = text.trim();
    match number::number(text) {
        Ok(number) if number.is_hex => match u64::try_from(number.value) {
            Ok(bits) if bits == 0 || text.len() == 2 + 2 * bytes => Ok(Some(bits)),
            _ => Err(BadValue::Real(text.to_owned())),
        },
        _ => Ok(None),
    }
}

/// Days and milliseconds, as two numbers: the two times are transferred as one of 48 bits (CiA 301 §7.1.6.5).
fn days_and_millis(text: &str) -> Option<u64> {
    let (days, millis) = text.trim().split_once(char::is_whitespace)?;
    let (days, millis) = (number::number(days).ok()?.value, number::number(millis.trim()).ok()?.value);
    let days = u64::from(u16::try_from(days).ok()?);
    let millis = u64::try_from(millis).ok().filter(|millis| *millis < 1 << 28)?;
    Some(days << 32 | millis)
}

fn hex_bytes(text: &str) -> Option<Vec<u8>> {
    let digits: Option<Vec<u8>> = text
        .chars()
        .filter(|c| !c.is_whitespace())
        .map(|c| c.to_digit(16).and_then(|digit| u8::try_from(digit).ok()))
        .collect();
    let (pairs, rest) = digits.as_deref()?.as_chunks::<2>();
    rest.is_empty().then(|| pairs.iter().map(|[high, low]| high << 4 | low).collect())
}
