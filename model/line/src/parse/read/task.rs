//! What a station does on order: its rests and its tasks.

use linewright_text::{Fields, Report};

use super::AXES_MAX;
use crate::parse::raw::{RawRest, RawTask};
use crate::{PARAMETER_BITS_MAX, PARAMETERS_MAX};

pub(super) fn rest(mut f: Fields<'_>, report: &mut Report) -> RawRest {
    let raw = RawRest {
        at: f.at.clone(),
        name: f.required_text(report, "name"),
        positions: f.table(report, "at", "`at`").map(|at| at.coordinates(report, AXES_MAX)).unwrap_or_default(),
    };
    f.finish(report);
    raw
}

pub(super) fn task(mut f: Fields<'_>, report: &mut Report) -> RawTask {
    let parameters = f.table(report, "parameters", "`parameters`");
    let raw = RawTask {
        at: f.at.clone(),
        name: f.required_text(report, "name"),
        from: f.required_text(report, "from"),
        to: f.required_text(report, "to"),
        limit: f.required_seconds(report, "limit_s"),
        parameters: parameters.map(|f| f.lists(report, PARAMETERS_MAX, PARAMETER_BITS_MAX)).unwrap_or_default(),
    };
    f.finish(report);
    raw
}
