//! A message taken as the bytes it came in.
//!
//! The meaning of a request depends on its sender (see [`crate::service`]), and the middleware decodes only once. So it
//! is given a type that takes every byte there is, up to a limit above all valid requests.

use std::fmt;

use linewright_msgs::RosMessage;
use serde::de::{SeqAccess, Visitor};
use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Bytes that some middleware adds behind a message, so that the next one is aligned.
const PADDING_MAX: usize = 3;

/// The message in these bytes, if it is valid, and all that is in them.
pub(crate) fn exactly<T: RosMessage>(bytes: &[u8]) -> Option<T> {
    let (message, consumed) = cdr_encoding::from_bytes::<T, byteorder::LittleEndian>(bytes).ok()?;
    (bytes.len() - consumed <= PADDING_MAX && message.validate().is_ok()).then_some(message)
}

/// At most `MAX` bytes. More than that are not looked at.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Bytes<const MAX: usize>(pub(crate) Vec<u8>);

impl<const MAX: usize> Serialize for Bytes<MAX> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        self.0.iter().try_for_each(|byte| tuple.serialize_element(byte))?;
        tuple.end()
    }
}

impl<'de, const MAX: usize> Deserialize<'de> for Bytes<MAX> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple(MAX, UntilTheEnd::<MAX>)
    }
}

struct UntilTheEnd<const MAX: usize>;

impl<'de, const MAX: usize> Visitor<'de> for UntilTheEnd<MAX> {
    type Value = Bytes<MAX>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at most {MAX} bytes")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
        let mut bytes = Vec::new();
        // The decoder ends by an error; there is nothing else a byte could fail for.
        while let Ok(Some(byte)) = seq.next_element() {
            bytes.push(byte);
        }
        Ok(Bytes(bytes))
    }
}

impl<const MAX: usize> ros2_client::Message for Bytes<MAX> {}
