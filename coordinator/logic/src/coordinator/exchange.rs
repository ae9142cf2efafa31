//! Input and output of the mode decision.

use std::time::Duration;

use linewright_lifecycle::LifecycleState;
use linewright_line::net::ControlMode;
use linewright_line::{OpId, StationId, Tick};

use super::cycle::CompletedCycle;
use crate::decision::ModeCommand;
use crate::refusal::RefusedCommand;

/// The part of a station's report that the coordinator uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StationView {
    /// Boot id of the station.
    pub boot_id: u64,
    /// The newest epoch it has received.
    pub mode_epoch: u64,
    /// Boot id of the coordinator whose order it took last; 0 for none.
    pub follows: u64,
    /// At its home place.
    pub at_home: bool,
    /// The round it is in, or at the end of which it stands at home. Away from home it has completed one less.
    pub round: i32,
    /// Nothing moves.
    pub stopped: bool,
    /// Some operation was stopped before its end.
    pub incomplete: bool,
    /// The first one that was.
    pub incomplete_op: Option<OpId>,
    /// The operation at whose place it stands or moves; the first where there are several. None where a task has ended: nothing
    /// leads on from there but another task.
    pub stands_in: Option<OpId>,
    /// Its selector stands at manual.
    pub selector_manual: bool,
    /// Its devices are received and operational.
    pub devices_valid: bool,
    /// The generation its counts belong to; 0 for none.
    pub generation: u64,
    /// An axis that stands still by its chart is not measured there.
    pub position_lost: bool,
    /// It acts on an emergency stop.
    pub estopped: bool,
    /// State of its node, if that is not active.
    pub inactive: Option<LifecycleState>,
}

impl StationView {
    /// Whether it acts on an epoch of this life: another coordinator may have come to the same number.
    pub(crate) fn acknowledges(&self, life: u64, epoch: u64) -> bool {
        self.mode_epoch >= epoch && (self.follows == life || self.follows == 0)
    }
}

/// An input of the mode decision.
#[derive(Clone, Copy, Debug)]
pub enum ModeInput {
    /// An operator's command, by message.
    Command(ModeCommand),
    /// Manual for one station while the others are in auto, or auto again, by message.
    Single(StationId, bool),
    /// The console's input image, and whether its devices vouch for it.
    Console {
        /// Bit `i` is input `i` of the console.
        bits: u128,
        /// False when a device is lost or has not yet sent.
        valid: bool,
    },
    /// Hand-mode buttons held, by message, a bit each; replaces those held before. Must be refreshed.
    Buttons(u32),
    /// The same, from an unknown time: none of them counts, and those held are not released by it.
    LateButtons(u32),
    /// Two consoles send hand-mode buttons; they count for neither.
    TwoConsoles,
    /// Resume at a console, by message: the console's identity, and whether it is held. Must be refreshed.
    Resume(u64, bool),
    /// The same, from an unknown time.
    LateResume(u64, bool),
    /// A newer report of a station.
    Station(StationId, StationView),
    /// A station reports an emergency stop, in a state of which nothing else can be used.
    StationStopped(StationId),
    /// Another coordinator gives orders to this line: its boot id, and until when that counts without repetition.
    /// Nothing moves meanwhile.
    Rival(u64, Tick),
    /// Whether the journal can be written. While it cannot, the emergency stop is in force.
    Journal(bool),
    /// State of the coordinator's own node.
    Lifecycle(LifecycleState),
}

/// The order for every station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModeGrant {
    /// Grows with every change of mode.
    pub epoch: u64,
    pub mode: ControlMode,
    /// Every station has acknowledged the epoch.
    pub enabled: bool,
    /// Master stop: halt at the home place at the end of this round, the latest that any station has begun. All are at
    /// home together then, as they were at the beginning; a station that halted at home at once could leave another
    /// waiting for it, away from home, for ever.
    pub master_stop: Option<i32>,
    /// Every station's panel counts as switched to manual.
    pub manual_all: bool,
    /// Hand-mode buttons held.
    pub buttons: u32,
    /// Resume is held at a console.
    pub resume: bool,
    /// Validity of the order after its arrival.
    pub lease: Duration,
}

/// Output of a step.
#[derive(Clone, Debug, Default)]
pub struct ModeOutbox {
    /// Send the order and the state now.
    pub changed: bool,
    /// The console's output image: the lamps.
    pub lamps: u128,
    /// Modes entered, in order. The caller drains it.
    pub modes: Vec<ControlMode>,
    /// Commands refused, in order. The caller drains it.
    pub refusals: Vec<RefusedCommand>,
    /// Of the commands since the last step the last one was obeyed: no refusal stands any more.
    pub obeyed: bool,
    /// Cycles that the line has completed, in order. The caller drains it.
    pub cycles: Vec<CompletedCycle>,
}
