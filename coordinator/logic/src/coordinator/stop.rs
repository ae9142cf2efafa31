//! The emergency stop: why it was entered, and when. Kept until it is reset.

use linewright_line::{InputId, StationId, Tick};

use super::Coordinator;

/// Why the emergency stop was entered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EStopCause {
    /// This input of the console shows its button pressed.
    Pressed(InputId),
    /// The console's devices were received, and no longer are.
    ConsoleLost,
    /// By message.
    Commanded,
    /// The coordinator's journal cannot be written.
    JournalLost,
    /// A station reports one that this coordinator has not given.
    Station(StationId),
    /// It was in force, or not left yet, when the coordinator before this one ended.
    Restarted,
}

impl Coordinator {
    /// Latches the emergency stop. The first cause is kept, since others follow from it.
    pub(super) fn stop(&mut self, cause: EStopCause) {
        self.estop.get_or_insert((cause, self.now));
    }

    /// Why the emergency stop is latched, and since when in this life.
    pub fn stop_cause(&self) -> Option<(EStopCause, Tick)> {
        self.estop
    }
}
