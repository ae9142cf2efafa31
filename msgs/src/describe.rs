//! How a Rust type is called in a `.msg` file, and what keeps it in bounds.
//!
//! [`RosField`] is implemented for exactly the types a `.msg` file can name, so a struct whose fields
//! all implement it has a `.msg` spelling that follows from its Rust definition and needs no second
//! list to be kept.

use crate::invalid::{ITEMS_MAX, Invalid, TEXT_BYTES_MAX, at_most};
use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;
use std::marker::PhantomData;

/// A field type with its ROS 2 spelling.
pub trait RosField {
    /// `uint8`, `string[]`, `std_msgs/Header`, …
    fn ros_type() -> String;

    /// Checks the lengths inside this value; `path` names it in the error.
    fn check_bounds(&self, path: &str) -> Result<(), Invalid>;
}

/// One field as the `.msg` file spells it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// ROS 2 type.
    pub ros_type: String,
    /// Name.
    pub name: &'static str,
}

/// One constant as the `.msg` file spells it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Constant {
    /// ROS 2 type.
    pub ros_type: String,
    /// Name.
    pub name: &'static str,
    /// Value in decimal.
    pub value: String,
}

/// A message: a struct that has a `.msg` file.
pub trait RosMessage: Serialize + for<'de> Deserialize<'de> + Send + Sync + 'static {
    /// ROS 2 package.
    const PACKAGE: &'static str;
    /// Name within the package.
    const NAME: &'static str;

    /// Fields in wire order.
    fn fields() -> Vec<Field>;
    /// Constants in the order of the file.
    fn constants() -> Vec<Constant>;
    /// Checks every length; errors name the field.
    fn bounds(&self, path: &str) -> Result<(), Invalid>;
    /// Checks lengths and meaning. Nothing received is used before this said yes.
    fn validate(&self) -> Result<(), Invalid>;
}

macro_rules! plain_field {
    ($($rust:ty => $ros:literal),* $(,)?) => {$(
        impl RosField for $rust {
            fn ros_type() -> String { $ros.to_owned() }
            fn check_bounds(&self, _path: &str) -> Result<(), Invalid> { Ok(()) }
        }
    )*};
}

plain_field! {
    bool => "bool", i8 => "int8", u8 => "uint8", u16 => "uint16", u32 => "uint32", u64 => "uint64", i32 => "int32",
}

impl RosField for String {
    fn ros_type() -> String {
        "string".to_owned()
    }
    fn check_bounds(&self, path: &str) -> Result<(), Invalid> {
        at_most(path, self.len(), TEXT_BYTES_MAX)
    }
}

impl<T: RosField> RosField for Vec<T> {
    fn ros_type() -> String {
        format!("{}[]", T::ros_type())
    }
    fn check_bounds(&self, path: &str) -> Result<(), Invalid> {
        at_most(path, self.len(), ITEMS_MAX)?;
        self.iter().try_for_each(|item| item.check_bounds(path))
    }
}

/// A sequence of at most `N` elements, `T[<=N]` in a `.msg` file. Decoding stops at the bound.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Bounded<T, const N: usize>(Vec<T>);

impl<T, const N: usize> Bounded<T, N> {
    /// Takes the elements if there are at most `N`.
    pub fn new(items: Vec<T>) -> Result<Self, Invalid> {
        at_most("sequence", items.len(), N)?;
        Ok(Self(items))
    }

    /// The elements.
    pub fn as_slice(&self) -> &[T] {
        &self.0
    }
}

impl<T: RosField, const N: usize> RosField for Bounded<T, N> {
    fn ros_type() -> String {
        format!("{}[<={N}]", T::ros_type())
    }
    fn check_bounds(&self, path: &str) -> Result<(), Invalid> {
        self.0.iter().try_for_each(|item| item.check_bounds(path))
    }
}

impl<T: Serialize, const N: usize> Serialize for Bounded<T, N> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl<'de, T: Deserialize<'de>, const N: usize> Deserialize<'de> for Bounded<T, N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(UpTo::<T, N>(PhantomData))
    }
}

struct UpTo<T, const N: usize>(PhantomData<T>);

impl<'de, T: Deserialize<'de>, const N: usize> Visitor<'de> for UpTo<T, N> {
    type Value = Bounded<T, N>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a sequence of at most {N} elements")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = seq.next_element()? {
            if items.len() == N {
                return Err(A::Error::invalid_length(N + 1, &self));
            }
            items.push(item);
        }
        Ok(Bounded(items))
    }
}
