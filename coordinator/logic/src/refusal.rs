//! Refusals: a command that is not obeyed is answered with every reason, never kept for later.

use std::time::Duration;

use linewright_lifecycle::LifecycleState;
use linewright_line::net::ControlMode;
use linewright_line::{Line, OpId, StationId};

use crate::decision::ModeCommand;

/// Reason why the counts of a station cannot be compared with those of the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ApartCause {
    /// It has no generation: its journal is lost, or there was none.
    NoMemory,
    /// Its generation is another one.
    OtherStart,
}

impl ApartCause {
    /// All causes, in the order of their texts.
    pub const ALL: [ApartCause; 2] = [ApartCause::NoMemory, ApartCause::OtherStart];
}

/// Reason why a command is not obeyed now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModeRefusal {
    /// The mode has no use for it; these commands it would take, and these lead to the commanded mode.
    WrongMode {
        takes: Vec<ModeCommand>,
        way: Vec<ModeCommand>,
    },
    /// There is no emergency stop.
    NothingToReset,
    /// The line is already in that mode.
    Already,
    /// It is in auto, and stops at home.
    Stopping,
    /// The emergency stop is latched.
    EStop,
    /// The emergency stop button is still pressed.
    EStopPressed,
    /// The console's devices are not received.
    ConsoleLost,
    /// The coordinator's journal cannot be written.
    JournalLost,
    /// Another coordinator gives orders to this line; its boot id.
    OtherCoordinator(u64),
    /// The console's devices have not been received since the coordinator came up.
    ConsoleNeverHeard,
    NotHeard(StationId),
    /// The node of a station is not active.
    Inactive(StationId, LifecycleState),
    /// The coordinator's own node is not.
    CoordinatorInactive(LifecycleState),
    DevicesLost(StationId),
    /// The devices of a station have not been operational since it, or the coordinator, was started: none is lost.
    DevicesAwaited(StationId),
    /// A station has an operation that was stopped before its end: the first of them, or none half-way along a recovery path.
    Incomplete(StationId, Option<OpId>),
    /// A mechanism of a station is not measured where its chart has it.
    PositionLost(StationId),
    /// A station's counts cannot be compared with the others'.
    NoCommonStart(StationId, ApartCause),
    /// The same, for manual at home: no generation can be founded now, and what is moved without one is not counted.
    NotFounded(StationId, ApartCause),
    /// A station was restarted and has not been looked at since.
    Restarted(StationId),
    /// A station's selector stands at manual.
    SelectorManual(StationId),
    /// A station is still moving.
    Moving(StationId),
    /// A station stands, and has not acknowledged yet that it is to.
    Unaware(StationId),
    NotAtHome(StationId),
    /// A task-driven station stands between two rests, at no order.
    BetweenRests(StationId),
    /// Manual for one station is given beside auto only.
    NotInAuto(StationId),
    /// A station follows the mode of the line already.
    NotSingle(StationId),
    /// A station of a line without a cell: counts and arrows join it to the others.
    NoSingleManual(StationId),
    /// A station takes part in auto, or has a task order.
    InService(StationId),
    /// Stations of a failed activity have still to come to rest.
    Securing(StationId),
    /// The cell of a station decides nothing now.
    Unattended(StationId),
    /// A station stands between two rests in a task of no failed activity: nothing keeps the others apart from it.
    OutsideTask(StationId),
    /// A station has an index, whose drive would be homed in manual at rest.
    Turns(StationId),
    /// A station in manual by itself by its selector, which is at manual no more, or unknown since a restart.
    SelectorUnclear(StationId),
    /// A station has not acknowledged yet that one of them is in manual by itself.
    ManualUnaware(StationId),
    /// The cell of a station has not taken yet that it is in manual by itself.
    CellUnaware(StationId),
    /// A station is in an emergency stop of its own.
    StoppedByCell(StationId),
    /// A station is at home, but a round behind another.
    Behind(StationId),
    /// Resume takes effect in manual only.
    NotManual,
    /// The line is in manual by selectors: the panels are the stations' own.
    ManualBySelectors,
    /// Two consoles send resume.
    TwoConsoles,
    /// Resume was held while it could not take effect, and not seen released since.
    Unreleased,
    /// The command was obeyed, and its mode could not be reached within this time for the other reasons.
    GivenUp(Duration),
}

/// A command of an operator at a console.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OperatorCommand {
    Mode(ModeCommand),
    /// Manual for one station while the others are in auto; false: auto again.
    Single(StationId, bool),
    /// Hand-mode buttons, held.
    Buttons,
    /// Resume, held.
    Resume,
}

impl OperatorCommand {
    /// The word an operator types.
    pub const fn name(self) -> &'static str {
        match self {
            OperatorCommand::Mode(command) => command.name(),
            OperatorCommand::Single(_, true) => ModeCommand::Manual.name(),
            OperatorCommand::Single(_, false) => ModeCommand::Auto.name(),
            OperatorCommand::Buttons => "buttons",
            OperatorCommand::Resume => "resume",
        }
    }

    /// The command as it is sent on the topic: its name, and the station where it is for one alone.
    pub fn words(self, line: &Line) -> String {
        match self {
            OperatorCommand::Single(station, _) => format!("{} {}", self.name(), line.station(station).name),
            OperatorCommand::Mode(_) | OperatorCommand::Buttons | OperatorCommand::Resume => self.name().to_owned(),
        }
    }
}

/// A command that was not obeyed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RefusedCommand {
    pub command: OperatorCommand,
    /// The mode that refused it.
    pub mode: ControlMode,
    /// All reasons, at least one.
    pub reasons: Vec<ModeRefusal>,
}
