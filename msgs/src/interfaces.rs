//! The types of all interfaces, as the build script wrote them from the `.msg`, `.srv` and `.action` files.

include!(concat!(env!("OUT_DIR"), "/interfaces.rs"));
