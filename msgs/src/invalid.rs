//! Faults of a message that decoded.
//!
//! CDR gives the end of a field, not the validity of its content: a sequence may be as long as the datagram allows and
//! an enumeration may carry any number. The bounds here are far above what a line needs and far below what would hurt a
//! reader.

use thiserror::Error;

/// Most elements of any unbounded sequence. A line of a thousand stations still fits.
pub const ITEMS_MAX: usize = 4096;

/// Most bytes of any string. Texts are for people and for names.
pub const TEXT_BYTES_MAX: usize = 4096;

/// A text that is not too long for a message: one that is ends in `…`. A message with a longer one is dropped.
pub fn fitting(text: String) -> String {
    cut(text, TEXT_BYTES_MAX)
}

/// A text of at most `most` bytes: one that is longer ends in `…`.
pub fn cut(mut text: String, most: usize) -> String {
    const MORE: &str = " …";
    if text.len() > most {
        let end = (0..=most.saturating_sub(MORE.len())).rev().find(|&at| text.is_char_boundary(at));
        text.truncate(end.unwrap_or(0));
        text.push_str(MORE);
    }
    text
}

/// A decoded message that must not be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Invalid {
    /// A sequence or a string exceeds its bound.
    #[error("{field} holds {length}, at most {limit} are accepted")]
    TooLong {
        /// Path of the field inside the message.
        field: String,
        /// Elements of the sequence, or bytes of the string.
        length: usize,
        /// The bound.
        limit: usize,
    },
    /// An enumeration has a number that is unknown in this version.
    #[error("{field} is {value}, known are {least} to {most}")]
    UnknownValue {
        /// Name of the field.
        field: &'static str,
        /// Its value.
        value: u8,
        least: u8,
        most: u8,
    },
    /// Two sequences that run in parallel differ in length.
    #[error("{field} holds {length} elements but {other} holds {other_length}")]
    LengthsDiffer {
        /// One sequence.
        field: &'static str,
        /// Its length.
        length: usize,
        /// The sequence it runs in parallel with.
        other: &'static str,
        /// Length of the other sequence.
        other_length: usize,
    },
    /// A field that identifies something is zero or empty.
    #[error("{field} must not be zero or empty")]
    Missing {
        /// Name of the field.
        field: &'static str,
    },
    /// An index names an operation that the message itself does not list.
    #[error("{field} names operation {index}, the station lists {count}")]
    NoSuchOperation {
        /// Name of the field.
        field: &'static str,
        /// The index.
        index: u16,
        /// Operations listed.
        count: usize,
    },
}

pub(crate) fn at_most(field: &str, length: usize, limit: usize) -> Result<(), Invalid> {
    if length <= limit { Ok(()) } else { Err(Invalid::TooLong { field: field.to_owned(), length, limit }) }
}

pub(crate) fn within(field: &'static str, value: u8, least: u8, most: u8) -> Result<(), Invalid> {
    if (least..=most).contains(&value) { Ok(()) } else { Err(Invalid::UnknownValue { field, value, least, most }) }
}

pub(crate) fn parallel(
    (field, length): (&'static str, usize),
    (other, other_length): (&'static str, usize),
) -> Result<(), Invalid> {
    if length == other_length { Ok(()) } else { Err(Invalid::LengthsDiffer { field, length, other, other_length }) }
}

pub(crate) fn present(field: &'static str, there: bool) -> Result<(), Invalid> {
    if there { Ok(()) } else { Err(Invalid::Missing { field }) }
}

pub(crate) fn indices(field: &'static str, indices: &[u16], count: usize) -> Result<(), Invalid> {
    match indices.iter().find(|index| usize::from(**index) >= count) {
        Some(&index) => Err(Invalid::NoSuchOperation { field, index, count }),
        None => Ok(()),
    }
}
