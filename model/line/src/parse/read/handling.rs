//! Holders, what reaches them, and sensors.

use linewright_text::{Fields, Report};

use super::{AXES_MAX, PLACES_MAX, SIGNS_MAX};
use crate::PARAMETER_BITS_MAX;
use crate::parse::raw::{RawHolder, RawReach, RawSensor, RawSign, RawStand};

use super::line::each;

/// One that belongs to no station.
pub(super) fn store(mut f: Fields<'_>, report: &mut Report) -> RawHolder {
    let raw = RawHolder {
        at: f.at.clone(),
        name: f.required_text(report, "name"),
        places: f.whole(report, "places", 1, PLACES_MAX),
        is_hand: false,
        closes: None,
    };
    f.finish(report);
    raw
}

/// One of a station.
pub(super) fn holder(mut f: Fields<'_>, report: &mut Report) -> RawHolder {
    let raw = RawHolder {
        at: f.at.clone(),
        name: f.required_text(report, "name"),
        places: None,
        is_hand: f.word(report, "kind", &[("nest", false), ("hand", true)]),
        closes: f.table(report, "closes", "`closes`").map(|mut f| {
            let raw = stand(&mut f, report);
            f.finish(report);
            raw
        }),
    };
    f.finish(report);
    raw
}

fn stand(f: &mut Fields<'_>, report: &mut Report) -> RawStand {
    RawStand { axis: f.required_text(report, "axis"), position: f.coordinate(report, "at") }
}

pub(super) fn reach(mut f: Fields<'_>, report: &mut Report) -> RawReach {
    let raw = RawReach {
        at: f.at.clone(),
        hand: f.required_text(report, "hand"),
        to: f.required_text(report, "to"),
        when: f
            .required_table(report, "when", "`when`")
            .map(|when| when.coordinates(report, AXES_MAX))
            .unwrap_or_default(),
        position: f.texts(report, "position", PARAMETER_BITS_MAX),
    };
    f.finish(report);
    raw
}

pub(super) fn sensor(mut f: Fields<'_>, report: &mut Report) -> RawSensor {
    let raw = RawSensor {
        at: f.at.clone(),
        station: f.required_text(report, "station"),
        input: f.required_text(report, "input"),
        when: each(f.tables(report, "when", "a condition of a sensor", SIGNS_MAX), report, sign),
    };
    f.finish(report);
    raw
}

fn sign(mut f: Fields<'_>, report: &mut Report) -> RawSign {
    let raw = RawSign {
        at: f.at.clone(),
        part: f.text(report, "part"),
        axis: f.text(report, "axis"),
        position: f.maybe_coordinate(report, "at"),
    };
    f.finish(report);
    raw
}
