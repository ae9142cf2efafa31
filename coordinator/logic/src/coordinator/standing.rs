//! Conditions that hold the mode or prevent another one, as values; the text of the mode has the same in sentences.

use linewright_line::StationId;
use linewright_line::net::ControlMode;

use super::Coordinator;
use crate::refusal::ModeRefusal;
use crate::texts::EStopButton;

/// What keeps the mode, or stands against another one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ModeStanding {
    /// Master stop was given: in auto, the line halts at home.
    pub is_stopping: bool,
    /// Emergency stop is in force and has not been reset.
    pub is_latched: bool,
    /// The console's emergency stop button, which has to be released before a reset, is pressed.
    pub is_pressed: bool,
    /// The console's devices are not operational, or were not received yet.
    pub without_console: bool,
    /// Resume is held.
    pub resumes: bool,
    /// Stations that were restarted, where that has ended a mode or stands against one.
    pub restarted: Vec<StationId>,
    /// Stations that are left out of the mode decision.
    pub left_out: Vec<StationId>,
    /// Texts of a second coordinator, of a journal that cannot be written, and of nodes that are not active; empty without any.
    pub obstacles: Vec<String>,
}

impl Coordinator {
    /// What keeps the mode.
    pub fn standing(&self) -> ModeStanding {
        let troubles = self.troubles_in(self.mode);
        // What has ended a mode may be over; that a station was restarted is so until somebody has looked at it.
        let ended = self.ended.iter().flat_map(|(_, reasons)| reasons);
        let is_restarted =
            |id: &StationId| troubles.iter().chain(ended.clone()).any(|reason| *reason == ModeRefusal::Restarted(*id));
        let is_obstacle = |reason: &&ModeRefusal| {
            use ModeRefusal as R;
            matches!(reason, R::OtherCoordinator(_) | R::JournalLost | R::CoordinatorInactive(_) | R::Inactive(..))
        };
        let obstacles = troubles.iter().filter(is_obstacle).cloned().chain(self.inactive_left_out());
        let is_latched = self.mode == ControlMode::EStop && self.estop.is_some();
        let stations = self.line.station_ids().zip(&self.stations);
        ModeStanding {
            is_stopping: self.stopping,
            is_latched,
            is_pressed: is_latched && self.estop_button() == EStopButton::Pressed,
            without_console: troubles
                .iter()
                .any(|reason| matches!(reason, ModeRefusal::ConsoleLost | ModeRefusal::ConsoleNeverHeard)),
            resumes: self.resumes(),
            restarted: self.line.station_ids().filter(is_restarted).collect(),
            left_out: stations.filter(|(_, station)| station.isolated).map(|(id, _)| id).collect(),
            obstacles: obstacles.map(|reason| reason.text(&self.line)).collect(),
        }
    }
}
