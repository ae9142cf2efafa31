//! The shell of the coordinator, without its sockets: decision, gateway and CAN manager in one process.

use std::time::Duration;

use linewright_coordinator_logic::{Coordinator, Gateway, Heard, Input, Outbox, OutputImage, Refusal};
use linewright_fieldbus::{Event as BusEvent, Frame, Manager, Outbox as Frames};
use linewright_line::net::ControlMode;
use linewright_line::{Bus, Line, Owner, StationId, Tick};
use linewright_node_shell::NewestBySequence;
use linewright_station_logic::{ModeOrder, Report};

use crate::network::{Image, Message, Node};

/// The coordinator's process.
pub(crate) struct CoordinatorNode {
    pub(crate) coordinator: Coordinator,
    gateway: Gateway,
    manager: Manager,
    bus: Frames,
    pub(crate) boot_id: u64,
    sequence: u64,
    states: Vec<NewestBySequence>,
    images: Vec<NewestBySequence>,
    outbox: Outbox,
    station_ids: Vec<StationId>,
    next_refresh: Tick,
    refresh: Duration,
    /// When the next output image runs out.
    images_due: Tick,
    /// Commands answered so far, obeyed or not.
    pub(crate) answered: u64,
}

/// What it wants said, sent and noted.
#[derive(Default)]
pub(crate) struct Said {
    pub(crate) messages: Vec<(Node, Message)>,
    pub(crate) frames: Vec<Frame>,
    pub(crate) modes: Vec<ControlMode>,
    pub(crate) refusals: Vec<Refusal>,
}

impl CoordinatorNode {
    pub(crate) fn start(now: Tick, line: &Line, boot_id: u64, last_epoch: u64, estopped: bool) -> Self {
        let on_line = line.devices.iter().filter(|device| device.bus == Bus::Line);
        let manager = Manager::new(on_line, line.timing).unwrap_or_else(|error| panic!("a test's devices: {error}"));
        let stations = line.stations.len();
        let coordinator = Coordinator::new(line.clone(), last_epoch);
        CoordinatorNode {
            coordinator: if estopped { coordinator.with_estop() } else { coordinator },
            gateway: Gateway::new(stations, line.timing.stale),
            manager,
            bus: Frames::default(),
            boot_id,
            sequence: 0,
            states: vec![NewestBySequence::new(); stations],
            images: vec![NewestBySequence::new(); stations],
            outbox: Outbox::default(),
            station_ids: line.station_ids().collect(),
            next_refresh: now,
            refresh: line.timing.refresh,
            images_due: Tick::NEVER,
            answered: 0,
        }
    }

    pub(crate) fn hear(&mut self, now: Tick, from: Node, message: &Message, said: &mut Said) {
        if self.is_newest(from, message) {
            self.take(now, from, message);
        }
        self.step(now, said);
    }

    fn is_newest(&mut self, from: Node, message: &Message) -> bool {
        let verdict = match (from, message) {
            (Node::Station(id), Message::Report(sequence, report)) => {
                self.states[id.index()].offer(report.boot_id, *sequence)
            }
            (Node::Station(id), Message::Outputs(image)) => {
                self.images[id.index()].offer(image.boot_id, image.sequence)
            }
            // What people say carries no number.
            _ => return true,
        };
        verdict.is_newest()
    }

    fn take(&mut self, now: Tick, from: Node, message: &Message) {
        match (from, message) {
            (Node::Station(id), Message::Report(_, report)) => {
                self.coordinator.handle(now, Input::Station(id, heard(report)));
            }
            (Node::Station(id), Message::Outputs(image)) => {
                let Image { bits, valid, losses, under, .. } = *image;
                self.gateway.hear(now, id, OutputImage { bits, valid, losses, boot_id: under.0, number: under.1 });
                self.energise(now, id);
            }
            (_, Message::Command(command)) => {
                self.coordinator.handle(now, Input::Command(*command));
                self.answered += 1;
            }
            (_, Message::Buttons(held)) => self.coordinator.handle(now, Input::Buttons(*held)),
            _ => {}
        }
    }

    /// A frame from a device.
    pub(crate) fn frame(&mut self, now: Tick, frame: &Frame, said: &mut Said) {
        self.manager.handle(now, frame, &mut self.bus);
        self.step(now, said);
    }

    /// What its manager says is wrong with an owner's devices.
    pub(crate) fn trouble(&self, now: Tick, owner: Owner) -> Vec<String> {
        self.manager.trouble(now, owner).collect()
    }

    /// Puts on the bus what a station's image is worth now.
    fn energise(&mut self, now: Tick, station: StationId) {
        let owner = Owner::Station(station);
        let losses = self.losses(now, station);
        let outputs = self.gateway.in_force(now, station, losses).bits;
        self.manager.set_outputs(now, owner, outputs, &mut self.bus);
    }

    /// Told apart from those a predecessor counted, which a station may still have in its last image.
    fn losses(&self, now: Tick, station: StationId) -> u64 {
        (self.boot_id << 32) | u64::from(self.manager.inputs(now, Owner::Station(station)).losses)
    }

    fn say_inputs(&mut self, now: Tick, station: StationId, said: &mut Said) {
        let inputs = self.manager.inputs(now, Owner::Station(station));
        let (boot_id, sequence, losses) = (self.boot_id, self.number(), self.losses(now, station));
        let under = self.gateway.in_force(now, station, losses).image.unwrap_or_default();
        let image = Image { boot_id, sequence, bits: inputs.bits, valid: inputs.valid, losses, under };
        said.messages.push((Node::Station(station), Message::Inputs(image)));
    }

    /// Does what is due and follows up what was heard.
    pub(crate) fn step(&mut self, now: Tick, said: &mut Said) {
        if self.manager.next_deadline().is_none_or(|due| due <= now) {
            self.manager.poll(now, &mut self.bus);
        }
        for event in std::mem::take(&mut self.bus.events) {
            let BusEvent::InputsChanged { owner } = event else { continue };
            match owner {
                Owner::Station(station) => {
                    self.say_inputs(now, station, said);
                    self.energise(now, station);
                }
                Owner::Console => {
                    let inputs = self.manager.inputs(now, owner);
                    self.coordinator.handle(now, Input::Console { bits: inputs.bits, valid: inputs.valid });
                }
            }
        }
        let due = now >= self.next_refresh;
        if due {
            self.next_refresh = now + self.refresh;
            for at in 0..self.station_ids.len() {
                self.say_inputs(now, self.station_ids[at], said);
            }
        }
        // An image that was heard or inputs that changed are put on the bus at once; time alone can only end an image.
        if due || now >= self.images_due {
            for at in 0..self.station_ids.len() {
                self.energise(now, self.station_ids[at]);
            }
        }
        self.images_due = self.gateway.next_deadline(now).unwrap_or(Tick::NEVER);
        self.coordinator.step(now, &mut self.outbox);
        self.manager.set_outputs(now, Owner::Console, self.outbox.lamps, &mut self.bus);
        if due || self.outbox.changed {
            self.say_order(said);
        }
        said.modes.append(&mut self.outbox.modes);
        said.refusals.append(&mut self.outbox.refusals);
        said.frames.append(&mut self.bus.frames);
    }

    fn say_order(&mut self, said: &mut Said) {
        let order = self.coordinator.order();
        let order = ModeOrder {
            boot_id: self.boot_id,
            epoch: order.epoch,
            mode: order.mode,
            enabled: order.enabled,
            master_stop: order.master_stop,
            manual_all: order.manual_all,
            buttons: order.buttons,
            lease: order.lease,
        };
        let sequence = self.number();
        for &station in &self.station_ids {
            said.messages.push((Node::Station(station), Message::Order(sequence, order)));
        }
    }

    fn number(&mut self) -> u64 {
        self.sequence += 1;
        self.sequence
    }

    pub(crate) fn next_deadline(&self, now: Tick) -> Tick {
        let or_never = |deadline: Option<Tick>| deadline.unwrap_or(Tick::NEVER);
        or_never(self.coordinator.next_deadline())
            .min(self.images_due)
            .min(self.manager.next_deadline().unwrap_or(now))
            .min(self.next_refresh)
    }
}

fn heard(report: &Report) -> Heard {
    Heard {
        boot_id: report.boot_id,
        mode_epoch: report.mode_epoch,
        round: report.round,
        at_home: report.at_home,
        stopped: report.stopped,
        incomplete: !report.incomplete.is_empty(),
        selector_manual: report.selector_manual,
        devices_valid: report.devices_valid,
    }
}
