//! Binding of a drive: outputs and inputs of its owner's image, in the drive's increments.

use linewright_line::{AtRest, Drive as Described, DriveMode, DriveTarget, InputId, OutputId};

use super::{DrivePlaces, PDO_BYTES, word};
use crate::codec::Payload;

/// One place a drive can be sent to, or one velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriveSetpoint {
    pub output: OutputId,
    /// The place in increments; in velocity mode the velocity in increments per second.
    pub to: i32,
    /// The input that is on while it is there. Targets at one place share it.
    pub at: InputId,
    /// Velocity of the motion there, in increments per second.
    pub velocity: u32,
}

/// Homing. Speeds in increments per second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HomingBinding {
    /// Method (object 6098h).
    pub method: i8,
    /// Speed for finding the switch (6099h sub 1).
    pub fast: u32,
    /// Speed for finding its edge (6099h sub 2).
    pub slow: u32,
    /// Acceleration (609Ah).
    pub acceleration: u32,
    /// Position after homing (607Ch).
    pub offset: i32,
    /// The output that starts it. If it is a target's, the drive homes first and goes to the target then.
    pub output: OutputId,
    /// The input that is on while the zero is known.
    pub done: Option<InputId>,
}

/// A drive's axis, bound to an image.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveBinding {
    /// Kind of its targets.
    pub mode: DriveMode,
    pub targets: Vec<DriveSetpoint>,
    /// Of an endless axis: its places, which are the targets, and their numbers.
    pub index: Option<DrivePlaces>,
    /// On while it has failed or refuses an order.
    pub fault: Option<InputId>,
    /// Homing; `None` for a drive with an absolute position.
    pub home: Option<HomingBinding>,
    /// It is at a target within this distance.
    pub window: u32,
    /// Usual profile velocity (6081h).
    pub velocity: u32,
    /// Profile acceleration and deceleration (6083h, 6084h).
    pub acceleration: u32,
    /// Deceleration of the quick stop (6085h).
    pub quick_stop: u32,
    /// Behaviour without an order.
    pub at_rest: AtRest,
    /// Increments for one unit of the axis: messages give units.
    pub units: f64,
}

impl DriveBinding {
    /// The binding for a description.
    pub fn of(drive: &Described) -> Self {
        let positive = |value: f64| drive.increments(value).max(1).unsigned_abs();
        let index = drive.index.as_ref().map(|index| DrivePlaces::of(drive, index));
        let positions = match &index {
            Some(places) => places.positions().to_vec(),
            None => drive.targets.iter().map(|target| drive.increments(target.to)).collect(),
        };
        let target = |(target, to): (&DriveTarget, i32)| DriveSetpoint {
            output: target.output,
            to,
            at: target.at,
            velocity: positive(target.velocity),
        };
        let home = |homing: linewright_line::Homing| HomingBinding {
            method: homing.method,
            fast: positive(homing.fast),
            slow: positive(homing.slow),
            acceleration: positive(homing.acceleration),
            offset: drive.increments(homing.offset),
            output: homing.output,
            done: homing.done,
        };
        DriveBinding {
            mode: drive.mode,
            targets: drive.targets.iter().zip(positions).map(target).collect(),
            index,
            fault: drive.fault,
            home: drive.homing.map(home),
            window: positive(drive.window),
            velocity: positive(drive.velocity),
            acceleration: positive(drive.acceleration),
            quick_stop: positive(drive.quick_stop),
            at_rest: drive.at_rest,
            units: drive.units_per_mm,
        }
    }

    /// Evidence of a drive's process data alone: the inputs of all its targets, and those of them whose target it
    /// stands at. Orders and homing are not considered. `None`: too short.
    pub fn places(&self, payload: Payload) -> Option<(u128, u128)> {
        let actual = i32::from_le_bytes(payload.bytes().get(3..PDO_BYTES)?.try_into().ok()?);
        if let Some(places) = &self.index {
            let all = places.index.report(u16::MAX) | self.targets[0].at.bit();
            return Some((all, places.at(actual).map_or(0, |at| self.place_inputs(at.number, at.is_there))));
        }
        let stands = |target: &&DriveSetpoint| actual.abs_diff(target.to) <= self.window;
        let image = |image, target: &DriveSetpoint| image | target.at.bit();
        Some((self.targets.iter().fold(0, image), self.targets.iter().filter(stands).fold(0, image)))
    }

    /// The inputs of an endless axis that is at a place, or has left it last.
    pub(super) fn place_inputs(&self, number: u16, is_there: bool) -> u128 {
        let in_place = self.targets.first().filter(|_| is_there).map_or(0, |target| target.at.bit());
        self.index.as_ref().map_or(0, |places| places.index.report(number)) | in_place
    }

    /// The mode of operation its targets want.
    pub(super) fn profile(&self) -> i8 {
        match self.mode {
            DriveMode::Position => word::PROFILE_POSITION,
            DriveMode::Velocity => word::PROFILE_VELOCITY,
        }
    }
}

/// Demand of an image on a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DriveDemand {
    /// None of its outputs is on.
    Nothing,
    /// Go to a target, by its place in the binding.
    Target(usize),
    /// Find the zero.
    Home,
    /// Find the zero, if it is not known.
    HomeIfLost,
    /// These two outputs are on, and perhaps more.
    Several(OutputId, OutputId),
}

impl DriveBinding {
    /// Demand of `image`. An output that is a target's and starts the homing counts as the target's.
    pub(super) fn wanted(&self, image: u128) -> DriveDemand {
        if let Some(places) = &self.index {
            let turns = self.targets.first().is_some_and(|target| image & target.output.bit() != 0);
            return match usize::from(places.index.ordered(image)).checked_sub(1) {
                _ if !turns => DriveDemand::Nothing,
                // To no place: what is homed has nothing to do.
                None => DriveDemand::HomeIfLost,
                Some(at) if at < self.targets.len() => DriveDemand::Target(at),
                Some(_) => DriveDemand::Nothing,
            };
        }
        let targets = self.targets.iter().enumerate().map(|(at, target)| (target.output, DriveDemand::Target(at)));
        let home = self.home.iter().map(|home| (home.output, DriveDemand::Home));
        let mut first: Option<(OutputId, DriveDemand)> = None;
        for (output, wanted) in targets.chain(home).filter(|(output, _)| image & output.bit() != 0) {
            match first {
                None => first = Some((output, wanted)),
                Some((other, _)) if other == output => {}
                Some((other, _)) => return DriveDemand::Several(other, output),
            }
        }
        first.map_or(DriveDemand::Nothing, |(_, wanted)| wanted)
    }
}
