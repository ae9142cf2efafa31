//! Descriptions written by people: text → tables of values with their places, and what is wrong with them.
//!
//! What every reader of such a file needs: problems that point into the text and give advice, tables read key by key
//! without losing a problem, names that are looked up, and "did you mean". It knows TOML and no key: what a description
//! means is known to the crates that read one. A reader never stops at a mistake; what could not be read is absent
//! afterwards, so that one run reports all that can be known, and none of it twice.

mod document;
mod fields;
mod id;
mod names;
mod place;
mod problem;
mod suggest;

pub use document::{BYTES_MAX, document, is_bounded};
pub use fields::{Fields, Scalar};
pub use names::{NAME_MAX, Table, phrase, ros_name, tag, unique};
pub use place::{At, Name, Where, or};
pub use problem::{Problem, Problems, Report};
pub use suggest::{nearest, suggestion};
