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
        /// Axis that the drive moves; no other output moves it.
        axis: Option<LocatedName> = text().required(),
        /// Mode of operation. `"position"`: the drive goes to its targets; `"velocity"`: targets are velocities, and
        /// the axis turns while an output is on.
        mode: DriveMode = word(&[("position", DriveMode::Position), ("velocity", DriveMode::Velocity)]),
        /// Increments of the drive for one unit of the axis, above zero.
        units as "units_per_mm": Option<Located<f64>> = positive().required(),
        /// Distance within which it is at a target, in mm or degrees, above zero.
        window: Option<Located<f64>> = positive().required(),
        /// Velocity, in mm/s or degrees/s, above zero.
        velocity: Option<Located<f64>> = positive().required(),
        /// Acceleration and deceleration, in mm/s² or degrees/s², above zero.
        acceleration: Option<Located<f64>> = positive().required(),
        /// Deceleration when its output goes off on the way, in mm/s² or degrees/s²; the acceleration if left out.
        quick_stop: Option<Located<f64>> = positive(),
        /// Behaviour while no output is on. It stops, and `"off"`: switches its power off; `"hold"`: holds its
        /// position.
        at_rest: AtRest = word(&[("off", AtRest::Off), ("hold", AtRest::Hold)]),
        /// Input: on while the drive has a fault or refuses an order.
        fault: Option<LocatedName> = text(),
        /// Targets, each with the output that sends the drive there; at most 64.
        targets: Vec<RawTarget> = tables(TARGETS_MAX).missed(KeyPresence::Unless(&["index"])),
        /// Motion of an endless axis from place to place, instead of `targets`.
        index: Option<RawDriveIndex> = table(),
        /// Homing; left out for a drive with an absolute encoder.
        homing: Option<RawHoming> = table(),
    }

    /// How a drive turns an endless axis from place to place. The places are numbered from 1, the home position, in the order
    /// in which the axis comes to them.
    pub(in crate::parse) struct RawDriveIndex is "`index`" {
        /// Output that turns the axis.
        output: Option<LocatedName> = text().required(),
        /// Input that is on while the axis is at one of its places.
        input as "at": Option<LocatedName> = text().required(),
        /// Length of one whole turn, in mm or degrees: a whole number of indexes, at least two.
        turn: Option<Located<f64>> = positive().required(),
        /// Direction in which it turns.
        direction: TurnDirection = word(&[("positive", TurnDirection::Positive), ("negative", TurnDirection::Negative)]),
        /// Outputs with the number of the place to go to, the lowest bit first; at most 10.
        to: Vec<LocatedName> = texts(PLACE_BITS_MAX).entries().missed(KeyPresence::Required),
        /// Inputs with the number of the place it is at, or has left last, the lowest bit first; at most 10.
        place: Vec<LocatedName> = texts(PLACE_BITS_MAX).entries().missed(KeyPresence::Required),
    }

    /// A place to which an output sends the drive.
    pub(in crate::parse) struct RawTarget is "a target" {
        /// Output that sends the drive there.
        output: Option<LocatedName> = text().required(),
        /// Position on the axis, in mm or degrees.
        to: Option<Located<f64>> = coordinate().required(),
        /// Input that is on while the drive is there; targets at the same position share it.
        input as "at": Option<LocatedName> = text().required(),
        /// Velocity on the way there, in mm/s or degrees/s; that of the drive if left out.
        velocity: Option<Located<f64>> = positive(),
    }

    /// Homing of a drive.
    pub(in crate::parse) struct RawHoming is "`homing`" {
        /// Homing method: 1 to 37 by CiA 402, or -128 to -1 for one of the manufacturer.
        method: Option<Located<i64>> = integer().required().from_to(-128, 37),
        /// Speed of the search for the switch, in mm/s or degrees/s.
        fast: Option<Located<f64>> = positive().required(),
        /// Speed of the search for the switch's edge, in mm/s or degrees/s.
        slow: Option<Located<f64>> = positive().required(),
        /// Acceleration while homing, in mm/s² or degrees/s²; that of the drive if left out.
        acceleration: Option<Located<f64>> = positive(),
        /// Position after homing, in mm or degrees.
        offset: Option<Located<f64>> = coordinate().usually(0.0),
        /// Output that starts homing. If it is a target's output, the drive is homed before it first goes there.
        output: Option<LocatedName> = text().required(),
        /// Input: on while the drive is homed.
        done: Option<LocatedName> = text(),
    }
}
