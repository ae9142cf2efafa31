//! A drive: an axis of a station moved by a CiA 402 drive instead of valves.
//!
//! To a station nothing changes: an output means "go to this target", an input "is there". The conversion belongs to
//! the field bus; this is only the description of it, in the axis's own units.

use crate::{AxisId, InputId, OutputId};

/// Mode of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DriveMode {
    /// Its targets are positions (profile position mode).
    Position,
    /// Its targets are velocities (profile velocity mode): it turns while its output is on.
    Velocity,
}

/// Behaviour of a drive while none of its outputs is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AtRest {
    /// It stops and switches its power off. The axis stays because nothing pushes it, or because a brake holds it.
    Off,
    /// It stops and holds its position under power, for an axis that would sink: also when its manager is gone.
    Hold,
}

/// A drive as the description has it. Lengths in millimetres (or what the axis is measured in), times in seconds.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// The axis it moves.
    pub axis: AxisId,
    /// Kind of its targets.
    pub mode: DriveMode,
    /// Increments of the drive for one unit of the axis, above zero.
    pub units_per_mm: f64,
    /// It is at a target within this distance, at least one increment.
    pub window: f64,
    /// Velocity, unless a target has its own.
    pub velocity: f64,
    /// Acceleration and deceleration.
    pub acceleration: f64,
    /// Deceleration when it is stopped on the way.
    pub quick_stop: f64,
    /// Behaviour without an order.
    pub at_rest: AtRest,
    /// Where it can be sent, at least one. Targets at one place share their input. Of an endless axis its places, in the order
    /// in which it comes to them, the first at the axis's home; they share their output and their input.
    pub targets: Vec<DriveTarget>,
    /// Of an endless axis, how it turns.
    pub index: Option<DriveIndex>,
    /// On while it has failed or refuses to move.
    pub fault: Option<InputId>,
    /// Its homing. `None` for a drive with an absolute position.
    pub homing: Option<Homing>,
}

/// Which way a drive turns an endless axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TurnDirection {
    /// Towards greater positions.
    Positive,
    /// Towards smaller positions.
    Negative,
}

/// How a drive turns an endless axis from place to place. Its places are numbered from 1, and it is sent to a number: an
/// order that comes twice leads to the same place.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveIndex {
    /// Number of places.
    pub places: u16,
    /// After this way it is where it was.
    pub turn: f64,
    pub direction: TurnDirection,
    /// The outputs that say to which place, the lowest bit first. 0: to none; it is homed, if it has to be.
    pub to: Vec<OutputId>,
    /// The inputs that say at which place it is, or which it has left last, the lowest bit first. 0: it does not know.
    pub place: Vec<InputId>,
}

impl DriveIndex {
    /// The outputs that are on in an order to a place.
    pub fn order(&self, place: u16) -> u128 {
        bits(self.to.iter().map(|output| output.bit()), place)
    }

    /// The place to which an output image sends it; 0 for none.
    pub fn ordered(&self, outputs: u128) -> u16 {
        number(self.to.iter().map(|output| output.bit()), outputs)
    }

    /// The inputs that are on at a place.
    pub fn report(&self, place: u16) -> u128 {
        bits(self.place.iter().map(|input| input.bit()), place)
    }

    /// The place that an input image tells; 0 for none.
    pub fn reported(&self, inputs: u128) -> u16 {
        number(self.place.iter().map(|input| input.bit()), inputs)
    }

    /// The place after this one.
    pub fn next(&self, place: u16) -> u16 {
        place % self.places + 1
    }

    /// 1 or -1.
    pub fn sign(&self) -> f64 {
        match self.direction {
            TurnDirection::Positive => 1.0,
            TurnDirection::Negative => -1.0,
        }
    }
}

/// The outputs of an order to a place: one that turns the axis, and a number, which is an order as a whole only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NumberedOrder {
    /// The output that turns it.
    turn: u128,
    /// All outputs of the number.
    number: u128,
}

impl NumberedOrder {
    /// Those of a drive that is sent to places by number.
    pub fn of(drive: &Drive) -> Option<Self> {
        let number = drive.index.as_ref()?.order(u16::MAX);
        Some(NumberedOrder { turn: drive.targets.first()?.output.bit(), number })
    }

    /// What stays on of an output image until another one follows: the outputs that are on in both. Of two numbers these
    /// would be a third one, to which nothing is sent: where a number changes, its axis is not turned in between.
    pub fn staying(orders: &[Self], before: u128, after: u128) -> u128 {
        let changed = orders.iter().filter(|order| (before ^ after) & order.number != 0);
        changed.fold(before & after, |image, order| image & !order.turn)
    }
}

/// The image in which a number's bits lie here, the lowest first.
fn bits(places: impl Iterator<Item = u128>, number: u16) -> u128 {
    let on = places.enumerate().filter(|(nth, _)| number >> nth & 1 == 1);
    on.fold(0, |image, (_, bit)| image | bit)
}

/// The number whose bits lie here in an image, the lowest first.
fn number(bits: impl Iterator<Item = u128>, image: u128) -> u16 {
    bits.enumerate().fold(0, |number, (nth, bit)| number | u16::from(image & bit != 0) << nth)
}

/// One place a drive can be sent to, or one velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveTarget {
    /// The output that sends it there.
    pub output: OutputId,
    /// The place, or the velocity.
    pub to: f64,
    /// The input that is on while it is there.
    pub at: InputId,
    /// Velocity of the motion there.
    pub velocity: f64,
}

/// Homing of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homing {
    /// The method's number (CiA 402, object 6098h).
    pub method: i8,
    /// Velocity of the search for the switch.
    pub fast: f64,
    /// Velocity of the search for the switch's edge.
    pub slow: f64,
    /// Acceleration and deceleration meanwhile.
    pub acceleration: f64,
    /// Position at its end.
    pub offset: f64,
    /// The output that starts it. If it is a target's output, the drive is homed before it first goes there.
    pub output: OutputId,
    /// The input that is on while its position is valid.
    pub done: Option<InputId>,
}

impl Drive {
    /// A place, distance, speed or acceleration of the axis in the drive's increments, rounded; at the ends of the
    /// drive's range where it is beyond them, which the parser lets nothing be.
    pub fn increments(&self, value: f64) -> i32 {
        (value * self.units_per_mm).round() as i32
    }

    /// Value of a number of increments in the axis's unit.
    pub fn units(&self, increments: f64) -> f64 {
        increments / self.units_per_mm
    }

    /// Every input of its station that it drives, in the order of the description; one that several targets share,
    /// several times.
    pub fn inputs(&self) -> impl Iterator<Item = InputId> {
        let done = self.homing.and_then(|homing| homing.done);
        let place = self.index.iter().flat_map(|index| index.place.iter().copied());
        self.targets.iter().map(|target| target.at).chain(self.fault).chain(done).chain(place)
    }

    /// Every output of its station that it obeys; one that starts the homing as well, twice.
    pub fn outputs(&self) -> impl Iterator<Item = OutputId> {
        self.motions().chain(self.index.iter().flat_map(|index| index.to.iter().copied()))
    }

    /// The outputs that move it, one for each of its motions: to each of its targets, on by an index, and its homing.
    pub fn motions(&self) -> impl Iterator<Item = OutputId> {
        let targets = if self.index.is_some() { &self.targets[..1] } else { &self.targets[..] };
        targets.iter().map(|target| target.output).chain(self.homing.map(|homing| homing.output))
    }

    /// The shortest time it takes from standstill to standstill over a distance, in seconds.
    pub fn time_for(&self, distance: f64, velocity: f64) -> f64 {
        trapezoid_time(distance, velocity, self.acceleration)
    }
}

/// From standstill to standstill over `distance` with at most `velocity` and `acceleration`.
pub(crate) fn trapezoid_time(distance: f64, velocity: f64, acceleration: f64) -> f64 {
    let distance = distance.abs();
    if distance * acceleration >= velocity * velocity {
        distance / velocity + velocity / acceleration
    } else {
        2.0 * (distance / acceleration).sqrt()
    }
}
