//! Plans, as far as they can be judged without knowing how parts are moved.

use std::collections::HashMap;

use linewright_text::{Problem, Report, suggestion};

use crate::parse::draft::{DraftCell, DraftPart, DraftStep};
use crate::parse::raw::RawOn;
use crate::{Prototype, ResourceId, Staying};

/// A guard has a clause for each stage; see `linewright_nets::coloured::MAX_CLAUSES`.
pub(super) const STAGES_MAX: usize = 4096;

pub(super) fn part_has_steps(part: &DraftPart<'_>, report: &mut Report) {
    if part.raw.steps.is_empty() {
        report.add(
            Problem::error(part.place(), format!("nothing is done with part `{}`", part.name))
                .hint("begin a step of its plan with `[[part.step]]` below it"),
        );
    }
}

pub(super) fn steps_have_resources_that_work(draft: &DraftCell<'_>, part: &DraftPart<'_>, report: &mut Report) {
    for step in &part.steps {
        if step.raw.on.is_empty() {
            report.add(
                Problem::error(step.place(), format!("step `{}` is done nowhere", step.name))
                    .hint("list in `on` the resources that can do it, each with its time"),
            );
        }
        for (on, raw) in step.on.iter().zip(&step.raw.on) {
            let (Some(id), Some(name)) = (on, &raw.resource) else { continue };
            let Some(prototype) = draft.resource(*id).prototype else { continue };
            if !prototype.processes() {
                let can = draft.resources.iter().filter(|r| r.prototype.is_some_and(Prototype::processes));
                report.add(
                    Problem::error(
                        name.at.clone(),
                        format!("`{}` ({}) cannot do step `{}`", name.value, prototype.name(), step.name),
                    )
                    .maybe_hint(suggestion(&name.value, can.map(|resource| resource.name))),
                );
            }
        }
    }
}

pub(super) fn nothing_is_listed_twice(draft: &DraftCell<'_>, part: &DraftPart<'_>, report: &mut Report) {
    let mut known = HashMap::new();
    for step in &part.steps {
        for (on, raw) in step.on.iter().zip(&step.raw.on) {
            let Some(id) = on else { continue };
            if let Some((earlier, at)) = known.insert((*id, step.from, step.to), (step.name, &raw.at))
                && part.is_whole
            {
                report.add(
                    Problem::error(
                        raw.at.clone(),
                        format!("`{}` does here what it does in step `{earlier}`", draft.resource(*id).name),
                    )
                    .label("again")
                    .also(at, "first here")
                    .hint("an alternative on the same resource must lead elsewhere"),
                );
            }
        }
    }
}

pub(super) fn steps_are_led_to(part: &DraftPart<'_>, report: &mut Report) {
    if !part.is_whole {
        return;
    }
    for step in part.steps.iter().filter(|step| step.from > 0 && step.raw.or.is_none()) {
        if !part.steps.iter().any(|before| before.to == step.from) {
            report.add(
                Problem::error(step.place(), format!("no way leads to step `{}` of part `{}`", step.name, part.name))
                    .label("never reached")
                    .hint("what is listed before it leads elsewhere with `then`"),
            );
        }
    }
}

/// Whether a part would stay where it has not been worked on. Of a variant, which leaves steps out, some may then be loaded.
pub(super) fn stays_after_nothing(part: &DraftPart<'_>, step: &DraftStep<'_>, id: ResourceId, raw: &RawOn) -> bool {
    let leads = |before: &DraftStep<'_>| before.to == step.from && before.on.contains(&Some(id));
    let is_meant = raw.stays.is_some() && (part.variant.is_none() || raw.staying() == Staying::Must);
    is_meant && !part.steps.iter().any(leads)
}

/// A part that stays was worked on there before.
pub(super) fn parts_stay_after_work(draft: &DraftCell<'_>, part: &DraftPart<'_>, report: &mut Report) {
    for step in part.steps.iter().filter(|_| part.is_whole) {
        for (id, raw) in step.places() {
            let Some(stays) = &raw.stays else { continue };
            if !stays_after_nothing(part, step, id, raw) {
                continue;
            }
            let (name, of) = (draft.resource(id).name, step.name);
            report.add(
                Problem::error(
                    stays.at.clone(),
                    format!("no step on `{name}` leads to step `{of}` of part `{}`", part.name),
                )
                .label("nothing to stay after")
                .hint("`stays` is for the second of two steps on the same resource; leave it out here"),
            );
        }
    }
}

pub(super) fn stages_can_be_numbered(draft: &DraftCell<'_>, report: &mut Report) {
    let mut stages = 0;
    for part in &draft.parts {
        stages += part.stages.len();
        if stages > STAGES_MAX {
            report.add(
                Problem::error(part.place(), format!("more than {STAGES_MAX} stages of parts"))
                    .label("from here on")
                    .hint("each part type has one more than it has steps"),
            );
            return;
        }
    }
}
