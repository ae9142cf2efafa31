//! Sequences with a bound, which decoding keeps.

use crate::Invalid;
use crate::invalid::at_most;
use crate::message::RosField;
use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;
use std::marker::PhantomData;

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
