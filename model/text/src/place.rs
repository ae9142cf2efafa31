//! Values with the place they were written at.

use std::ops::Range;

/// A stretch of the text, in bytes.
pub type TextRange = Range<usize>;

/// A value and the place it was written at.
#[derive(Clone, Debug, PartialEq)]
pub struct Located<T> {
    pub value: T,
    /// Its place.
    pub at: TextRange,
}

/// A text and its place.
pub type LocatedName = Located<String>;

/// Values under names that are the user's own.
pub type Named<T> = Vec<(LocatedName, T)>;

impl<T> Located<T> {
    /// A value written there.
    pub fn new(value: T, at: TextRange) -> Self {
        Located { value, at }
    }

    /// Another value, made from this one, at the same place.
    pub fn map<U>(self, make: impl FnOnce(T) -> U) -> Located<U> {
        Located { value: make(self.value), at: self.at }
    }
}

pub fn or<T: Copy>(written: &Option<Located<T>>, usual: T) -> T {
    written.as_ref().map_or(usual, |written| written.value)
}

/// A value that may be a text or a whole number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Scalar {
    Text(String),
    /// A whole number.
    Integer(i64),
}
