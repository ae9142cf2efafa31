//! Conflicts: pairs of states that must never hold together.

use crate::OpId;
use crate::parse::draft::Draft;
use crate::parse::problem::{Problem, Report};

pub(super) fn conflicts_join_stations(draft: &Draft<'_>, report: &mut Report) {
    for conflict in &draft.conflicts {
        let (Some(a), Some(b)) = (&conflict.a, &conflict.b) else { continue };
        if a.value.station == b.value.station {
            report.add(
                Problem::error(b.at.clone(), "a conflict of a station with itself")
                    .also(&a.at, "the same station")
                    .hint("a station does one thing after the other: name two stations"),
            );
        }
    }
}

/// Whether the station is inside the stretch while it stands at home: its home operation lies in it, and the end of
/// the stretch is still to come.
fn holds_at_home(draft: &Draft<'_>, span: crate::Span) -> Option<bool> {
    let station = &draft.stations[span.station.index()];
    let home = station.home.as_ref()?.value;
    let count = station.steps.len().max(1);
    let after_from = |op: OpId| (station.step_of(op) + count - station.step_of(span.from)) % count;
    Some(after_from(home) < after_from(span.until))
}

pub(super) fn conflicts_do_not_hold_at_home(draft: &Draft<'_>, report: &mut Report) {
    for conflict in &draft.conflicts {
        let (Some(a), Some(b)) = (&conflict.a, &conflict.b) else { continue };
        if a.value.station == b.value.station {
            continue;
        }
        if holds_at_home(draft, a.value) == Some(true) && holds_at_home(draft, b.value) == Some(true) {
            report.add(
                Problem::error(conflict.at.clone(), "this conflict holds while the whole line stands at home")
                    .also(&a.at, "holds at home")
                    .also(&b.at, "holds at home")
                    .hint("a state lasts from the start of `from` to the completion of `until`"),
            );
        }
    }
}
