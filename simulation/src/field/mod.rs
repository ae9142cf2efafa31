//! The machine as the controllers meet it: by process images at once, or by frames on buses.
//!
//! Images are what a line needs that is to be played fast: they carry no frames, and the gateway is left out. Frames are
//! what a line is really moved by, with everything that can happen to them. The mechanisms behind are the same.

mod bus;
mod frames;
mod images;

use linewright_line::{AxisId, InputId, Line, OpId, OperationModule, Owner, StationId, Tick};
use linewright_plant::{MotionFault, NestPosition, PartByHand, Plant, PlantOptions};

use crate::error::StartError;

pub(crate) use bus::Played;
pub(crate) use frames::{SeenInputs, SimulatedBuses};
pub(crate) use images::Images;

/// The machine.
pub(crate) enum SimulatedField {
    Images(Box<Images>),
    Frames(Box<SimulatedBuses>),
}

impl SimulatedField {
    pub(crate) fn new(line: &Line, options: PlantOptions, by_frames: bool) -> Result<Self, StartError> {
        let elsewhere = line.devices.iter().find(|device| !device.is_on_can());
        if let Some(device) = elsewhere.filter(|_| by_frames) {
            return Err(StartError::NoFrames { device: device.name.clone() });
        }
        Ok(if by_frames {
            SimulatedField::Frames(Box::new(SimulatedBuses::new(line, options)?))
        } else {
            SimulatedField::Images(Box::new(Images::new(line, options)))
        })
    }

    /// The mechanisms of a station. Each bus has its own plant, in which stations on other buses stand still.
    pub(crate) fn plant_of(&self, station: StationId) -> &Plant {
        match self {
            SimulatedField::Images(images) => images.plant(),
            SimulatedField::Frames(frames) => frames.plant_of(station),
        }
    }

    pub(crate) fn position(&self, station: StationId, axis: AxisId) -> f64 {
        self.plant_of(station).position(station, axis)
    }

    /// Number of times that drives both ways of one axis came on at once.
    pub(crate) fn alarms(&self) -> u64 {
        match self {
            SimulatedField::Images(images) => images.plant().alarms(),
            SimulatedField::Frames(frames) => frames.alarms(),
        }
    }

    /// The actuators of a station that are energised at its devices, a bit per output.
    pub(crate) fn energised(&self, line: &Line, station: StationId) -> u128 {
        let driven = match self {
            SimulatedField::Images(images) => images.plant().outputs(Owner::Station(station)),
            SimulatedField::Frames(frames) => frames.driven(station),
        };
        let actuators = line.station(station).operations.iter().fold(0, |bits, operation| {
            let recovery = match &operation.module {
                OperationModule::Reversible { recovery, .. } => recovery.actuator.bit(),
                OperationModule::Irreversible { .. } => 0,
            };
            bits | operation.normal.actuator.bit() | recovery
        });
        driven & actuators
    }

    /// Time of the next event on what node `at` reads.
    pub(crate) fn deadline(&self, at: usize) -> Tick {
        match self {
            SimulatedField::Images(images) => images.deadline(at),
            SimulatedField::Frames(frames) => frames.deadline(at),
        }
    }

    /// The node that looks at the devices of owner `at`.
    pub(crate) fn reader_of(&self, at: usize) -> usize {
        match self {
            SimulatedField::Images(_) => at,
            SimulatedField::Frames(frames) => frames.reader_of(at),
        }
    }

    /// Makes a motion fail, the normal one or the one that undoes it, or work again.
    pub(crate) fn fail(
        &mut self,
        line: &Line,
        now: Tick,
        op: (StationId, OpId),
        normal: bool,
        fault: Option<MotionFault>,
    ) {
        match self {
            SimulatedField::Images(images) => images.fail(now, op, normal, fault),
            SimulatedField::Frames(frames) => frames.fail(line, now, op, normal, fault),
        }
    }

    /// Holds an input of owner `at`, or releases it.
    pub(crate) fn force(&mut self, now: Tick, at: usize, input: InputId, value: Option<bool>) {
        match self {
            SimulatedField::Images(images) => images.force(now, at, input, value),
            SimulatedField::Frames(frames) => frames.force(now, at, input, value),
        }
    }

    /// A person takes a part out of the plant of a station, or puts one in. What cannot be done is left.
    pub(crate) fn by_hand(&mut self, now: Tick, at: usize, what: PartByHand, place: NestPosition) {
        match self {
            SimulatedField::Images(images) => images.by_hand(now, what, place),
            SimulatedField::Frames(frames) => {
                frames.disturb(now, Owner::Station(StationId::at(at)), |rack| {
                    _ = rack.plant_mut().by_hand(now, what, place)
                });
            }
        }
    }

    /// Unplugs a device of the description, or plugs it in again. Gives the node that reads it.
    pub(crate) fn unplug(&mut self, line: &Line, now: Tick, device: usize, unplugged: bool) -> Option<usize> {
        match self {
            SimulatedField::Images(images) => images.unplug(now, device, unplugged),
            SimulatedField::Frames(frames) => Some(frames.unplug(line, now, device, unplugged)),
        }
    }

    pub(crate) fn is_unplugged(&self, device: usize) -> bool {
        match self {
            SimulatedField::Images(images) => images.is_unplugged(device),
            SimulatedField::Frames(frames) => frames.is_unplugged(device),
        }
    }
}
