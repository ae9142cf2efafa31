//! Arrivals at the coordinator, and their effects.

use linewright_coordinator_logic::{CompletedCycle, ModeCommand, OutputImage, RefusedCommand, StationView};
use linewright_line::net::ControlMode;
use linewright_line::{OpId, StationId};
use linewright_station_logic::StationReport;

/// Something that has arrived.
#[derive(Clone, Copy, Debug)]
pub enum CoordinatorArrival {
    /// An operator's command.
    Command(ModeCommand),
    /// Manual for one station of a cell while the others are in auto; false: auto again.
    Single(StationId, bool),
    /// Hand-mode buttons at a console.
    Buttons {
        /// The console's identity, another one with each start of it.
        console: u64,
        /// Those held, a bit each.
        held: u32,
    },
    /// Resume at a console.
    Resume {
        /// The console's identity, another one with each start of it.
        console: u64,
        held: bool,
    },
    /// An order that was given on this line, by whichever coordinator.
    Order {
        /// The coordinator's life.
        boot_id: u64,
        /// Its number in that life.
        sequence: u64,
    },
    /// A station's state.
    State {
        /// Sender.
        station: StationId,
        /// Its number in that station's life.
        sequence: u64,
        /// The part of it that is used here; see [`heard`].
        heard: StationView,
    },
    /// The output image of a station behind the gateway.
    Outputs {
        /// Sender.
        station: StationId,
        /// Its number as a message, in that station's life.
        sequence: u64,
        image: OutputImage,
    },
    /// The console's input image.
    Console {
        /// Bit `i` is input `i` of the console.
        bits: u128,
        /// The bus's manager vouches for the bits.
        valid: bool,
    },
    /// The input image of the devices of a station behind the gateway.
    Devices {
        /// Station of the devices.
        station: StationId,
        /// Bit `i` is input `i` of the station.
        bits: u128,
        /// The bus's manager vouches for the bits.
        valid: bool,
        /// Number of losses of devices.
        losses: u64,
    },
}

/// Record that the coordinator keeps over its own restarts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CoordinatorRecord {
    /// The highest epoch used.
    pub epoch: u64,
    /// The emergency stop was on.
    pub estop: bool,
}

/// Effects are performed in the order in which they are given. If [`CoordinatorEffect::Remember`] fails, those after it
/// are not performed, and [`crate::CoordinatorShell::remembered`] is called with the failure.
#[derive(Clone, Debug, PartialEq)]
pub enum CoordinatorEffect {
    /// A command is refused.
    Refused(RefusedCommand),
    /// A command is obeyed: what was refused before is over.
    Obeyed,
    Entered(ControlMode),
    /// Write this down, and pass the result to [`crate::CoordinatorShell::remembered`].
    Remember(CoordinatorRecord),
    /// Put these outputs of the console on the bus: its lamps.
    Lamps(u128),
    /// Put these outputs of a station behind the gateway on the bus.
    Energise(StationId, u128),
    /// Send a station behind the gateway its inputs, as message number `sequence`.
    Inputs {
        /// Receiver.
        station: StationId,
        /// Its number in this life of the coordinator.
        sequence: u64,
        image: InputsImage,
    },
    /// Send [`crate::CoordinatorShell::order`] to every station, as message number `sequence`.
    Order {
        /// Its number in this life of the coordinator.
        sequence: u64,
    },
    /// Send the state of the line, as message number `sequence`.
    Tell {
        /// Its number in this life of the coordinator.
        sequence: u64,
    },
    /// The line has completed a cycle. Given once, and before a record of the same effects.
    Completed(CompletedCycle),
}

/// The part of a station's report that the coordinator uses.
pub fn heard(report: &StationReport) -> StationView {
    StationView {
        boot_id: report.boot_id,
        mode_epoch: report.mode_epoch,
        // Not in the report: added by the reader of a message.
        follows: 0,
        at_home: report.at_home,
        round: report.round,
        stopped: report.stopped,
        // Between two motions of its recovery path nothing of it is incomplete, and in auto nothing leads on there.
        incomplete: !report.incomplete.is_empty() || report.recovering_home,
        incomplete_op: report.incomplete.first().map(|(op, _)| *op),
        stands_in: stands_in(report),
        selector_manual: report.selector_manual,
        devices_valid: report.devices_valid,
        generation: report.generation,
        position_lost: report.position_lost.is_some(),
        estopped: report.mode == Some(ControlMode::EStop),
        // Not in the report either, but in the message around it.
        inactive: None,
    }
}

/// Number of the place of a completed operation, in reports.
const COMPLETED: u8 = 3;

/// See [`StationView::stands_in`].
fn stands_in(report: &StationReport) -> Option<OpId> {
    let marked = (0..).zip(&report.places).find(|(_, place)| **place != 0);
    marked.filter(|(_, place)| !(report.at_home && **place == COMPLETED)).map(|(op, _)| OpId(op))
}

/// A station's inputs as they are sent to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InputsImage {
    /// Bit `i` is input `i` of the station.
    pub bits: u128,
    /// The bus's manager vouches for the bits.
    pub valid: bool,
    /// Changes with every loss of devices, and with the coordinator's life.
    pub lives: u64,
    /// The output image that was in force meanwhile: life of the station that sent it, and its number.
    pub under: Option<(u64, u64)>,
}
