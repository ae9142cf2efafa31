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
        /// One word without a full stop.
        name: Option<LocatedName> = text().required(),
        /// For how many parts there is room, each at a position of its own, from 1; 1 to 10000.
        places: Option<Located<i64>> = whole(1, PLACES_MAX).usually(1),
    }

    /// A place for parts in a station: a nest, where a part can lie, or a hand.
    pub(in crate::parse) struct RawHolder is "a holder" {
        /// One word without a full stop; elsewhere the holder is called `station.name`.
        name: Option<LocatedName> = text().required(),
        /// Of a holder of no station.
        places: Option<Located<i64>> = nothing(),
        /// `"hand"`: it has a part only while it is closed; `"nest"`: parts lie in it.
        is_hand as "kind": bool = word(&[("nest", false), ("hand", true)]),
        /// Closed while this axis of the station stands there: `{ axis, at }`. A hand needs it; a nest that closes is a
        /// clamp.
        closes: Option<RawStand> = table(),
    }

    /// Where an axis stands.
    pub(in crate::parse) struct RawStand is "`closes`" {
        /// The axis.
        axis: Option<LocatedName> = text().required(),
        /// Where it stands, in mm or degrees.
        position as "at": Option<Located<f64>> = coordinate().required(),
    }

    /// A nest that a hand of the station reaches.
    pub(in crate::parse) struct RawReach is "a reach" {
        /// A hand of this station.
        hand: Option<LocatedName> = text().required(),
        /// The nest: `"ST"`, or `"m1.clamp"` of a station.
        to: Option<LocatedName> = text().required(),
        /// Axes of the station and where they stand then, in mm or degrees: `{ arm = 100 }`.
        when: Vec<(LocatedName, f64)> = coordinates(AXES_MAX).required().or_default(),
        /// Of a nest with `places`: outputs of the station, the lowest bit first, that say at which position.
        position: Option<Located<Vec<LocatedName>>> = texts(PARAMETER_BITS_MAX),
    }

    /// An input that sees parts.
    pub(in crate::parse) struct RawSensor is "a sensor" {
        /// The station whose input it is.
        station: Option<LocatedName> = text().required(),
        /// The input, which no mechanism of the station presses.
        input: Option<LocatedName> = text().required(),
        /// On while all of this is so, at most 16: `{ part = "robot.hand" }`, `{ axis = "robot.arm", at = 100 }`.
        when: Vec<RawSign> = tables(SIGNS_MAX).missed(KeyPresence::Required),
    }

    /// A condition of a sensor: a part in a holder, or an axis that stands somewhere.
    pub(in crate::parse) struct RawSign is "a condition of a sensor" {
        /// The holder in which there is a part.
        part: Option<LocatedName> = text(),
        /// The axis, `"station.axis"`.
        axis: Option<LocatedName> = text(),
        /// Where the axis stands, in mm or degrees.
        position as "at": Option<Located<f64>> = coordinate(),
    }
}

/// Stores as holders that neither grip nor close.
pub(super) fn stores(stores: Vec<RawStore>, _: &mut Report) -> Vec<RawHolder> {
    let holder = |RawStore { at, name, places }| RawHolder { at, name, places, is_hand: false, closes: None };
    stores.into_iter().map(holder).collect()
}
