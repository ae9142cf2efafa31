//! The names a description defines: are they well formed and unique, and what does each one stand for?
//!
//! Names of resources, synchronisations, parts and steps become names of places, transitions and tones, so they do
//! without the signs that are put between them there.

use linewright_text::{LocatedName, NameTable, Problem, Report, phrase, ros_name, tag, unique};

use super::raw::RawCell;
use crate::net::RUNNING;

/// Separators of names elsewhere: `M1.load`, `load M1<A.new>`, `load M*`, `M1.process/2`.
const SIGNS: [char; 7] = ['.', '<', '>', ',', '/', '*', ':'];
/// The resource that every cell has.
pub(super) const OUTSIDE: &str = "outside";
/// The stages that every part has.
const STAGES: [&str; 2] = [NEW, DONE];
/// Of a part on which nothing has been done.
pub(super) const NEW: &str = "new";
/// Of a finished part.
pub(super) const DONE: &str = "done";

/// The names of the whole cell.
pub(super) struct CellNames<'a> {
    pub resources: NameTable<'a>,
    pub syncs: NameTable<'a>,
    pub parts: NameTable<'a>,
    /// By part type, in the order of the description.
    pub steps: Vec<NameTable<'a>>,
}

/// Collects and checks all names.
pub(super) fn names<'a>(raw: &'a RawCell, report: &mut Report) -> CellNames<'a> {
    if let Some(name) = &raw.name {
        ros_name(name, "cell", report);
    }
    let mut names = CellNames {
        resources: NameTable::default(),
        syncs: NameTable::default(),
        parts: NameTable::default(),
        steps: Vec::with_capacity(raw.parts.len()),
    };
    for (id, resource) in raw.resources.iter().enumerate() {
        if let Some(name) = &resource.name {
            let fits = label(name, "resource", report)
                && reserved(name, "resource", &[OUTSIDE], "it is where parts come from and go to", report)
                && reserved(name, "resource", &[RUNNING], "it is what is in progress", report);
            names.resources.note(name, fits);
            unique(&mut names.resources, name, id, "resource", report);
        }
    }
    for (id, sync) in raw.syncs.iter().enumerate() {
        if let Some(name) = &sync.name {
            label(name, "synchronisation", report);
            unique(&mut names.syncs, name, id, "synchronisation", report);
        }
    }
    for (id, part) in raw.parts.iter().enumerate() {
        if let Some(name) = &part.name {
            label(name, "part", report);
            unique(&mut names.parts, name, id, "part", report);
        }
        for name in part.variants.iter().filter_map(|variant| variant.name.as_ref()) {
            label(name, "variant", report);
            unique(&mut names.parts, name, id, "part", report);
        }
        let mut steps = NameTable::default();
        for (id, step) in part.steps.iter().enumerate() {
            if let Some(name) = &step.name {
                let fits = label(name, "step", report)
                    && reserved(name, "step", &STAGES, "every part has a stage of that name", report);
                steps.note(name, fits);
                unique(&mut steps, name, id, "step of this part", report);
            }
        }
        names.steps.push(steps);
    }
    for answer in raw.exceptions.iter().flat_map(|exception| &exception.answers) {
        if let Some(word) = &answer.word {
            tag(word, "answer", report);
        }
    }
    names
}

fn label(name: &LocatedName, what: &str, report: &mut Report) -> bool {
    let has_signs = name.value.contains(SIGNS);
    if has_signs {
        let signs: Vec<String> = SIGNS.iter().map(|sign| format!("`{sign}`")).collect();
        report.add(
            Problem::error(name.at.clone(), format!("`{}` cannot name this {what}", name.value.escape_debug()))
                .hint(format!("names are put together with {}; do without them", signs.join(" "))),
        );
    }
    !has_signs && phrase(name, what, report)
}

/// Reports a name that is taken; whether it is free.
fn reserved(name: &LocatedName, what: &str, taken: &[&str], why: &str, report: &mut Report) -> bool {
    let is_taken = taken.contains(&name.value.as_str());
    if is_taken {
        report.add(
            Problem::error(name.at.clone(), format!("a {what} cannot be called `{}`", name.value))
                .label("reserved")
                .hint(why),
        );
    }
    !is_taken
}
