//! The texts of a bus's manager for operators and logs, one file for each kind of text. `tests/texts.rs` keeps a list of
//! them.
//!
//! Beside them: what a device waits for at this moment (`peer/explain.rs`, `profile/drive/explain.rs`), whose sentences
//! are put together from the device's state, and the tables of codes, whose words are those of the standards.

mod boot;
mod dbc_device;
mod event;
mod fault;
mod request;
mod rival;

pub use dbc_device::DbcDeviceText;
pub use request::StartReply;
pub(super) use request::unknown_node;
pub(super) use rival::{STILL_LISTENING, not_asked, other_manager};
