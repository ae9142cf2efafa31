//! The CAN bus of the line in virtual time: the devices at its far end and the plant behind them.
//!
//! Devices and mechanisms are the real ones, and so is the manager at the near end, which dies and comes back with
//! the coordinator. The wire delays every frame by the same time, so frames keep their order, as they do on a bus.

use std::time::Duration;

use linewright_fieldbus::{Frame, NodeId};
use linewright_line::{AxisId, Bus, InputId, Line, OpId, Owner, StationId, Tick};
use linewright_plant::{DeviceFault, Fault, FrameFaults, Plant, PlantOptions, Rack};

use crate::observer::Observer;

/// About what a classic CAN frame takes at 1 Mbit/s, with its turn to wait for.
pub(crate) const FRAME_TIME: Duration = Duration::from_micros(150);

/// The devices and the mechanisms behind them, watched.
pub(crate) struct Field {
    rack: Rack,
    observer: Observer,
    frames: Vec<Frame>,
    /// Actuators of each station, a bit per output.
    actuators: Vec<u128>,
    /// By station, by operation: the axis it moves.
    axes: Vec<Vec<AxisId>>,
}

impl Field {
    pub(crate) fn new(line: &Line, options: PlantOptions) -> Self {
        let actuators = |station: &linewright_line::Station| {
            station.operations.iter().fold(0, |bits, operation| {
                let recovery = match &operation.module {
                    linewright_line::Module::Reversible { recovery, .. } => 1 << recovery.actuator.0,
                    linewright_line::Module::Irreversible { .. } => 0,
                };
                bits | 1 << operation.normal.actuator.0 | recovery
            })
        };
        Field {
            rack: Rack::new(Tick::ZERO, line, &Bus::Line, options),
            observer: Observer::new(line),
            frames: Vec::new(),
            actuators: line.stations.iter().map(actuators).collect(),
            axes: line.stations.iter().map(|s| s.operations.iter().map(|op| op.motion.axis).collect()).collect(),
        }
    }

    /// A frame from the manager.
    pub(crate) fn hear(&mut self, now: Tick, frame: &Frame) {
        self.rack.handle(now, frame, &mut self.frames);
        self.observer.look(self.rack.plant());
    }

    pub(crate) fn poll(&mut self, now: Tick) {
        self.rack.poll(now, &mut self.frames);
        self.observer.look(self.rack.plant());
    }

    pub(crate) fn next_deadline(&self) -> Tick {
        self.rack.next_deadline().unwrap_or(Tick::NEVER)
    }

    /// What the devices have to say since the last time.
    pub(crate) fn drain(&mut self) -> std::vec::Drain<'_, Frame> {
        self.frames.drain(..)
    }

    pub(crate) fn lose_parts(&mut self) {
        self.observer.lose_parts();
    }

    pub(crate) fn observer(&self) -> &Observer {
        &self.observer
    }

    pub(crate) fn plant(&self) -> &Plant {
        self.rack.plant()
    }

    /// Makes a motion fail, its normal and its recovery one, or work again.
    pub(crate) fn fail(&mut self, now: Tick, station: StationId, op: OpId, fault: Option<Fault>) {
        if !self.fail_drive(now, station, op, fault) {
            self.rack.plant_mut().inject(now, station, op, fault);
        }
        self.poll(now);
    }

    /// Makes the recovery motion of an operation fail, or work again.
    pub(crate) fn fail_recovery(&mut self, now: Tick, station: StationId, op: OpId, fault: Option<Fault>) {
        if !self.fail_drive(now, station, op, fault) {
            self.rack.plant_mut().inject_recovery(now, station, op, fault);
        }
        self.poll(now);
    }

    /// A drive fails with its axis, whichever motion it makes.
    fn fail_drive(&mut self, now: Tick, station: StationId, op: OpId, fault: Option<Fault>) -> bool {
        let axis = self.axes[station.index()][op.index()];
        self.rack.fail_axis(now, station, axis, fault, &mut self.frames)
    }

    /// Holds an input, like a finger on a wired button or a stuck switch.
    pub(crate) fn force(&mut self, now: Tick, owner: Owner, input: InputId, value: Option<bool>) {
        self.rack.plant_mut().force(owner, input, value);
        self.poll(now);
    }

    /// Makes a device fail, or work again.
    pub(crate) fn fail_device(&mut self, now: Tick, node: NodeId, fault: Option<DeviceFault>) {
        self.rack.inject(now, node, fault);
        self.poll(now);
    }

    /// The same of a device that speaks no CANopen.
    pub(crate) fn fail_plain(&mut self, now: Tick, name: &str, fault: Option<DeviceFault>) {
        if let Some(device) = self.rack.plain_mut(name) {
            device.inject(now, fault);
        }
        self.poll(now);
    }

    /// Makes the line to a device lose and double frames.
    pub(crate) fn disturb(&mut self, node: NodeId, faults: FrameFaults) {
        self.rack.disturb(node, faults);
    }

    /// Holds an output bit of a device at a value, or lets it follow process data again.
    pub(crate) fn stick(&mut self, now: Tick, node: NodeId, output: usize, value: Option<bool>) {
        self.rack.stick(node, output, value);
        self.poll(now);
    }

    /// The actuators of a station that are energised now.
    pub(crate) fn energised(&self, station: StationId) -> u128 {
        self.rack.driven(Owner::Station(station)) & self.actuators[station.index()]
    }
}
