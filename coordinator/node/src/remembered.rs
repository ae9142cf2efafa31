//! Record that the coordinator of a line keeps over its own restarts: a line of text in its journal.

use std::path::Path;

use linewright_coordinator_shell::CoordinatorRecord;

/// The record.
pub fn record_of(remembered: CoordinatorRecord) -> Vec<u8> {
    format!("epoch {} {}", remembered.epoch, if remembered.estop { "estop" } else { "-" }).into_bytes()
}

/// Record in a journal. A journal with anything else may have held an emergency stop: that is in force then.
pub fn remembered(record: &[u8], path: &Path) -> CoordinatorRecord {
    read(record).unwrap_or_else(|| {
        let path = path.display();
        tracing::warn!(
            "the journal {path} does not hold an epoch: emergency stop, as it may have held one; give reset"
        );
        CoordinatorRecord { epoch: 0, estop: true }
    })
}

fn read(record: &[u8]) -> Option<CoordinatorRecord> {
    let words: Vec<&str> = std::str::from_utf8(record).ok()?.split(' ').collect();
    match words[..] {
        ["epoch", number, latch @ ("estop" | "-")] => {
            Some(CoordinatorRecord { epoch: number.parse().ok()?, estop: latch == "estop" })
        }
        _ => None,
    }
}
