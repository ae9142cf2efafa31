//! What the coordinator of a line keeps over its own restarts: a line of text in its journal.

use std::path::PathBuf;

use crate::node::NodeError;

/// What the coordinator's journal holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Remembered {
    /// The highest epoch used.
    pub epoch: u64,
    /// The emergency stop was on.
    pub estop: bool,
}

/// Reads what a journal holds.
pub fn remembered(record: &[u8], path: PathBuf) -> Result<Remembered, NodeError> {
    let words: Option<Vec<&str>> = std::str::from_utf8(record).ok().map(|text| text.split(' ').collect());
    match words.as_deref() {
        Some(["epoch", number, latch @ ("estop" | "-")]) => {
            let epoch = number.parse().map_err(|_| NodeError::Record { path })?;
            Ok(Remembered { epoch, estop: *latch == "estop" })
        }
        _ => Err(NodeError::Record { path }),
    }
}
