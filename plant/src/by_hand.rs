//! Parts that people take out and put in: what they can do, why not, and its numbers over CAN.

use linewright_line::{Grip, HolderId, Line, StationId};

use crate::fault::{FaultWrite, PUT_INDEX, TAKE_INDEX};
use crate::parts::NestPosition;

/// What a person does with a part at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PartByHand {
    /// It is taken out of the plant.
    Take,
    /// A new one is put in.
    Put,
}

impl PartByHand {
    /// Both.
    pub const ALL: [PartByHand; 2] = [PartByHand::Take, PartByHand::Put];

    /// The write to a simulated device that does it at a place. Only the first 254 holders of a line have an object.
    ///
    /// # Errors
    /// The holder has none.
    pub fn order(self, at: NestPosition) -> Result<FaultWrite, PartRefusal> {
        let sub = u8::try_from(at.nest.index() + 1).ok().filter(|sub| *sub < u8::MAX);
        let index = match self {
            PartByHand::Take => TAKE_INDEX,
            PartByHand::Put => PUT_INDEX,
        };
        Ok(((index, sub.ok_or(PartRefusal::NoSuchSpot)?), u32::from(at.position)))
    }
}

/// Why a part is not put there or taken away by hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartRefusal {
    /// There is no such position, or it is a hand, into which nothing is put.
    NoSuchSpot,
    Occupied,
    /// The clamp is closed, or a hand has the part.
    Held,
    /// The part is in the plant already.
    Known,
    Unknown,
    /// No part is there.
    Empty,
}

impl PartRefusal {
    /// Every one, in the order of their numbers over CAN, from 1.
    pub const ALL: [PartRefusal; 6] = [
        PartRefusal::NoSuchSpot,
        PartRefusal::Occupied,
        PartRefusal::Held,
        PartRefusal::Known,
        PartRefusal::Unknown,
        PartRefusal::Empty,
    ];

    /// Its number in object 5F08h:00.
    pub fn code(self) -> u8 {
        PartRefusal::ALL.iter().zip(1..).find(|(refusal, _)| **refusal == self).map_or(0, |(_, code)| code)
    }

    /// The refusal with a number; none for 0, or a number that none has.
    pub fn from_code(code: u8) -> Option<Self> {
        PartRefusal::ALL.get(usize::from(code.checked_sub(1)?)).copied()
    }
}

/// The station in whose plant a holder has its parts: its own, or for a place of the line one whose hand reaches it. Each bus has a plant
/// of its own.
pub fn station_of(line: &Line, holder: HolderId) -> Option<StationId> {
    let of = line.handling.holder(holder);
    if let Grip::Clamp(stand) | Grip::Hand(stand) = of.grip {
        return Some(stand.station);
    }
    let own = of.name.split_once('.').and_then(|(name, _)| line.station_named(name));
    own.or_else(|| {
        let mut reaches = line.handling.reaches.iter().filter(|reach| reach.to == holder);
        reaches.find_map(|reach| match line.handling.holder(reach.hand).grip {
            Grip::Hand(stand) => Some(stand.station),
            Grip::Loose | Grip::Clamp(_) => None,
        })
    })
}
