//! The ROS 2 interfaces of a line.
//!
//! Each stands in one file: `.msg`, `.srv` or `.action`, from which a ROS 2 workspace generates C++ and Python, and the build
//! script (`build/`) the Rust types of this crate. Those of other packages that a line uses stand in `standard/`. Comments in
//! the files are the documentation here. `tests/golden.rs` compares the bytes on the wire with checked-in ones.
//!
//! This crate does not use DDS: it holds data, its structure and its [bounds](Invalid). A message that decodes may
//! still be invalid; [`RosMessage::validate`] is called on everything that arrives.

mod bounded;
mod interfaces;
mod invalid;
mod meaning;
mod message;
mod values;

pub use bounded::Bounded;
pub use interfaces::*;
pub use invalid::{ITEMS_MAX, Invalid, TEXT_BYTES_MAX, cut, fitting};
pub use message::{Interface, RosAction, RosField, RosMessage, RosService};
pub use values::{Byte, LISTED_MAX};

/// Package that the messages of this crate belong to on the ROS 2 side.
pub const PACKAGE: &str = "linewright_msgs";
