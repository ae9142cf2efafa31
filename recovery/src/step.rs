//! The steps of a plan.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{ButtonId, InputId, OpId, Parameter, RestId, StationId};
use linewright_station_logic::RejoinAt;

use crate::situation::StandingAlarm;

/// The buttons of a station's panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PanelButton {
    Advance,
    Return,
}

/// What has to be done, or to become so, before the next step: no command does it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Need {
    /// A station is to be heard again.
    Heard(StationId),
    /// The I/O devices of a station are to be operational.
    Devices(StationId),
    /// The devices of the console are to be operational.
    Console,
    /// The emergency stop button is to be released.
    Button,
    /// A motion under way is to end.
    Standstill(StationId),
    /// A fault signal is to go off: its cause is to be removed.
    FaultSignal(StationId, InputId),
    /// An axis is to be brought back onto this switch by hand, its drive off.
    Axis {
        station: StationId,
        /// The operation at whose place it is missed.
        op: OpId,
        input: InputId,
        /// The conflicts of the line in which another station may be in its way, there or on the way there.
        conflicts: Vec<usize>,
    },
    /// A selector is to be turned to auto at the station's panel, to which this input is wired: no message does it.
    Selector(StationId, InputId),
    /// A station that is in emergency stop by itself is to be reset.
    Reset(StationId),
    /// A station is to be brought to this rest, as its alarm says.
    Bring(StationId, RestId),
    /// The line is to halt, as master stop has ordered.
    Halt,
    /// Every station is to acknowledge the mode.
    Acknowledged,
    /// A failed activity of the cell is to come so far that a person can decide: its stations come to rest first.
    Settled {
        /// The activity, and what it waits for, in the coordinator's words.
        activity: String,
        /// Stations that are left out and not at rest yet.
        stations: Vec<StationId>,
    },
    /// An alarm of the cell is to be answered, when what it asks for is done.
    Answer(StandingAlarm),
    /// In the coordinator's words.
    Other(String),
}

/// One action of an operator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecoveryAction {
    First(Need),
    Command(ModeCommand),
    /// Manual for a station by itself, while the others stay in auto.
    ManualAlone(StationId),
    /// Auto for a station that is in manual by itself.
    AutoAgain(StationId),
    /// Held until the motion has arrived, then released.
    Press(StationId, PanelButton),
    /// Held at the console until what it leads on has arrived at every station, then released.
    Resume,
    /// A hand-mode button of the console, held until this station stands at this rest, then released.
    Hold {
        button: ButtonId,
        station: StationId,
        rest: RestId,
    },
    /// A station's selector: true is manual.
    Selector(StationId, bool),
    /// A person looks and confirms where the station stands.
    Rejoin {
        station: StationId,
        /// The place that the plan assumes.
        at: RejoinChoice,
        /// Others that its switches fit as well: which it is, the person sees.
        or: Vec<RejoinChoice>,
    },
}

/// A place that a person may confirm, and how the station stands there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RejoinChoice {
    pub at: RejoinAt,
    /// The places that are marked when it is confirmed.
    pub places: Vec<StationPlace>,
    /// The inputs that are on, the first of the description in bit 0.
    pub on: u128,
    /// The numbers that are confirmed with it.
    pub numbers: Vec<ConfirmedNumber>,
    /// The activity of which the station had an order of this task, where the coordinator has one, e.g. `` `load M1` of part 7 ``.
    pub activity: Option<String>,
}

/// A number that is confirmed with a place within a task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfirmedNumber {
    pub parameter: Parameter,
    /// The number of the order, where the coordinator has one. Else the person gives it.
    pub known: Option<i32>,
}

/// A motion that a step makes, with the time it takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlannedMotion {
    pub station: StationId,
    /// The operating place: the operation, and whether it is done or undone.
    pub place: StationPlace,
    /// Of an index on a drive, the number of the place that it goes to.
    pub to_place: Option<u16>,
    /// The drive of the index is homed by it, at a rest; the operation is not begun.
    pub homes: bool,
    /// Of a homing its longest, the watchdog of the index.
    pub time: Duration,
}

/// A station as it stands after a step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StationAfter {
    pub station: StationId,
    pub places: Vec<StationPlace>,
    pub at_home: bool,
    /// Nothing of it is incomplete, it is on no recovery path, and its position is not lost.
    pub is_in_order: bool,
}

/// A step of a plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecoveryStep {
    pub action: RecoveryAction,
    /// What moves by it; empty where nothing does.
    pub moves: Vec<PlannedMotion>,
    /// Of a press: the switch that ends it is on already, so it may count only when the watchdog has reported that.
    pub is_doubtful: bool,
    /// The mode after it.
    pub mode: ControlMode,
    /// The station after it, where it is about one.
    pub after: Option<StationAfter>,
}

impl RecoveryStep {
    /// Whether a fault signal is to go off: it may do so by itself, as that of a drive does which stands.
    pub fn is_fault_signal(&self) -> bool {
        matches!(self.action, RecoveryAction::First(Need::FaultSignal(..)))
    }
}

impl RecoveryAction {
    /// The places of which a person confirms one, the assumed one first; empty for another action.
    pub fn choices(&self) -> impl Iterator<Item = &RejoinChoice> + Clone {
        let (at, or) = match self {
            RecoveryAction::Rejoin { at, or, .. } => (Some(at), &or[..]),
            _ => (None, &[][..]),
        };
        at.into_iter().chain(or)
    }

    /// The station that it is about.
    pub fn station(&self) -> Option<StationId> {
        match self {
            RecoveryAction::First(need) => need.station(),
            RecoveryAction::Command(_) | RecoveryAction::Resume => None,
            RecoveryAction::Press(station, _)
            | RecoveryAction::Selector(station, _)
            | RecoveryAction::ManualAlone(station)
            | RecoveryAction::AutoAgain(station) => Some(*station),
            RecoveryAction::Rejoin { station, .. } | RecoveryAction::Hold { station, .. } => Some(*station),
        }
    }
}

impl Need {
    /// The station that it is about.
    pub fn station(&self) -> Option<StationId> {
        match self {
            Need::Heard(station) | Need::Devices(station) | Need::Standstill(station) | Need::Reset(station) => {
                Some(*station)
            }
            Need::FaultSignal(station, _)
            | Need::Selector(station, _)
            | Need::Bring(station, _)
            | Need::Axis { station, .. } => Some(*station),
            Need::Console
            | Need::Button
            | Need::Halt
            | Need::Acknowledged
            | Need::Settled { .. }
            | Need::Answer(_)
            | Need::Other(_) => None,
        }
    }
}
