//! Synchronisations: one part, from one place to another.

use linewright_text::{Located, Problem, Report};

use crate::parse::draft::{DraftActivity, DraftCell};
use crate::{ActivityKind, Role, Use};

fn words(draft: &DraftCell<'_>, part: &Located<Use>) -> String {
    format!("`{}.{}`", draft.holder(part.value.of), part.value.action.name())
}

pub(super) fn one_part_is_moved(draft: &DraftCell<'_>, activity: &DraftActivity<'_>, report: &mut Report) {
    if activity.kind == ActivityKind::Process {
        return;
    }
    let name = &activity.name;
    for working in activity.used(Role::Worker) {
        report.add(
            Problem::error(working.at.clone(), format!("{} in synchronisation `{name}`", words(draft, working)))
                .hint("a machine works for itself; its orders are written under `[[action]]`"),
        );
    }
    for (role, what, example) in [
        (Role::Source, "takes the part from", "unload, retrieve or outside.in"),
        (Role::Target, "puts the part to", "load, store or outside.out"),
    ] {
        let mut found = activity.used(role);
        match (found.next(), found.next()) {
            (Some(_), None) => {}
            (Some(first), Some(second)) => report.add(
                Problem::error(
                    second.at.clone(),
                    format!("`{name}` {what} two places: {} and {}", words(draft, first), words(draft, second)),
                )
                .also(&first.at, "the first")
                .hint("a synchronisation moves one part from one place to one other"),
            ),
            (None, _) if activity.is_whole => report.add(
                Problem::error(activity.at.clone(), format!("`{name}` {what} nowhere"))
                    .hint(format!("one of its actions must be {example}")),
            ),
            (None, _) => {}
        }
    }
}

pub(super) fn source_and_target_differ(draft: &DraftCell<'_>, activity: &DraftActivity<'_>, report: &mut Report) {
    for target in activity.used(Role::Target) {
        if let Some(source) = activity.used(Role::Source).find(|source| source.value.of == target.value.of) {
            let name = draft.holder(target.value.of);
            report.add(
                Problem::error(target.at.clone(), format!("`{}` moves a part from `{name}` to itself", activity.name))
                    .also(&source.at, "from here"),
            );
        }
    }
}

pub(super) fn one_carries(draft: &DraftCell<'_>, activity: &DraftActivity<'_>, report: &mut Report) {
    let carriers: Vec<_> = activity.used(Role::Carrier).collect();
    if let [first, second, ..] = carriers.as_slice() {
        report.add(
            Problem::error(
                second.at.clone(),
                format!(
                    "two carry the part of `{}`: {} and {}",
                    activity.name,
                    words(draft, first),
                    words(draft, second)
                ),
            )
            .also(&first.at, "the first")
            .hint("hand it over by way of a place between them"),
        );
    }
    for carrier in carriers {
        let end = [Role::Source, Role::Target].into_iter().flat_map(|role| activity.used(role));
        if let Some(end) = end.into_iter().find(|end| end.value.of == carrier.value.of) {
            let name = draft.holder(carrier.value.of);
            report.add(
                Problem::error(
                    carrier.at.clone(),
                    format!("`{name}` carries the part of `{}` and holds it", activity.name),
                )
                .also(&end.at, "here it is an end of the way")
                .hint("without a carrier the two ends do it together"),
            );
        }
    }
}
