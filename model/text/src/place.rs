//! Values with the place they were written at.

use std::ops::Range;

/// A stretch of the text, in bytes.
pub type Where = Range<usize>;

/// A value and the place it was written at.
#[derive(Clone, Debug, PartialEq)]
pub struct At<T> {
    /// The value.
    pub value: T,
    /// Its place.
    pub at: Where,
}

/// A text and its place.
pub type Name = At<String>;

/// Values under names that are the user's own.
pub type Named<T> = Vec<(Name, T)>;

impl<T> At<T> {
    /// A value written there.
    pub fn new(value: T, at: Where) -> Self {
        At { value, at }
    }

    /// Something else of the same place.
    pub fn map<U>(self, make: impl FnOnce(T) -> U) -> At<U> {
        At { value: make(self.value), at: self.at }
    }
}

/// What is written, or what is usual.
pub fn or<T: Copy>(written: &Option<At<T>>, usual: T) -> T {
    written.as_ref().map_or(usual, |written| written.value)
}
