//! What stopped a motion, in words that name the signal and where it is.

use linewright_line::net::Block;
use linewright_line::{Line, OpId, OperationModule, Owner, StationId, duration_text};

use crate::event::StopCause;

impl StopCause {
    /// What the second barrier found, with the station, the switch and where it is wired.
    pub fn detail(self, line: &Line, own: StationId) -> String {
        match self {
            StopCause::Interlock { station, input: Some(input) } => format!(
                "interlock: {} is not clear: {} is off",
                line.station(station).name,
                line.input_text(Owner::Station(station), input)
            ),
            StopCause::Interlock { station, input: None } => {
                format!(
                    "interlock: the position of {} is not known: no valid image of its switches",
                    line.station(station).name
                )
            }
            StopCause::PositionLost { op, input } => format!(
                "position lost: {} is off where `{}` needs it on: look at the mechanism and the switch",
                line.input_text(Owner::Station(own), input),
                line.operation((own, op)).name
            ),
            _ => self.text().to_owned(),
        }
    }

    /// The cause of a stop of this operation, e.g. `took too long: LS_closed (clamp 1 io, node 21h, 6000h:01 bit 1) did
    /// not come within 1 s`.
    pub fn text_of(self, line: &Line, station: StationId, op: OpId, block: Block) -> String {
        let operation = line.operation((station, op));
        let signals = match (block, &operation.module) {
            (Block::Recovery, OperationModule::Reversible { recovery, .. }) => recovery,
            _ => &operation.normal,
        };
        let input = |input| line.input_text(Owner::Station(station), input);
        match (self, signals.fault) {
            (StopCause::Watchdog, _) => {
                let within = duration_text(operation.watchdog);
                format!("{}: {} did not come within {within}", self.text(), input(signals.complete))
            }
            (StopCause::Interlock { .. } | StopCause::PositionLost { .. }, _) => self.detail(line, station),
            (StopCause::SwitchStuck, _) => format!("{}: {}", self.text(), input(signals.complete)),
            (StopCause::Signal, Some(fault)) => format!("{}: {} is on", self.text(), input(fault)),
            _ => self.text().to_owned(),
        }
    }
}
