//! Whether plans can be done: whether moves lead parts where they are worked on, and out again.
//!
//! Judged only where moves and plans are sound each for itself; one unknown name would make every plan impossible.

use linewright_text::{Problem, Report, TextRange};

use super::plans::{STAGES_MAX, stays_after_nothing};
use crate::parse::draft::{DraftCell, DraftPart, DraftStep};
use crate::parse::raw::RawOn;
use crate::routes::{PartSpot, RouteTable, Routes};
use crate::{ActivityKind, Prototype, ResourceId, Role, StageId};

/// First stage of each part type.
pub struct Offsets(Vec<usize>);

impl Offsets {
    /// The stage of that number of that part type.
    pub fn stage(&self, part: usize, stage: usize) -> StageId {
        StageId::at(self.0[part] + stage)
    }
}

/// First stage of each part type.
pub fn offsets(draft: &DraftCell<'_>) -> Offsets {
    let mut next = 0;
    let begin = |part: &DraftPart<'_>| {
        next += part.stages.len();
        next - part.stages.len()
    };
    Offsets(draft.parts.iter().map(begin).collect())
}

/// Spots that can be reached; none unless moves and plans are sound.
pub(super) fn routes(draft: &DraftCell<'_>) -> Option<Routes> {
    let stages: usize = draft.parts.iter().map(|part| part.stages.len()).sum();
    let mut ways = RouteTable { stages, resources: draft.resources.len(), ..RouteTable::default() };
    if stages > STAGES_MAX || draft.resources.iter().any(|resource| resource.prototype.is_none()) {
        return None;
    }
    for activity in draft.activities.iter().filter(|activity| activity.kind != ActivityKind::Process) {
        ways.transports.push(transport(activity)?);
    }
    let offsets = offsets(draft);
    for (at, part) in draft.parts.iter().enumerate() {
        if !part.is_whole || part.steps.is_empty() || part.raw.name.is_none() {
            return None;
        }
        ways.ends.push((offsets.stage(at, 0), offsets.stage(at, part.stages.len() - 1)));
        for step in &part.steps {
            if step.on.is_empty() {
                return None;
            }
            for (on, raw) in step.on.iter().zip(&step.raw.on) {
                let id = on.filter(|id| draft.resource(*id).prototype.is_some_and(Prototype::processes))?;
                ways.works.push((id, offsets.stage(at, step.from), offsets.stage(at, step.to), raw.staying()));
            }
        }
    }
    Some(Routes::new(&ways))
}

/// Start and end of the move of parts by a synchronisation, if it is sound.
pub fn transport(activity: &crate::parse::draft::DraftActivity<'_>) -> Option<(PartSpot, PartSpot)> {
    let one = |role| {
        let mut found = activity.used(role);
        let part = found.next().filter(|_| found.next().is_none())?.value;
        PartSpot::of(part.of, part.action)
    };
    activity.is_whole.then_some(())?;
    Some((one(Role::Source)?, one(Role::Target)?))
}

/// Parts of a type in the draft, with the type's number.
type TypedDraftPart<'p, 'a> = (usize, &'p DraftPart<'a>);

pub(super) fn plans_can_be_done(
    draft: &DraftCell<'_>,
    part: TypedDraftPart<'_, '_>,
    routes: &Routes,
    report: &mut Report,
) {
    let (at, of) = part;
    if of.steps.iter().any(|step| step.places().any(|(id, raw)| stays_after_nothing(of, step, id, raw))) {
        return;
    }
    let offsets = offsets(draft);
    let comes = |(id, raw): (ResourceId, &RawOn), step: &DraftStep<'_>| {
        PartSpot::work_from(id, raw.staying()).any(|spot| routes.is_reached(spot, offsets.stage(at, step.from)))
    };
    let led_to = |step: &&DraftStep<'_>| step.from == 0 || of.steps.iter().any(|before| before.to == step.from);
    let known = of.steps.iter().filter(led_to);
    // Steps after one that cannot be done cannot be done either; the first is the one to mend.
    if let Some(step) = known.clone().find(|step| !step.places().any(|on| comes(on, step))) {
        report.add(never_comes(draft, part, step, routes));
        return;
    }
    let done = offsets.stage(at, of.stages.len() - 1);
    if !routes.is_reached(PartSpot::AFTER, done) {
        let hint = "a synchronisation must take it from there, and at last one to `outside.out`";
        let hint = never_unloaded(draft, of).map_or_else(|| hint.to_owned(), |never| format!("{never}; {hint}"));
        let message = format!("a finished part `{}` never leaves the cell", of.name);
        report.add(Problem::error(of.place(), message).label(stands(draft, done, routes)).hint(hint));
        return;
    }
    for step in known {
        for (id, raw) in step.places() {
            let name = draft.resource(id).name;
            let at_resource: TextRange = raw.resource.as_ref().map_or_else(|| raw.at.clone(), |name| name.at.clone());
            if !comes((id, raw), step) {
                report.add(
                    Problem::error(
                        at_resource,
                        format!("`{name}` is not reachable for part `{}` at step `{}`", of.name, step.name),
                    )
                    .hint(format!("a synchronisation with \"{name}.load\" must bring it")),
                );
            } else if !routes.finishes(PartSpot::work(id)[1], offsets.stage(at, step.to)) {
                report.add(
                    Problem::error(
                        at_resource,
                        format!("after step `{}` a part `{}` never leaves `{name}`", step.name, of.name),
                    )
                    .label("a dead end")
                    .hint(format!("a synchronisation with \"{name}.unload\" must lead to where the plan goes on")),
                );
            }
        }
    }
}

/// The resources of the last steps of a plan from which no synchronisation takes a part, if there are any.
fn never_unloaded(draft: &DraftCell<'_>, of: &DraftPart<'_>) -> Option<String> {
    let takes = |id| {
        let sources = draft.activities.iter().flat_map(|activity| activity.used(Role::Source));
        sources.into_iter().any(|source| source.value.of == Some(id))
    };
    let last = of.steps.iter().filter(|step| step.to + 1 == of.stages.len()).flat_map(|step| step.on.iter().flatten());
    let mut names: Vec<String> =
        last.filter(|&&id| !takes(id)).map(|&id| format!("`{}.unload`", draft.resource(id).name)).collect();
    names.dedup();
    (!names.is_empty()).then(|| format!("no synchronisation has {}", names.join(" or ")))
}

fn never_comes(
    draft: &DraftCell<'_>,
    (at, of): TypedDraftPart<'_, '_>,
    step: &DraftStep<'_>,
    routes: &Routes,
) -> Problem {
    let names: Vec<String> = step.on.iter().flatten().map(|&id| format!("`{}`", draft.resource(id).name)).collect();
    let loads = names.iter().map(|name| format!("\"{}.load\"", name.trim_matches('`'))).collect::<Vec<_>>();
    let message = match names.as_slice() {
        [] => format!("step `{}` of part `{}` can be done nowhere", step.name, of.name),
        names => format!("{} not reachable for part `{}` at step `{}`", names.join(" or "), of.name, step.name),
    };
    Problem::error(step.place(), message)
        .label(stands(draft, offsets(draft).stage(at, step.from), routes))
        .hint(format!("a synchronisation with {} must bring it from there", loads.join(" or ")))
}

/// Places of parts of a stage, in words.
fn stands(draft: &DraftCell<'_>, stage: StageId, routes: &Routes) -> String {
    let ids = (0..draft.resources.len()).map(ResourceId::at);
    let at = ids.filter(|&id| PartSpot::work(id).iter().any(|&spot| routes.is_reached(spot, stage)));
    let mut names: Vec<&str> = at.map(|id| draft.resource(id).name).take(6).collect();
    if routes.is_reached(PartSpot::BEFORE, stage) {
        names.insert(0, crate::parse::names::OUTSIDE);
    }
    if names.is_empty() {
        "it is nowhere by then".to_owned()
    } else {
        format!("it gets as far as {}", names.join(", "))
    }
}

pub(super) fn resources_are_used(draft: &DraftCell<'_>, routes: &Routes, report: &mut Report) {
    let offsets = offsets(draft);
    let mut used = vec![false; draft.resources.len()];
    for activity in &draft.activities {
        let of_use =
            match transport(activity) {
                Some(way) => draft.parts.iter().enumerate().any(|(at, part)| {
                    (0..part.stages.len()).any(|stage| routes.is_of_use(way, offsets.stage(at, stage)))
                }),
                None => false,
            };
        let ids = activity.uses.iter().filter_map(|part| part.value.of).filter(|_| of_use);
        ids.for_each(|id| used[id.index()] = true);
    }
    for (resource, _) in draft.resources.iter().zip(used).filter(|(_, used)| !used) {
        report.add(
            Problem::warning(resource.place(), format!("no plan needs `{}`", resource.name))
                .hint("no part that can be finished is moved by it, to it or from it"),
        );
    }
}
