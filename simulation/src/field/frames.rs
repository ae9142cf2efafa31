//! The machine by frames: the buses of a line, each with its manager, its devices and the mechanisms behind them.
//!
//! The coordinator reads the line's bus and carries the images of the stations on it; a station with a bus of its own is
//! the manager there.

use linewright_canopen::ManagerError;
use linewright_line::{DeviceBus as BusName, InputId, Line, OpId, OperationModule, Owner, StationId, Tick};
use linewright_plant::{DeviceFault, MotionFault, Plant, PlantOptions, Rack};

use super::bus::{Played, SimulatedBus};

/// An owner's inputs, as the manager of its bus has received them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SeenInputs {
    pub(crate) bits: u128,
    pub(crate) valid: bool,
    /// Number of losses of devices.
    pub(crate) losses: u64,
}

pub(crate) struct SimulatedBuses {
    buses: Vec<SimulatedBus>,
    /// By station, the console last: the bus its devices are on.
    of: Vec<usize>,
    unplugged: Vec<bool>,
}

impl SimulatedBuses {
    pub(crate) fn new(line: &Line, options: PlantOptions) -> Result<Self, ManagerError> {
        let coordinator = line.stations.len();
        let on_line = line.devices.iter().filter(|device| device.bus == BusName::Line).cloned().collect();
        let rack = Rack::new(Tick::ZERO, line, &BusName::Line, options);
        let mut buses = vec![SimulatedBus::new(line, on_line, rack, coordinator)?];
        let mut of = vec![0; coordinator + 1];
        for id in line.station_ids() {
            let name = &line.station(id).bus;
            if *name != BusName::Line {
                of[id.index()] = buses.len();
                // On another computer another bus may have the same name.
                let mut alone = line.clone();
                alone.devices.retain(|device| device.owner == Owner::Station(id));
                let rack = Rack::new(Tick::ZERO, &alone, name, options);
                buses.push(SimulatedBus::new(line, alone.devices, rack, id.index())?);
            }
        }
        Ok(SimulatedBuses { buses, of, unplugged: vec![false; line.devices.len()] })
    }

    /// The bus of an owner: a station or, at the end, the console.
    fn bus_of(&mut self, owner: Owner) -> &mut SimulatedBus {
        let at = self.number(owner);
        &mut self.buses[self.of[at]]
    }

    fn number(&self, owner: Owner) -> usize {
        match owner {
            Owner::Station(id) => id.index(),
            Owner::Console => self.of.len() - 1,
        }
    }

    /// The node that reads the devices of owner `at`.
    pub(crate) fn reader_of(&self, at: usize) -> usize {
        self.buses[self.of[at]].reader
    }

    fn read_by(&mut self, node: usize) -> Option<&mut SimulatedBus> {
        self.buses.iter_mut().find(|bus| bus.reader == node)
    }

    pub(crate) fn plant_of(&self, station: StationId) -> &Plant {
        self.buses[self.of[station.index()]].rack.plant()
    }

    pub(crate) fn alarms(&self) -> u64 {
        self.buses.iter().map(|bus| bus.rack.plant().alarms()).sum()
    }

    pub(crate) fn driven(&self, station: StationId) -> u128 {
        self.buses[self.of[station.index()]].rack.driven(Owner::Station(station))
    }

    /// Whether a station is the manager of its devices' bus.
    pub(crate) fn has_own(&self, station: StationId) -> bool {
        self.of[station.index()] != 0
    }

    pub(crate) fn deadline(&self, node: usize) -> Tick {
        self.buses.iter().find(|bus| bus.reader == node).map_or(Tick::NEVER, SimulatedBus::deadline)
    }

    /// Plays one event that is due on the bus that a node reads; returns it.
    pub(crate) fn play(&mut self, now: Tick, node: usize) -> Played {
        self.read_by(node).map_or(Played::Nothing, |bus| bus.play(now))
    }

    /// Lets the manager of a node's bus do its work that is due.
    pub(crate) fn poll(&mut self, now: Tick, node: usize) {
        if let Some(bus) = self.read_by(node) {
            bus.poll(now);
        }
    }

    /// Puts the frames of the manager of a node's bus on the wire.
    pub(crate) fn send(&mut self, now: Tick, node: usize) {
        if let Some(bus) = self.read_by(node) {
            bus.send(now);
        }
    }

    pub(crate) fn inputs(&self, now: Tick, owner: Owner) -> SeenInputs {
        let image = self.buses[self.of[self.number(owner)]].manager().map(|manager| manager.inputs(now, owner));
        image.map_or(SeenInputs { bits: 0, valid: false, losses: 0 }, |image| SeenInputs {
            bits: image.bits,
            valid: image.valid,
            losses: u64::from(image.losses),
        })
    }

    pub(crate) fn put(&mut self, now: Tick, owner: Owner, outputs: u128) {
        self.bus_of(owner).ask(|manager, out| manager.set_outputs(now, owner, outputs, out));
    }

    /// Faults of an owner's devices, in the manager's words; empty while there is no manager.
    pub(crate) fn trouble(&self, now: Tick, owner: Owner) -> Vec<String> {
        let manager = self.buses[self.of[self.number(owner)]].manager();
        manager.map(|manager| manager.trouble(now, owner).collect()).unwrap_or_default()
    }

    /// A node's process ends, or starts, and with it the manager of the bus it reads.
    pub(crate) fn read(&mut self, line: &Line, node: usize, read: bool) {
        if let Some(bus) = self.read_by(node) {
            bus.read(line, read);
        }
    }

    /// Does something to the devices or mechanisms of an owner. Gives the node that reads them.
    pub(crate) fn disturb(&mut self, now: Tick, owner: Owner, does: impl FnOnce(&mut Rack)) -> usize {
        let bus = self.bus_of(owner);
        bus.disturb(now, |rack, _| does(rack));
        bus.reader
    }

    /// The manager's interface of the line's bus leaves it, or comes back to it.
    pub(crate) fn turn_off(&mut self, now: Tick, off: bool) {
        self.buses[0].turn_off(now, off);
    }

    pub(crate) fn unplug(&mut self, line: &Line, now: Tick, device: usize, unplugged: bool) -> usize {
        self.unplugged[device] = unplugged;
        let device = &line.devices[device];
        self.disturb(now, device.owner, |rack| rack.fail_device(now, device, unplugged.then_some(DeviceFault::Silent)))
    }

    pub(crate) fn is_unplugged(&self, device: usize) -> bool {
        self.unplugged[device]
    }

    pub(crate) fn fail(
        &mut self,
        line: &Line,
        now: Tick,
        (station, op): (StationId, OpId),
        normal: bool,
        fault: Option<MotionFault>,
    ) {
        let (owner, operation) = (Owner::Station(station), line.operation((station, op)));
        let output = match &operation.module {
            OperationModule::Reversible { recovery, .. } if !normal => recovery.actuator,
            _ => operation.normal.actuator,
        };
        self.bus_of(owner).disturb(now, |rack, out| match (rack.fail_motion(now, owner, output, fault, out), normal) {
            (true, _) => {}
            (false, true) => rack.plant_mut().inject(now, station, op, fault),
            (false, false) => rack.plant_mut().inject_recovery(now, station, op, fault),
        });
    }

    pub(crate) fn force(&mut self, now: Tick, at: usize, input: InputId, value: Option<bool>) {
        let owner = if at + 1 == self.of.len() { Owner::Console } else { Owner::Station(StationId::at(at)) };
        self.disturb(now, owner, |rack| rack.plant_mut().force(owner, input, value));
    }
}
