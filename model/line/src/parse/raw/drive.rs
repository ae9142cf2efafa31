//! The `drive` table of a device.

use linewright_text::{
    KeyPresence, Located, LocatedName, coordinate, integer, keys, positive, table, tables, text, word,
};

use crate::{AtRest, DriveMode};

/// At most this many targets of one drive.
const TARGETS_MAX: usize = 64;

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
        targets: Vec<RawTarget> = tables(TARGETS_MAX).missed(KeyPresence::Required),
        /// How it finds its zero; left out for a drive that knows where it is.
        homing: Option<RawHoming> = table(),
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
