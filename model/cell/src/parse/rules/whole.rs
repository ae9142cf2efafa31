//! The cell as a whole.

use linewright_text::{Problem, Report};

use crate::parse::draft::DraftCell;
use crate::{ActivityKind, Prototype};

pub(super) fn the_line_is_the_same(draft: &DraftCell<'_>, report: &mut Report) {
    let (Some(line), Some(name)) = (draft.line, &draft.raw.name) else { return };
    if line.name != name.value {
        report.add(
            Problem::error(name.at.clone(), format!("the cell is called `{}`, its line `{}`", name.value, line.name))
                .hint("both descriptions of one directory have the same name"),
        );
    }
}

pub(super) fn cell_has_resources(draft: &DraftCell<'_>, report: &mut Report) {
    if draft.resources.is_empty() {
        report.add(Problem::error(0..0, "a cell needs at least one resource").hint("begin one with `[[resource]]`"));
    }
}

pub(super) fn cell_has_parts(draft: &DraftCell<'_>, report: &mut Report) {
    if draft.parts.is_empty() {
        report.add(Problem::error(0..0, "a cell needs at least one part type").hint("begin one with `[[part]]`"));
    }
}

pub(super) fn parts_come_and_go(draft: &DraftCell<'_>, report: &mut Report) {
    let at = draft.raw.cell.as_ref().map_or(0..0, |cell| cell.at.clone());
    let missing = |kind| !draft.activities.iter().any(|activity| activity.kind == kind || !activity.is_whole);
    for (kind, what, action) in
        [(ActivityKind::Enter, "comes into", "outside.in"), (ActivityKind::Leave, "leaves", "outside.out")]
    {
        if missing(kind) {
            report.add(
                Problem::error(at.clone(), format!("no part ever {what} this cell"))
                    .hint(format!("a `[[sync]]` with \"{action}\" among its actions")),
            );
        }
    }
}

/// More parts than the stores hold can leave no room to unload into, even if every grasp is reserved.
pub(super) fn stores_hold_what_is_let_in(draft: &DraftCell<'_>, report: &mut Report) {
    let Some(wip_max) = draft.raw.cell.as_ref().and_then(|cell| cell.wip_max.as_ref()) else { return };
    let mut stores = draft.resources.iter().filter(|resource| resource.prototype.is_some_and(Prototype::stores));
    let Some(first) = stores.next() else { return };
    let stores = std::iter::once(first).chain(stores);
    let Some(room) = stores.map(|store| store.capacity.map(i64::from)).sum::<Option<i64>>() else { return };
    if wip_max.value > room {
        report.add(
            Problem::warning(wip_max.at.clone(), format!("{} parts at once, and stores for {room}", wip_max.value))
                .label("it may get stuck")
                .hint(format!("with all stores full nothing can be unloaded; at most {room} is safe from that")),
        );
    }
}
