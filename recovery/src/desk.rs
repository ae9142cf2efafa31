//! The mode decision as it is played: the real coordinator beside the stations, its orders and their reports exchanged at once.

use linewright_coordinator_logic::{Coordinator, ModeCommand, ModeInput, ModeOutbox, StationView};
use linewright_coordinator_shell::{heard, orders};
use linewright_line::net::ControlMode;
use linewright_line::{InputId, Line, Owner, StationId};
use linewright_station_logic::{ModeOrder, StationInput};

use crate::situation::LineSituation;
use crate::units::{NOW, PlayedLine, PlayedStations, whole_image};

const LIFE: u64 = 1;
/// Rounds of orders and reports: more would be a loop.
const ROUNDS_MAX: usize = 64;
/// Most commands in a row: reset, manual, auto.
const COMMANDS_MAX: usize = 3;
/// Commands of a way, the first of equals first.
const COMMANDS: [ModeCommand; 4] = [ModeCommand::Auto, ModeCommand::Start, ModeCommand::Reset, ModeCommand::Manual];
/// The same from hand mode, out of which manual is not given.
const FROM_HAND: [ModeCommand; 3] = [ModeCommand::Auto, ModeCommand::Stop, ModeCommand::Manual];
/// The same to hand mode, which is given from stand-by.
const TO_HAND: [ModeCommand; 3] = [ModeCommand::Hand, ModeCommand::Start, ModeCommand::Stop];

/// The mode decision with all stations.
#[derive(Clone)]
pub(crate) struct Desk {
    coordinator: Coordinator,
    pub units: PlayedStations,
    sent: Vec<Option<ModeOrder>>,
    refused: bool,
}

impl Desk {
    /// The coordinator in the mode of the situation.
    pub fn new(floor: &PlayedLine<'_>, situation: &LineSituation, units: PlayedStations) -> Self {
        let last = units.iter().map(|unit| unit.report.mode_epoch).max().unwrap_or(0);
        let coordinator = Coordinator::new(floor.line.clone(), LIFE, last);
        let coordinator = if situation.mode == ControlMode::EStop { coordinator.with_estop() } else { coordinator };
        let sent = vec![None; units.len()];
        let mut desk = Desk { coordinator, units, sent, refused: false };
        desk.hear_console(floor.line);
        if situation.mode == ControlMode::StandBy && !situation.restarted.is_empty() {
            // A station that has ended auto so may be left out since.
            desk.lead_to_auto(situation);
            desk.settle(floor);
        }
        desk.coordinator.isolate(|id, _| situation.left_out.contains(&id));
        desk.settle(floor);
        let way: &[ModeCommand] = match situation.mode {
            ControlMode::Home => &[],
            ControlMode::StandBy => &[ModeCommand::Start],
            ControlMode::Manual => &[ModeCommand::Start, ModeCommand::Manual],
            ControlMode::Auto => &[ModeCommand::Start, ModeCommand::Auto],
            ControlMode::Hand => &[ModeCommand::Start, ModeCommand::Hand],
            ControlMode::EStop if situation.is_reset => &[ModeCommand::Reset],
            ControlMode::EStop => &[],
        };
        for &command in way {
            let is_past = command == ModeCommand::Start && desk.mode() != ControlMode::Home;
            if (!is_past && desk.mode() != situation.mode) || command == ModeCommand::Reset {
                desk.command(floor, command);
            }
        }
        desk
    }

    fn hear_console(&mut self, line: &Line) {
        if line.devices.iter().any(|device| device.owner == Owner::Console) {
            let bits = line.console.estop.filter(|contact| !contact.pressed).map_or(0, |contact| contact.input.bit());
            self.coordinator.handle(NOW, ModeInput::Console { bits, valid: true });
        }
    }

    /// The line in auto, before these stations were restarted. Their reports, of another life, end it.
    fn lead_to_auto(&mut self, situation: &LineSituation) {
        let mut out = ModeOutbox::default();
        for command in [None, Some(ModeCommand::Start), Some(ModeCommand::Auto)] {
            for (at, unit) in self.units.iter().enumerate() {
                let id = StationId::at(at);
                let is_another = situation.restarted.contains(&id);
                let before = StationView {
                    boot_id: if is_another { unit.report.boot_id ^ 1 << 63 } else { unit.report.boot_id },
                    mode_epoch: self.coordinator.epoch(),
                    at_home: true,
                    stopped: true,
                    devices_valid: true,
                    generation: 1,
                    ..StationView::default()
                };
                self.coordinator.handle(NOW, ModeInput::Station(id, before));
            }
            if let Some(command) = command {
                self.coordinator.handle(NOW, ModeInput::Command(command));
            }
            self.coordinator.step(NOW, &mut out);
        }
    }

    pub fn mode(&self) -> ControlMode {
        self.coordinator.mode()
    }

    /// Auto, acknowledged by every station.
    fn is_in_auto(&self) -> bool {
        self.mode() == ControlMode::Auto && self.coordinator.order().enabled
    }

    pub fn is_in(&self, mode: ControlMode) -> bool {
        if mode == ControlMode::Auto { self.is_in_auto() } else { self.mode() == mode }
    }

    /// Orders and reports pass until nothing is new.
    pub fn settle(&mut self, floor: &PlayedLine<'_>) {
        let mut out = ModeOutbox::default();
        for _ in 0..ROUNDS_MAX {
            let units = &self.units;
            let is_held = |id: StationId| {
                let order = units[id.index()].report.order.as_ref();
                order.is_some_and(|order| orders::heard(order).is_held)
            };
            self.coordinator.hold(is_held);
            for (at, unit) in self.units.iter().enumerate() {
                self.coordinator.handle(NOW, ModeInput::Station(StationId::at(at), heard(&unit.report)));
            }
            self.coordinator.step(NOW, &mut out);
            self.refused |= !out.refusals.is_empty();
            out.refusals.clear();
            if !self.send_orders(floor) && !out.changed {
                return;
            }
        }
    }

    /// Whether any order was new.
    fn send_orders(&mut self, floor: &PlayedLine<'_>) -> bool {
        let grant = self.coordinator.order();
        let mut any = false;
        for at in 0..self.units.len() {
            let order = ModeOrder {
                boot_id: LIFE,
                epoch: grant.epoch,
                mode: grant.mode,
                enabled: grant.enabled,
                master_stop: grant.master_stop,
                manual_all: grant.manual_all,
                buttons: 0,
                resume: false,
                lease: ModeOrder::FOR_GOOD,
                station_life: 0,
                found: self.coordinator.founding(),
                single: false,
            };
            if self.sent[at] != Some(order) {
                self.sent[at] = Some(order);
                floor.order(&mut self.units, at, order);
                any = true;
            }
        }
        any
    }

    /// Whether a command is obeyed.
    pub fn command(&mut self, floor: &PlayedLine<'_>, command: ModeCommand) -> bool {
        self.refused = false;
        self.coordinator.handle(NOW, ModeInput::Command(command));
        self.settle(floor);
        !self.refused
    }

    pub fn turn_selector(&mut self, floor: &PlayedLine<'_>, station: StationId, manual: bool) {
        if let Some(wired) = self.wired_at_manual(floor.line, station).filter(|_| !manual) {
            let bits = self.units[station.index()].report.measured & !wired.bit();
            floor.give(&mut self.units, station.index(), whole_image(bits));
        }
        let turned = linewright_station_logic::PanelCommand::Selector(manual);
        floor.give(&mut self.units, station.index(), StationInput::Panel(turned));
        self.settle(floor);
    }

    /// The input of a station's selector that stands at manual.
    pub fn wired_at_manual(&self, line: &Line, station: StationId) -> Option<InputId> {
        let measured = self.units[station.index()].report.measured;
        line.station(station).panel.manual.filter(|input| measured & input.bit() != 0)
    }

    /// The fewest commands that lead to a mode, with the desk after each.
    pub fn way_to(&self, floor: &PlayedLine<'_>, mode: ControlMode) -> Option<Vec<(ModeCommand, Desk)>> {
        if self.is_in(mode) {
            return Some(Vec::new());
        }
        let commands: &[ModeCommand] = match (self.mode(), mode) {
            (_, ControlMode::Hand) => &TO_HAND,
            (ControlMode::Hand, _) => &FROM_HAND,
            _ => &COMMANDS,
        };
        let mut ways: Vec<Vec<(ModeCommand, Desk)>> = vec![Vec::new()];
        for _ in 0..COMMANDS_MAX {
            let mut longer = Vec::new();
            for way in &ways {
                let from = way.last().map_or(self, |(_, desk)| desk);
                let last = way.last().map(|(command, _)| *command);
                for command in commands.iter().copied().filter(|&command| may_follow(last, command)) {
                    let mut next = from.clone();
                    if !next.command(floor, command) {
                        continue;
                    }
                    let is_there = next.is_in(mode);
                    let mut way = way.clone();
                    way.push((command, next));
                    if is_there {
                        return Some(way);
                    }
                    longer.push(way);
                }
            }
            ways = longer;
        }
        None
    }
}

/// Whether a command can lead further after another one.
fn may_follow(last: Option<ModeCommand>, command: ModeCommand) -> bool {
    match last {
        None => true,
        Some(ModeCommand::Reset) => command == ModeCommand::Manual,
        Some(ModeCommand::Start) => matches!(command, ModeCommand::Auto | ModeCommand::Manual | ModeCommand::Hand),
        Some(ModeCommand::Stop) => matches!(command, ModeCommand::Start | ModeCommand::Hand | ModeCommand::Manual),
        Some(_) => command == ModeCommand::Auto,
    }
}
