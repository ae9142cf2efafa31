//! The `drive` table of a device.

use linewright_text::{
    KeyPresence, Located, LocatedName, coordinate, integer, keys, positive, table, tables, text, texts, word,
};

use crate::{AtRest, DriveMode, TurnDirection};

/// At most this many targets of one drive.
const TARGETS_MAX: usize = 64;
/// At most this many bits of a place's number.
const PLACE_BITS_MAX: usize = 10;

keys! {
    /// A servo or stepper drive (CiA 402) that moves one axis of its station. Lengths are in the axis's unit, mm or degrees.
    pub(in crate::parse) struct RawDrive is "`drive`" {
        /// The axis it moves; nothing else moves it.
        axis: Option<LocatedName> = text().required(),
        /// `"position"`: it goes to its targets; `"velocity"`: the targets are velocities, and the axis turns while its
        /// output is on.
        mode: DriveMode = word(&[("position", DriveMode::Position), ("velocity", DriveMode::Velocity)]),
        /// Increments of the drive for one unit of the axis, above zero.
        units as "units_per_mm": Option<Located<f64>> = positive().required(),
        /// It is at a target within this distance, in mm or degrees, above zero.
        window: Option<Located<f64>> = positive().required(),
        /// How fast it moves, in mm/s or degrees/s, above zero.
        velocity: Option<Located<f64>> = positive().required(),
        /// How fast it gains and loses speed, in mm/s² or degrees/s², above zero.
        acceleration: Option<Located<f64>> = positive().required(),
        /// How fast it loses speed when its output goes off on the way, in mm/s² or degrees/s²; the acceleration if left out.
        quick_stop: Option<Located<f64>> = positive(),
        /// Without an order it stops, and `"off"`: switches its power off; `"hold"`: holds its position.
        at_rest: AtRest = word(&[("off", AtRest::Off), ("hold", AtRest::Hold)]),
        /// Input: on while it has failed or refuses an order.
        fault: Option<LocatedName> = text(),
        /// Where outputs send it, up to 64.
        targets: Vec<RawTarget> = tables(TARGETS_MAX).missed(KeyPresence::Unless(&["index"])),
        /// Instead of `targets`, of an endless axis: how it turns from place to place.
        index: Option<RawDriveIndex> = table(),
        /// How it finds its zero; left out for a drive that knows where it is.
        homing: Option<RawHoming> = table(),
    }

    /// How a drive turns an endless axis from place to place. The places are numbered from 1, the home position, in the order
    /// in which the axis comes to them.
    pub(in crate::parse) struct RawDriveIndex is "`index`" {
        /// The output that turns it.
        output: Option<LocatedName> = text().required(),
        /// The input that is on while it is at one of its places.
        input as "at": Option<LocatedName> = text().required(),
        /// After this way, in mm or degrees, it is where it was: a whole number of indexes, at least two.
        turn: Option<Located<f64>> = positive().required(),
        /// Which way it turns.
        direction: TurnDirection = word(&[("positive", TurnDirection::Positive), ("negative", TurnDirection::Negative)]),
        /// Outputs that say to which place, as a number, the lowest bit first; at most 10.
        to: Vec<LocatedName> = texts(PLACE_BITS_MAX).entries().missed(KeyPresence::Required),
        /// Inputs that say at which place it is, or which it has left last, as a number, the lowest bit first; at most 10.
        place: Vec<LocatedName> = texts(PLACE_BITS_MAX).entries().missed(KeyPresence::Required),
    }

    /// A place to which an output sends the drive.
    pub(in crate::parse) struct RawTarget is "a target" {
        /// The output that sends it there.
        output: Option<LocatedName> = text().required(),
        /// The place on the axis, in mm or degrees.
        to: Option<Located<f64>> = coordinate().required(),
        /// The input that is on while it is there; targets at the same place share it.
        input as "at": Option<LocatedName> = text().required(),
        /// How fast it goes there, in mm/s or degrees/s; the drive's if left out.
        velocity: Option<Located<f64>> = positive(),
    }

    /// How a drive finds its zero.
    pub(in crate::parse) struct RawHoming is "`homing`" {
        /// 1 to 37 as CiA 402 numbers them, or -128 to -1 for the manufacturer's own.
        method: Option<Located<i64>> = integer().required().from_to(-128, 37),
        /// Speed for finding the switch, in mm/s or degrees/s.
        fast: Option<Located<f64>> = positive().required(),
        /// Speed for finding its edge, in mm/s or degrees/s.
        slow: Option<Located<f64>> = positive().required(),
        /// How fast it gains and loses speed meanwhile, in mm/s² or degrees/s²; the drive's if left out.
        acceleration: Option<Located<f64>> = positive(),
        /// Where it is then, in mm or degrees; 0 if left out.
        offset: Option<Located<f64>> = coordinate().usually(0.0),
        /// The output that starts it. If that is a target's output, the drive is homed before it first goes there.
        output: Option<LocatedName> = text().required(),
        /// Input: on while it knows where it is.
        done: Option<LocatedName> = text(),
    }
}
