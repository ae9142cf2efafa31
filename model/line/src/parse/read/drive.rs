//! The `drive` table of a device.

use linewright_text::{Fields, Report};

use super::TARGETS_MAX;
use super::line::each;
use crate::parse::raw::{RawDrive, RawHoming, RawTarget};
use crate::{AtRest, DriveMode};

pub(super) fn drive(mut f: Fields<'_>, report: &mut Report) -> RawDrive {
    let modes = [("position", DriveMode::Position), ("velocity", DriveMode::Velocity)];
    let raw = RawDrive {
        at: f.at.clone(),
        axis: f.required_text(report, "axis"),
        mode: f.word(report, "mode", &modes),
        units: f.required_positive(report, "units_per_mm"),
        window: f.required_positive(report, "window"),
        velocity: f.required_positive(report, "velocity"),
        acceleration: f.required_positive(report, "acceleration"),
        quick_stop: f.positive(report, "quick_stop"),
        at_rest: f.word(report, "at_rest", &[("off", AtRest::Off), ("hold", AtRest::Hold)]),
        fault: f.text(report, "fault"),
        targets: each(f.tables(report, "targets", "a target", TARGETS_MAX), report, target),
        homing: f.table(report, "homing", "`homing`").map(|f| homing(f, report)),
    };
    f.finish(report);
    raw
}

fn target(mut f: Fields<'_>, report: &mut Report) -> RawTarget {
    let raw = RawTarget {
        at: f.at.clone(),
        output: f.required_text(report, "output"),
        to: f.coordinate(report, "to"),
        input: f.required_text(report, "at"),
        velocity: f.positive(report, "velocity"),
    };
    f.finish(report);
    raw
}

fn homing(mut f: Fields<'_>, report: &mut Report) -> RawHoming {
    let raw = RawHoming {
        method: f.required_integer(report, "method"),
        fast: f.required_positive(report, "fast"),
        slow: f.required_positive(report, "slow"),
        acceleration: f.positive(report, "acceleration"),
        offset: f.maybe_coordinate(report, "offset"),
        output: f.required_text(report, "output"),
        done: f.text(report, "done"),
    };
    f.finish(report);
    raw
}
