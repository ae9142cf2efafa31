//! Additions to the fields for Rust programs: images as numbers, and short ways to write small messages.

use crate::{Bounded, KeyValue, ProcessImage, StationState, Text};
use serde::{Deserialize, Serialize};
use std::fmt;

/// The most entries of each list of a [`CellState`](crate::CellState): the bound in its file.
pub const LISTED_MAX: usize = 100;

/// A `byte` of a `.msg` file: eight bits without a meaning as a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Byte(pub u8);

impl fmt::Display for Byte {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl From<&str> for Text {
    fn from(data: &str) -> Self {
        Self { data: data.to_owned() }
    }
}

impl KeyValue {
    /// A detail.
    pub fn new(key: impl Into<String>, value: impl Into<String>) -> Self {
        KeyValue { key: key.into(), value: value.into() }
    }
}

impl ProcessImage {
    /// The image as one number, bit n in bit n.
    pub fn word(&self) -> u128 {
        word_of(&self.bits)
    }

    /// Sets all 128 bits.
    pub fn set_word(&mut self, word: u128) {
        self.bits = image_of(word);
    }
}

impl StationState {
    /// Its input image as one number, bit n in bit n.
    pub fn measured_word(&self) -> u128 {
        word_of(&self.measured)
    }

    /// Sets all 128 bits of its input image.
    pub fn set_measured(&mut self, word: u128) {
        self.measured = image_of(word);
    }
}

fn word_of(bits: &Bounded<u8, 16>) -> u128 {
    let mut bytes = [0; 16];
    for (to, from) in bytes.iter_mut().zip(bits.as_slice()) {
        *to = *from;
    }
    u128::from_le_bytes(bytes)
}

/// Sixteen bytes are exactly the bound, so this cannot be refused.
fn image_of(word: u128) -> Bounded<u8, 16> {
    Bounded::new(word.to_le_bytes().to_vec()).unwrap_or_default()
}
