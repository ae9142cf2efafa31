//! Texts about a DBC device.

use std::fmt;
use std::time::Duration;

use linewright_line::FrameId;

use crate::manager::fault::FrameFault;

/// State of a DBC device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DbcDeviceText<'a> {
    /// It sends no message that the description has.
    NotHeard,
    Live,
    /// A message does not come as it should; `since` when, none if it never came.
    Missing {
        message: &'a str,
        id: FrameId,
        since: Option<Duration>,
        why: FrameFault,
    },
}

impl fmt::Display for DbcDeviceText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DbcDeviceText::NotHeard => f.write_str("sent to, and not heard: its state is unknown"),
            DbcDeviceText::Live => f.write_str("live: all its messages come in time"),
            DbcDeviceText::Missing { message, id, since: Some(since), why } => {
                write!(f, "nothing of message {message} ({id}) for {} ms: {why}", since.as_millis())
            }
            DbcDeviceText::Missing { message, id, since: None, why } => {
                write!(f, "nothing of message {message} ({id}) yet: {why}")
            }
        }
    }
}
