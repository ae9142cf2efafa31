//! The few ROS 2 standard messages a line uses, under names that do not shadow Rust's own.
//!
//! Their `.msg` files belong to ROS 2; `tests/msg_files.rs` has their text.

use crate::macros::message;

message! {
    /// `builtin_interfaces/Time`: seconds and nanoseconds since the Unix epoch.
    "builtin_interfaces" / Time
    fields {
        /// Whole seconds.
        sec: i32,
        /// Nanoseconds below a second.
        nanosec: u32,
    }
    ros name "Time", meaning |_| Ok(())
}

message! {
    /// `std_msgs/Header`.
    "std_msgs" / Header
    fields {
        /// When the content was true.
        stamp: Time,
        /// Coordinate frame; unused here, the name of the line.
        frame_id: String,
    }
    ros name "Header", meaning |_| Ok(())
}

message! {
    /// `std_msgs/String`.
    "std_msgs" / Text
    fields {
        /// The text.
        data: String,
    }
    ros name "String", meaning |_| Ok(())
}

message! {
    /// `std_msgs/Bool`.
    "std_msgs" / Flag
    fields {
        /// The flag.
        data: bool,
    }
    ros name "Bool", meaning |_| Ok(())
}

impl From<&str> for Text {
    fn from(data: &str) -> Self {
        Self { data: data.to_owned() }
    }
}
