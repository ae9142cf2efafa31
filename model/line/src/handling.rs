//! Places of parts, and what moves them: for the simulated plant alone.
//!
//! A *nest* is where a part can lie: a clamp, a bench, a position of a store. A *hand* has a part only while it is closed.
//! A hand *reaches* a nest while the axes of its station stand in certain positions; then it can take the part that lies
//! there, or put one down. A *sensor* is an input that is on while parts and axes, also those of other stations, are as
//! described: what a light barrier or an inductive switch sees.
//!
//! No controller uses any of this. It is what a controller cannot detect: that the hand has closed on nothing.

use linewright_text::index_id;

use crate::{AxisId, InputId, OutputId, StationId};

index_id! {
    /// Something that can have parts, by its place in [`MaterialFlow::holders`].
    HolderId
}

/// Places of parts, what moves them, and what sees them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialFlow {
    /// Nests and hands.
    pub holders: Vec<Holder>,
    /// Hands, and the nests that they can take from and put down in.
    pub reaches: Vec<Reach>,
    /// Inputs that see parts.
    pub sensors: Vec<Sensor>,
}

/// A nest or a hand.
#[derive(Clone, Debug, PartialEq)]
pub struct Holder {
    /// Its name; that of a station's with the station's before it, as in `robot.hand`.
    pub name: String,
    /// Number of parts it has room for, each at a position of its own, from 1. A hand has one.
    pub places: u16,
    /// Its effect on them.
    pub grip: Grip,
}

/// Effect of a holder on a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Grip {
    /// A nest in which parts lie loose.
    Loose,
    /// A nest that holds its part fast while this axis stands here.
    Clamp(Stand),
    /// A hand: it has a part while this axis stands here, and releases it otherwise.
    Hand(Stand),
}

/// An axis, and where it stands: one of the ends of its motions, in millimetres or degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stand {
    /// Station of the axis.
    pub station: StationId,
    pub axis: AxisId,
    /// End position, in the unit of the axis.
    pub at: f64,
}

/// Condition under which a hand can take from a nest, and put down in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Reach {
    pub hand: HolderId,
    /// The nest.
    pub to: HolderId,
    /// All of these stand so.
    pub when: Vec<Stand>,
    /// Outputs of the hand's station that give the position, a number with the lowest bit first. Their state when the
    /// axes came there counts until they leave. Empty where the nest has one position.
    pub position: Vec<OutputId>,
}

/// An input that is on while something is so.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// Station of the input.
    pub station: StationId,
    /// Input of the process image.
    pub input: InputId,
    /// All of this is so.
    pub when: Vec<Sign>,
}

/// Objects of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sign {
    /// There is a part in this holder.
    Part(HolderId),
    /// An axis stands somewhere.
    Stands(Stand),
}

impl MaterialFlow {
    /// The holder of this name.
    pub fn holder_named(&self, name: &str) -> Option<HolderId> {
        self.holders.iter().position(|holder| holder.name == name).map(HolderId::at)
    }

    pub fn holder(&self, id: HolderId) -> &Holder {
        &self.holders[id.index()]
    }

    /// Whether parts play no role.
    pub fn is_empty(&self) -> bool {
        self.holders.is_empty() && self.sensors.is_empty()
    }
}

impl Holder {
    /// Whether it is a hand.
    pub fn is_hand(&self) -> bool {
        match self.grip {
            Grip::Hand(_) => true,
            Grip::Loose | Grip::Clamp(_) => false,
        }
    }
}
