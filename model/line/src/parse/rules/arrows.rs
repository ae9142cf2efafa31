//! The causal arrows, one by one.

use std::collections::HashMap;

use linewright_text::{Problem, Report};

use crate::OpId;
use crate::parse::draft::{DraftLine, DraftStation};

pub(super) fn arrows_join_stations(draft: &DraftLine<'_>, report: &mut Report) {
    for arrow in &draft.arrows {
        let (Some(from), Some(to)) = (&arrow.from, &arrow.to) else { continue };
        if from.value.0 != to.value.0 {
            continue;
        }
        let problem = if from.value == to.value {
            Problem::error(to.at.clone(), format!("`{}` waits for itself", draft.full_name(to.value)))
        } else {
            Problem::error(to.at.clone(), "an arrow within one station")
        };
        report.add(
            problem
                .also(&from.at, "from here")
                .hint("the order of a station's own operations is the order in which they are listed"),
        );
    }
}

pub(super) fn arrows_are_unique(draft: &DraftLine<'_>, report: &mut Report) {
    let mut seen: HashMap<_, Vec<&crate::parse::draft::DraftArrow>> = HashMap::new();
    for arrow in &draft.arrows {
        let (Some(from), Some(to)) = (&arrow.from, &arrow.to) else { continue };
        let same = seen.entry((from.value, to.value)).or_default();
        if let Some(earlier) = same.iter().find(|e| (e.auto && arrow.auto) || (e.manual && arrow.manual)) {
            report.add(
                Problem::error(from.at.start..from.at.end, "this arrow has been drawn before")
                    .label("again")
                    .also(&earlier.at, "first here")
                    .hint("one arrow for both modes is enough; two may differ in lag if they differ in mode"),
            );
        }
        same.push(arrow);
    }
}

/// Whether an operation counts cycle 1 while the station, which has never moved, stands at home.
///
/// The same as [`crate::Station::home_count`] at [`crate::Station::initial_round`].
fn counts_at_home(station: &DraftStation<'_>, op: OpId) -> Option<u32> {
    let home = station.home.as_ref()?.value;
    let is_last = home.index() + 1 == station.operations.len();
    Some(u32::from(!is_last && op <= home))
}

/// A line that has never moved stands at home: what counts as done there must not have needed what does not.
pub(super) fn arrows_hold_at_home(draft: &DraftLine<'_>, report: &mut Report) {
    for arrow in &draft.arrows {
        let (Some(from), Some(to)) = (&arrow.from, &arrow.to) else { continue };
        if from.value.0 == to.value.0 {
            continue;
        }
        let count = |(station, op): (crate::StationId, OpId)| counts_at_home(&draft.stations[station.index()], op);
        let (Some(cause), Some(effect)) = (count(from.value), count(to.value)) else { continue };
        if effect == 1 && cause + arrow.lag < 1 {
            let (from_name, to_name) = (draft.full_name(from.value), draft.full_name(to.value));
            report.add(
                Problem::error(from.at.clone(), format!("at home `{to_name}` is done, but `{from_name}` is not"))
                    .label("not done in the cycle that begins at home")
                    .also(&to.at, "done at home")
                    .hint("the arrow may be the wrong way round, or be meant with lag = 1, or the home operation be another"),
            );
        }
    }
}
