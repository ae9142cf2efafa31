//! A controller on a bench: a person sets its inputs, its commands and its peers' reports, and reads what it does.
//!
//! There is no mechanism here. The test sets when a motion arrives; every motion of a built station has switches of its
//! own, so an image contains only what the test put into it.

use std::time::Duration;

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{Line, OpId, StationId, Tick};
use linewright_station_logic::{
    Controller, Handled, ModeOrder, NO_DELAY, PanelCommand, Restore, Rules, StationInput, StationOutbox, StationReport,
};

use linewright_testkit::built::{actuator_bit, complete_bit};

/// Period of commands and views while time passes, as in the shipped timing.
const REFRESH: Duration = Duration::from_millis(50);

pub struct Rig {
    pub line: Line,
    pub station: StationId,
    pub controller: Controller,
    pub now: Tick,
    pub order: ModeOrder,
    pub outputs: u128,
    pub image: u128,
    valid: bool,
    held: [Option<PanelCommand>; 2],
    peers: Vec<(StationId, StationReport)>,
    pub out: StationOutbox,
    events: Vec<String>,
}

impl Rig {
    /// At home, in stand-by, devices received, panel switched to manual.
    pub fn new(line: Line) -> Self {
        Rig::of(line, StationId(0), Restore::Fresh)
    }

    pub fn of(line: Line, station: StationId, restore: Restore) -> Self {
        let home = line.operation((station, line.station(station).home)).normal.complete;
        Rig::standing(line, station, 1, restore, 1 << home.0)
    }

    /// With this image, by a process of this boot id.
    pub fn standing(line: Line, station: StationId, boot_id: u64, restore: Restore, image: u128) -> Self {
        let controller = Controller::new(&line, station, boot_id, restore).expect("a built station compiles");
        // Its images do not measure its mechanisms, and its peers were never at home with it.
        let controller = controller.with_rules(Rules::COUNTS);
        let order = ModeOrder { manual_all: true, ..ModeOrder::of(7, 1, ControlMode::StandBy, line.timing.lease) };
        let mut rig = Rig {
            line,
            station,
            controller,
            now: Tick::from_millis(1000),
            order,
            outputs: 0,
            image,
            valid: true,
            held: [None; 2],
            peers: Vec::new(),
            out: StationOutbox::default(),
            events: Vec::new(),
        };
        rig.refresh();
        rig.events();
        rig
    }

    /// A station by itself, without arrows and conflicts, that judges measured positions.
    pub fn alone(mut line: Line, station: StationId, restore: Restore, image: u128) -> Self {
        line.arrows.clear();
        line.conflicts.clear();
        let mut rig = Rig::standing(line, station, 1, restore, image);
        rig.controller = rig.controller.with_rules(Rules::ALL);
        rig
    }

    /// Whether an index is in doubt, and its station's position lost with it.
    pub fn is_doubtful(&self) -> bool {
        self.controller.position_lost().is_some() && self.fault().contains("index in doubt: ")
    }

    pub fn fault(&self) -> String {
        self.controller.fault_text(&self.line)
    }

    /// Led on at its panel: in manual, with advance held.
    pub fn manual(&mut self) {
        self.mode(ControlMode::Manual);
        self.advance(true);
    }

    pub fn rejoin(&mut self, within: Option<OpId>) -> Handled {
        let handled = self.controller.handle(self.now, StationInput::Rejoin(within.into(), &[]));
        self.refresh();
        handled
    }

    pub fn step(&mut self) {
        self.controller.step(self.now, &mut self.out);
        self.outputs = self.out.outputs;
        for event in self.out.events.drain(..) {
            self.events.push(event.text(&self.line, self.station));
        }
    }

    fn send_image(&mut self) {
        let (bits, valid) = (self.image, self.valid);
        self.controller.handle(self.now, StationInput::Inputs { bits, valid, until: Tick::NEVER, under: NO_DELAY });
    }

    /// Everything that is sent over and over, once more.
    pub fn refresh(&mut self) {
        self.send_image();
        self.controller.handle(self.now, StationInput::Order(self.order));
        for command in self.held.into_iter().flatten() {
            self.controller.handle(self.now, StationInput::Panel(command));
        }
        for (station, report) in &self.peers {
            self.controller.handle(self.now, StationInput::View(*station, report));
        }
        self.step();
    }

    /// Events since the last call, in words.
    pub fn events(&mut self) -> Vec<String> {
        std::mem::take(&mut self.events)
    }

    pub fn set(&mut self, bits: u128, on: bool) {
        self.image = if on { self.image | bits } else { self.image & !bits };
        self.send_image();
        self.step();
    }

    pub fn devices(&mut self, valid: bool) {
        self.valid = valid;
        self.send_image();
        self.step();
    }

    /// The motion's switch comes on; in the next image it is off again.
    pub fn arrive(&mut self, op: u16) {
        self.pulse(complete_bit(OpId(op), false));
    }

    pub fn arrive_back(&mut self, op: u16) {
        self.pulse(complete_bit(OpId(op), true));
    }

    fn pulse(&mut self, bits: u128) {
        // What was on before (the switch at home) goes off as soon as something moves.
        self.set(u128::MAX, false);
        self.set(bits, true);
        self.set(bits, false);
    }

    pub fn mode(&mut self, mode: ControlMode) {
        self.order.mode = mode;
        self.order.epoch += 1;
        self.order();
    }

    pub fn order(&mut self) {
        self.controller.handle(self.now, StationInput::Order(self.order));
        self.step();
    }

    pub fn hold(&mut self, button: u16) {
        self.order.buttons |= 1 << button;
        self.order();
    }

    pub fn release(&mut self, button: u16) {
        self.order.buttons &= !(1 << button);
        self.order();
    }

    pub fn advance(&mut self, held: bool) {
        self.panel(0, PanelCommand::Advance(held));
    }

    pub fn retract(&mut self, held: bool) {
        self.panel(1, PanelCommand::Retract(held));
    }

    fn panel(&mut self, key: usize, command: PanelCommand) {
        let down = matches!(command, PanelCommand::Advance(true) | PanelCommand::Retract(true));
        self.held[key] = down.then_some(command);
        self.controller.handle(self.now, StationInput::Panel(command));
        self.step();
    }

    /// Presses advance at the panel, lets the motion arrive, releases.
    pub fn advance_through(&mut self, op: u16) {
        self.advance(true);
        self.arrive(op);
        self.advance(false);
    }

    pub fn retract_through(&mut self, op: u16) {
        self.retract(true);
        self.arrive_back(op);
        self.retract(false);
    }

    /// Time passes, and everything goes on being refreshed.
    pub fn wait_ms(&mut self, ms: u64) {
        let end = self.now + Duration::from_millis(ms);
        while self.now < end {
            self.now = (self.now + REFRESH).min(end);
            self.refresh();
        }
    }

    /// Time passes in silence; the controller is stepped at its own deadlines.
    pub fn silence_ms(&mut self, ms: u64) {
        let end = self.now + Duration::from_millis(ms);
        while let Some(next) = self.controller.next_deadline().filter(|&next| next <= end) {
            self.now = self.now.max(next);
            self.step();
        }
        self.now = end;
    }

    /// A peer sends a new state, and repeats it.
    pub fn hear(&mut self, station: StationId, report: StationReport) {
        self.controller.handle(self.now, StationInput::View(station, &report));
        self.peers.retain(|(s, _)| *s != station);
        self.peers.push((station, report));
        self.step();
    }

    pub fn report(&self) -> StationReport {
        self.controller.report()
    }

    pub fn marking(&self) -> Vec<StationPlace> {
        self.controller.marking().collect()
    }

    pub fn doing(&self) -> String {
        self.controller.operation_text(&self.line)
    }

    pub fn blocked_by(&self) -> Vec<String> {
        self.controller.blocked_by(&self.line, self.now)
    }

    pub fn drives(&self, op: u16) -> bool {
        self.outputs == actuator_bit(OpId(op), false)
    }

    pub fn drives_back(&self, op: u16) -> bool {
        self.outputs == actuator_bit(OpId(op), true)
    }
}

/// A peer's report of these counts, everything else at rest.
pub fn peer_says(done: &[i32]) -> StationReport {
    StationReport {
        boot_id: 1,
        cycle: done[0],
        done: done.to_vec(),
        started: done.to_vec(),
        ..StationReport::default()
    }
}
