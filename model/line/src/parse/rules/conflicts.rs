//! Conflicts: pairs of states that must never hold together.

use linewright_text::{Problem, Report};

use crate::OpId;
use crate::parse::draft::DraftLine;

pub(super) fn conflicts_join_stations(draft: &DraftLine<'_>, report: &mut Report) {
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

/// Operations side by side start and end each in its own time, so a stretch from one to another of them is none.
pub(super) fn conflict_spans_have_an_order(draft: &DraftLine<'_>, report: &mut Report) {
    for span in draft.conflicts.iter().flat_map(|conflict| [&conflict.a, &conflict.b]).flatten() {
        let station = &draft.stations[span.value.station.index()];
        let (from, until) = (span.value.from, span.value.until);
        if from != until && station.step_of(from) == station.step_of(until) {
            report.add(
                Problem::error(span.at.clone(), "`from` and `until` run side by side")
                    .hint("name one of them as both ends, or the operations before and after the group"),
            );
        }
    }
}

/// One held button runs every operation that names it: in two states that exclude each other it starts both.
pub(super) fn conflicts_have_buttons_of_their_own(draft: &DraftLine<'_>, report: &mut Report) {
    let begins = |span: crate::StateSpan| {
        let operation = draft.stations[span.station.index()].operation(span.from);
        let hand = operation.raw.hand.as_ref()?;
        Some((operation, hand.forward.as_ref()?))
    };
    for conflict in &draft.conflicts {
        let (Some(a), Some(b)) = (&conflict.a, &conflict.b) else { continue };
        let (Some((one, here)), Some((other, there))) = (begins(a.value), begins(b.value)) else { continue };
        if a.value.station != b.value.station && here.value == there.value {
            let message =
                format!("button `{}` starts `{}` and `{}`, which exclude each other", here.value, one.name, other.name);
            report.add(
                Problem::warning(there.at.clone(), message)
                    .also(&here.at, "the other one")
                    .also(&conflict.at, "excluded here")
                    .hint("in hand mode it runs whichever may start: give each a button of its own"),
            );
        }
    }
}

/// Whether the station is inside the stretch while it stands at home: its home operation is in it, and the end of the
/// stretch is still to come.
fn holds_at_home(draft: &DraftLine<'_>, span: crate::StateSpan) -> Option<bool> {
    let station = &draft.stations[span.station.index()];
    let home = station.home.as_ref()?.value;
    let count = station.steps.len().max(1);
    let after_from = |op: OpId| (station.step_of(op) + count - station.step_of(span.from)) % count;
    Some(after_from(home) < after_from(span.until))
}

pub(super) fn conflicts_do_not_hold_at_home(draft: &DraftLine<'_>, report: &mut Report) {
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
