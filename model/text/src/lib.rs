//! Descriptions written by people: text → tables of values with their places, and their problems.
//!
//! Common needs of readers of such files: problems that point into the text and give advice, tables read key by key
//! without losing a problem, names that are looked up, and "did you mean". The keys of a table are written down once, as
//! [`keys!`]: its reader follows from that, and the schema that editors use. It handles TOML and no key: the meaning of a
//! description is in the crates that read one. A reader never stops at a mistake; what could not be read is absent
//! afterwards, so that one run reports all that can be known, and none of it twice.

mod advice;
mod document;
mod fields;
mod id;
mod keys;
mod kind;
mod lists;
mod names;
mod place;
mod shape;
mod splice;
mod suggest;
mod units;

pub use linewright_diagnostics::{Problem, Problems, Report};

pub use document::{BYTES_MAX, document, has_key, is_bounded};
pub use fields::{Fields, TEXT_MAX};
pub use keys::Keys;
pub use kind::{
    KeyKind, coordinate, coordinates, flag, integer, lists, millis, nothing, number, one_of, part, positive, scalars,
    seconds, table, tables, text, texts, texts_by_name, whole, within, word, written,
};
pub use names::{NAME_MAX, NameTable, phrase, ros_name, tag, unique};
pub use place::{Located, LocatedName, Named, Scalar, TextRange, or};
pub use shape::{KeyPresence, Property, Shape, Usual, sentences};
pub use splice::{NoteId, Splice};
pub use suggest::{nearest, suggestion};
