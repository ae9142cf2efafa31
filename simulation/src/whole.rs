//! A line on its buses: what passes between nodes and devices when images travel in frames and messages.
//!
//! Nodes repeat their state by themselves, and every message goes out whole, with its number. Where images are there at
//! once none of this is played.

use linewright_coordinator_logic::OutputImage;
use linewright_coordinator_shell::{CoordinatorArrival, InputsImage};
use linewright_line::{DeviceBus, Owner, StationId};
use linewright_station_shell::{Driven, InputsMessage};

use crate::field::{Played, SimulatedField};
use crate::link::WholeMessage;
use crate::sim::LineSim;

impl LineSim {
    /// Something is due on the bus that a node reads.
    pub(crate) fn bus_changes(&mut self, node: usize) {
        let SimulatedField::Frames(frames) = &mut self.field else { return };
        match frames.play(self.now, node) {
            Played::Devices => self.observer.look_everywhere(&self.line, |id| self.field.plant_of(id)),
            Played::Manager if self.is_up(node) => return self.play(node),
            Played::Manager | Played::Nothing => {}
        }
        self.wake_bus(node);
    }

    fn wake_bus(&mut self, node: usize) {
        let due = self.field.deadline(node).max(self.now);
        self.timers.set(self.field_slot(node), due);
    }

    /// Reads the inputs that the managers of buses have, before a node decides.
    pub(crate) fn look_at_own_bus(&mut self, at: usize) {
        let SimulatedField::Frames(frames) = &mut self.field else { return };
        let id = StationId::at(at);
        if frames.has_own(id) {
            frames.poll(self.now, at);
            let image = frames.inputs(self.now, Owner::Station(id));
            self.stations[at].look(self.now, image);
        }
    }

    pub(crate) fn look_at_line_bus(&mut self) {
        let SimulatedField::Frames(frames) = &mut self.field else { return };
        let (now, shell) = (self.now, &mut self.coordinator.shell);
        frames.poll(now, self.stations.len());
        let image = frames.inputs(now, Owner::Console);
        shell.handle(now, CoordinatorArrival::Console { bits: image.bits, valid: image.valid });
        for station in self.line.station_ids() {
            if !frames.has_own(station) {
                let image = frames.inputs(now, Owner::Station(station));
                let (bits, valid, losses) = (image.bits, image.valid, image.losses);
                shell.handle(now, CoordinatorArrival::Devices { station, bits, valid, losses });
            }
        }
    }

    /// Puts outputs on their bus.
    pub(crate) fn put(&mut self, owner: Owner, outputs: u128) {
        if let SimulatedField::Frames(frames) = &mut self.field {
            frames.put(self.now, owner, outputs);
        }
    }

    /// Sends the frames that were put on the bus that a node reads.
    pub(crate) fn send_frames(&mut self, node: usize) {
        if let SimulatedField::Frames(frames) = &mut self.field {
            frames.send(self.now, node);
            self.wake_bus(node);
        }
    }

    /// A station's outputs go to its own bus, or to the gateway.
    pub(crate) fn send_outputs(&mut self, at: usize, image: Driven) {
        if let DeviceBus::Own(_) = self.line.stations[at].bus {
            return self.put(Owner::Station(StationId::at(at)), image.bits);
        }
        let outputs = OutputImage {
            bits: image.bits,
            valid: true,
            losses: image.lives,
            boot_id: self.stations[at].life(),
            number: image.number,
            mode_epoch: image.mode_epoch,
        };
        self.send(at, self.coordinator_node(), image.sequence, WholeMessage::Outputs(outputs));
    }

    /// The gateway sends a station its inputs.
    pub(crate) fn send_inputs(&mut self, station: StationId, sequence: u64, image: InputsImage) {
        let InputsImage { bits, valid, lives, under } = image;
        let boot_id = self.coordinator.shell.boot_id();
        let inputs = InputsMessage { boot_id, sequence, bits, valid, lives, under: under.unwrap_or_default() };
        self.send(self.coordinator_node(), station.index(), sequence, WholeMessage::Inputs(inputs));
    }

    /// The coordinator's order goes to every station.
    pub(crate) fn send_orders(&mut self, sequence: u64) {
        for station in (0..self.stations.len()).map(StationId::at) {
            let order = self.coordinator.shell.order_for(station);
            self.send(self.coordinator_node(), station.index(), sequence, WholeMessage::Order(order));
        }
    }

    /// A station's state goes to all its readers.
    pub(crate) fn tell_station(&mut self, at: usize, sequence: u64) {
        self.stations[at].is_to_say();
        self.stations[at].write_report();
        let coordinator = self.coordinator_node();
        for index in 0..self.out_of[at].len() {
            let to = self.links[self.out_of[at][index]].to;
            let node = &self.stations[at];
            let said = if to == coordinator {
                WholeMessage::Heard(node.heard())
            } else {
                WholeMessage::Report(std::rc::Rc::clone(&node.report))
            };
            self.send(at, to, sequence, said);
        }
    }

    /// Sends a message that is read by its number.
    pub(crate) fn send(&mut self, from: usize, to: usize, number: u64, said: WholeMessage) {
        let is_image = matches!(said, WholeMessage::Inputs(_) | WholeMessage::Outputs(_));
        let network = if is_image { self.options.images } else { self.options.network };
        let link = self.out_of[from].iter().copied().find(|&at| self.links[at].to == to);
        if let Some(link) = link {
            self.links[link].say_numbered(self.now, &network, number, said);
            self.timers.set(link, self.links[link].wakes());
        }
    }
}
