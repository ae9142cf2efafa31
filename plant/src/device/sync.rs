//! SYNC as a device receives it: its COB-ID (object 1005h), its period (1006h), and its absence.
//!
//! Outputs that wait for a SYNC would stay as they are when it stops, although the manager's heartbeat still comes. A
//! device with a SYNC period takes its absence for an error like that of the manager.

use std::time::Duration;

use linewright_canopen::codec::Abort;
use linewright_canopen::sdo::ObjectId;
use linewright_line::Tick;

use super::bytes::exactly;

/// The SYNC frame's COB-ID, which is fixed here.
const COB_ID: u32 = 0x80;
/// So many periods without a SYNC are an error: one may be lost, and the next be late.
const PERIODS: u32 = 3;

/// State of the watch of SYNC.
#[derive(Debug, Default)]
pub(super) struct SyncWatch {
    /// Object 1006h; zero is unknown, and nothing is watched.
    period: Duration,
    due: Option<Tick>,
}

impl SyncWatch {
    /// It has come, or the device has just begun to wait for it.
    pub(super) fn heard(&mut self, now: Tick) {
        self.due = (!self.period.is_zero()).then(|| now + self.period * PERIODS);
    }

    /// Ends the watch: nothing waits for SYNC.
    pub(super) fn rest(&mut self) {
        self.due = None;
    }

    /// When it is missed.
    pub(super) fn deadline(&self) -> Tick {
        self.due.unwrap_or(Tick::NEVER)
    }

    /// The bytes of an object; `None` for any other.
    pub(super) fn read(&self, object: ObjectId) -> Option<Result<Vec<u8>, Abort>> {
        match (object.index, object.sub) {
            (0x1005, 0) => Some(Ok(COB_ID.to_le_bytes().into())),
            (0x1006, 0) => Some(Ok((self.period.as_micros() as u32).to_le_bytes().into())),
            (0x1005 | 0x1006, _) => Some(Err(Abort::NO_SUBINDEX)),
            _ => None,
        }
    }

    /// Gives an object these bytes; `None` for what cannot be written here.
    pub(super) fn write(&mut self, object: ObjectId, data: &[u8]) -> Option<Result<(), Abort>> {
        match (object.index, object.sub) {
            (0x1005, 0) => Some(exactly(data).and_then(|bytes| match u32::from_le_bytes(bytes) {
                COB_ID => Ok(()),
                _ => Err(Abort::VALUE),
            })),
            (0x1006, 0) => Some(exactly(data).map(|bytes| {
                self.period = Duration::from_micros(u32::from_le_bytes(bytes).into());
                self.due = None;
            })),
            _ => None,
        }
    }
}
