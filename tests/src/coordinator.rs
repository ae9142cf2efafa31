//! The coordinator's process: its shell, a CAN manager, and a disk.

use linewright_coordinator_logic::{Coordinator, OutputImage, Refusal};
use linewright_coordinator_shell::{
    CoordinatorArrival, CoordinatorEffect, CoordinatorShell, InputsImage, Remembered, heard,
};
use linewright_fieldbus::{Frame, Manager, Outbox as Frames};
use linewright_line::net::ControlMode;
use linewright_line::{Bus, Line, Owner, StationId, Tick};

use crate::network::{Image, Message, Node};

/// The coordinator's process.
pub(crate) struct CoordinatorProcess {
    shell: CoordinatorShell,
    manager: Manager,
    bus: Frames,
    effects: Vec<CoordinatorEffect>,
    station_ids: Vec<StationId>,
    /// What its disk holds.
    pub(crate) journal: Remembered,
    /// Its disk takes no record.
    pub(crate) disk_is_full: bool,
    /// Commands answered so far, obeyed or not.
    pub(crate) answered: u64,
}

/// What it sends, and what is noted.
#[derive(Default)]
pub(crate) struct CoordinatorPerformed {
    pub(crate) messages: Vec<(Node, Message)>,
    pub(crate) frames: Vec<Frame>,
    pub(crate) modes: Vec<ControlMode>,
    pub(crate) refusals: Vec<Refusal>,
}

impl CoordinatorProcess {
    pub(crate) fn start(line: &Line, boot_id: u64, journal: Remembered) -> Self {
        let on_line = line.devices.iter().filter(|device| device.bus == Bus::Line);
        let manager = Manager::new(on_line, line.timing).unwrap_or_else(|error| panic!("a test's devices: {error}"));
        CoordinatorProcess {
            shell: CoordinatorShell::new(line, boot_id, journal),
            manager,
            bus: Frames::default(),
            effects: Vec::new(),
            station_ids: line.station_ids().collect(),
            journal,
            disk_is_full: false,
            answered: 0,
        }
    }

    pub(crate) fn coordinator(&self) -> &Coordinator {
        self.shell.coordinator()
    }

    pub(crate) fn boot_id(&self) -> u64 {
        self.shell.boot_id()
    }

    pub(crate) fn hear(&mut self, now: Tick, from: Node, message: &Message, said: &mut CoordinatorPerformed) {
        let arrival = match (from, message) {
            (Node::Station(station), Message::Report(sequence, report)) => {
                Some(CoordinatorArrival::State { station, sequence: *sequence, heard: heard(report) })
            }
            (Node::Station(station), Message::Outputs(image)) => {
                let Image { sequence, bits, valid, losses, under: (boot_id, number), mode_epoch, .. } = *image;
                let image = OutputImage { bits, valid, losses, boot_id, number, mode_epoch };
                Some(CoordinatorArrival::Outputs { station, sequence, image })
            }
            (_, Message::Command(command)) => {
                self.answered += 1;
                Some(CoordinatorArrival::Command(*command))
            }
            (_, Message::Buttons(held)) => Some(CoordinatorArrival::Buttons(*held)),
            _ => None,
        };
        if let Some(arrival) = arrival {
            self.shell.handle(now, arrival);
        }
        self.step(now, said);
    }

    /// A frame from a device.
    pub(crate) fn frame(&mut self, now: Tick, frame: &Frame, said: &mut CoordinatorPerformed) {
        self.manager.handle(now, frame, &mut self.bus);
        self.step(now, said);
    }

    /// What its manager says is wrong with an owner's devices.
    pub(crate) fn trouble(&self, now: Tick, owner: Owner) -> Vec<String> {
        self.manager.trouble(now, owner).collect()
    }

    /// What the bus knows of inputs now.
    fn look(&mut self, now: Tick) {
        let image = self.manager.inputs(now, Owner::Console);
        self.shell.handle(now, CoordinatorArrival::Console { bits: image.bits, valid: image.valid });
        for &station in &self.station_ids {
            let image = self.manager.inputs(now, Owner::Station(station));
            let (bits, valid, losses) = (image.bits, image.valid, u64::from(image.losses));
            self.shell.handle(now, CoordinatorArrival::Devices { station, bits, valid, losses });
        }
    }

    /// Does what is due and follows up what was heard.
    pub(crate) fn step(&mut self, now: Tick, said: &mut CoordinatorPerformed) {
        if self.manager.next_deadline().is_none_or(|due| due <= now) {
            self.manager.poll(now, &mut self.bus);
        }
        self.bus.events.clear();
        self.look(now);
        // Once more after a record that could not be written: the emergency stop.
        for _ in 0..2 {
            let mut effects = std::mem::take(&mut self.effects);
            self.shell.act(now, &mut effects);
            let is_written = effects.drain(..).all(|effect| self.perform(now, effect, said));
            self.effects = effects;
            if is_written {
                break;
            }
        }
        said.frames.append(&mut self.bus.frames);
    }

    /// False if it was a record after which it has to be decided again.
    fn perform(&mut self, now: Tick, effect: CoordinatorEffect, said: &mut CoordinatorPerformed) -> bool {
        match effect {
            CoordinatorEffect::Refused(refusal) => said.refusals.push(refusal),
            CoordinatorEffect::Entered(mode) => said.modes.push(mode),
            CoordinatorEffect::Remember(record) => {
                if !self.disk_is_full {
                    self.journal = record;
                }
                return self.shell.remembered(now, record, !self.disk_is_full);
            }
            CoordinatorEffect::Lamps(bits) => self.manager.set_outputs(now, Owner::Console, bits, &mut self.bus),
            CoordinatorEffect::Energise(station, bits) => {
                self.manager.set_outputs(now, Owner::Station(station), bits, &mut self.bus);
            }
            CoordinatorEffect::Inputs { station, sequence, image } => {
                let InputsImage { bits, valid, lives, under } = image;
                let (boot_id, under) = (self.shell.boot_id(), under.unwrap_or_default());
                let image = Image { boot_id, sequence, bits, valid, losses: lives, under, mode_epoch: 0 };
                said.messages.push((Node::Station(station), Message::Inputs(image)));
            }
            CoordinatorEffect::Order { sequence } => {
                let order = |id| Message::Order(sequence, self.shell.order_for(id));
                said.messages.extend(self.station_ids.iter().map(|&id| (Node::Station(id), order(id))));
            }
            CoordinatorEffect::Tell { .. } => {}
        }
        true
    }

    pub(crate) fn next_deadline(&self, now: Tick) -> Tick {
        self.shell.next_deadline(now).min(self.manager.next_deadline().unwrap_or(now))
    }
}
