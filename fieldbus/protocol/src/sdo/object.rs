//! Address of an object in a dictionary: index and subindex.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// An entry of an object dictionary (CiA 301 §7.4.1), written `1018h:01`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObjectId {
    pub index: u16,
    /// Subindex; 0 for an object without any.
    pub sub: u8,
}

#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("`{text}` is not an object: expected index and subindex in hexadecimal, as in 1018:01 or 1008")]
pub struct ObjectIdError {
    pub text: String,
}

impl ObjectId {
    pub const fn new(index: u16, sub: u8) -> Self {
        ObjectId { index, sub }
    }
}

impl fmt::Display for ObjectId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h:{:02X}", self.index, self.sub)
    }
}

impl FromStr for ObjectId {
    type Err = ObjectIdError;

    /// `1018:01`, `0x1018:1`, `1018h:01`; without a subindex it is 0. Both numbers are hexadecimal.
    fn from_str(text: &str) -> Result<Self, ObjectIdError> {
        let error = || ObjectIdError { text: text.to_owned() };
        let (index, sub) = text.split_once(':').unwrap_or((text, "0"));
        let index = hex(index).and_then(|index| u16::try_from(index).ok()).ok_or_else(error)?;
        let sub = hex(sub).and_then(|sub| u8::try_from(sub).ok()).ok_or_else(error)?;
        Ok(ObjectId { index, sub })
    }
}

fn hex(text: &str) -> Option<u32> {
    let text = text.strip_suffix(['h', 'H']).unwrap_or(text);
    let text = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")).unwrap_or(text);
    // `from_str_radix` takes a sign.
    if text.starts_with('+') { None } else { u32::from_str_radix(text, 16).ok() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_are_read_as_people_write_them() {
        let object = ObjectId::new(0x1018, 1);
        for text in ["1018:01", "0x1018:1", "1018h:01", "1018H:0x1", "1018h:01h"] {
            assert_eq!(text.parse(), Ok(object), "{text}");
        }
        assert_eq!(object.to_string().parse(), Ok(object));
        assert_eq!("6200".parse(), Ok(ObjectId::new(0x6200, 0)));
        for text in ["", "1018:", ":1", "10180", "1018:100", "+1018", "zzzz", "1018:1:1"] {
            assert!(text.parse::<ObjectId>().unwrap_err().to_string().contains(text), "{text}");
        }
    }
}
