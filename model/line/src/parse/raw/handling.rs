//! Holders, what reaches them, and sensors: for the simulated plant alone.

use linewright_text::{
    KeyPresence, Located, LocatedName, Report, coordinate, coordinates, keys, nothing, table, tables, text, texts,
    whole, word,
};

use super::station::AXES_MAX;
use crate::PARAMETER_BITS_MAX;

/// At most this many positions in one store.
const PLACES_MAX: i64 = 10_000;
/// At most this many conditions for one sensor.
const SIGNS_MAX: usize = 16;

keys! {
    /// A place for parts that belongs to no station.
    pub(super) struct RawStore is "a holder" {
        /// Name: one word without a full stop.
        name: Option<LocatedName> = text().required(),
        /// Number of positions, 1 to 10000, each for one part and numbered from 1.
        places: Option<Located<i64>> = whole(1, PLACES_MAX).usually(1),
    }

    /// A place for parts in a station: a nest, where a part can lie, or a gripper.
    pub(in crate::parse) struct RawHolder is "a holder" {
        /// Name: one word without a full stop; outside of the station the holder is called `station.name`.
        name: Option<LocatedName> = text().required(),
        /// Of a holder of no station.
        places: Option<Located<i64>> = nothing(),
        /// Kind. `"hand"`: a gripper, which has a part only while it is closed; `"nest"`: parts lie in it.
        is_hand as "kind": bool = word(&[("nest", false), ("hand", true)]),
        /// Position of an axis of the station at which it is closed: `{ axis, at }`. Required for a gripper; a nest
        /// with it is a clamp.
        closes: Option<RawStand> = table(),
    }

    /// Position of an axis.
    pub(in crate::parse) struct RawStand is "`closes`" {
        /// The axis.
        axis: Option<LocatedName> = text().required(),
        /// Position, in mm or degrees.
        position as "at": Option<Located<f64>> = coordinate().required(),
    }

    /// A nest that a gripper of the station reaches.
    pub(in crate::parse) struct RawReach is "a reach" {
        /// Gripper of this station.
        hand: Option<LocatedName> = text().required(),
        /// The nest: `"ST"`, or `"m1.clamp"` of a station.
        to: Option<LocatedName> = text().required(),
        /// Positions of axes of the station at which it reaches the nest, in mm or degrees: `{ arm = 100 }`.
        when: Vec<(LocatedName, f64)> = coordinates(AXES_MAX).required().or_default(),
        /// Outputs of the station with the number of the position, the lowest bit first, of a nest with `places`.
        position: Option<Located<Vec<LocatedName>>> = texts(PARAMETER_BITS_MAX),
    }

    /// An input that reports parts.
    pub(in crate::parse) struct RawSensor is "a sensor" {
        /// The station whose input it is.
        station: Option<LocatedName> = text().required(),
        /// Input; not one of a mechanism of the station.
        input: Option<LocatedName> = text().required(),
        /// Conditions that all hold while the input is on, at most 16: `{ part = "robot.hand" }`, `{ axis =
        /// "robot.arm", at = 100 }`.
        when: Vec<RawSign> = tables(SIGNS_MAX).missed(KeyPresence::Required),
    }

    /// A condition of a sensor: a part in a holder, or an axis that stands somewhere.
    pub(in crate::parse) struct RawSign is "a condition of a sensor" {
        /// Holder in which there is a part.
        part: Option<LocatedName> = text(),
        /// The axis, `"station.axis"`.
        axis: Option<LocatedName> = text(),
        /// Position of the axis, in mm or degrees.
        position as "at": Option<Located<f64>> = coordinate(),
    }
}

/// Stores as holders that neither grip nor close.
pub(super) fn stores(stores: Vec<RawStore>, _: &mut Report) -> Vec<RawHolder> {
    let holder = |RawStore { at, name, places }| RawHolder { at, name, places, is_hand: false, closes: None };
    stores.into_iter().map(holder).collect()
}
