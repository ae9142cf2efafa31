//! Messages between the processes of a line, whole and numbered as over ROS 2.

use std::rc::Rc;

use linewright_coordinator_logic::{ModeCommand, OutputImage};
use linewright_line::StationId;
use linewright_station_logic::{ModeOrder, PanelCommand, RejoinAt, StationReport};
use linewright_station_shell::InputsMessage;

/// The only console.
pub(crate) const CONSOLE: u64 = 1;

/// A message.
#[derive(Clone, Debug)]
pub(crate) enum Message {
    Order { sequence: u64, order: ModeOrder },
    State { station: StationId, sequence: u64, follows: u64, report: Rc<StationReport> },
    Inputs(InputsMessage),
    Outputs { station: StationId, sequence: u64, image: OutputImage },
    Panel(PanelCommand),
    Rejoin(RejoinAt),
    Command(ModeCommand),
    Buttons(u32),
    Resume(bool),
}

/// Topics: of each the network keeps the newest message for a reader that is cut off.
pub(crate) const TOPICS: usize = 4;

impl Message {
    /// The topic of a whole state that is repeated.
    pub(crate) fn topic(&self) -> Option<usize> {
        match self {
            Message::Order { .. } => Some(0),
            Message::State { .. } => Some(1),
            Message::Inputs(_) => Some(2),
            Message::Outputs { .. } => Some(3),
            Message::Panel(_) | Message::Rejoin(_) | Message::Command(_) | Message::Buttons(_) | Message::Resume(_) => {
                None
            }
        }
    }

    /// Messages that may overtake each other: what is read by its number. Orders keep their order, as an emergency stop that
    /// arrives after its end costs another reset.
    pub(crate) fn may_overtake(&self) -> bool {
        matches!(self, Message::State { .. } | Message::Inputs(_) | Message::Outputs { .. })
    }
}
