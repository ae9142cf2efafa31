//! A plan's graph: between which stages each step leads.
//!
//! A step begins where the one before it ends; with `or`, where another begins; with `then`, it leads to where a later
//! one begins, or to the end. All lead forward, so a plan has no circle: the stages are in an order in which every step
//! leads to a later one. A stage is called after the first step that leads to it.
//!
//! A variant of a plan has fewer stages: where a step is left out, those before and after it are one.

use linewright_text::{LocatedName, NameTable, Problem, Report};

use super::draft::{DraftPart, DraftStep};
use super::names::{DONE, NEW};
use super::raw::{RawPart, RawStep, RawVariant};

/// The stages' names, and for each step the stages it leads between.
pub(super) struct DraftPlan {
    pub stages: Vec<String>,
    pub steps: Vec<(usize, usize)>,
    pub is_whole: bool,
}

/// Computes the graph, and reports what it cannot.
pub(super) fn plan(part: &RawPart, names: &NameTable<'_>, report: &mut Report) -> DraftPlan {
    let mut is_whole = true;
    // Where each step begins: the number of the first step that begins there. The number after the last is the end.
    let mut begins: Vec<usize> = Vec::with_capacity(part.steps.len());
    for (at, step) in part.steps.iter().enumerate() {
        let shared = step.or.as_ref().map(|other| earlier(other, at, names, report));
        is_whole &= shared != Some(None);
        begins.push(shared.flatten().map_or(at, |other| begins[other]));
    }
    let mut ends = Vec::with_capacity(part.steps.len());
    for (at, step) in part.steps.iter().enumerate() {
        let end = match &step.then {
            Some(end) if end.value == DONE => Some(part.steps.len()),
            Some(other) => later(other, at, &begins, names, report),
            None => following(step, at, &begins, part, report),
        };
        is_whole &= end.is_some();
        ends.push(end.unwrap_or(part.steps.len()));
    }
    let mut points: Vec<usize> = begins.iter().chain(&ends).copied().chain([0, part.steps.len()]).collect();
    points.sort_unstable();
    points.dedup();
    let stage = |point: usize| points.partition_point(|&known| known < point);
    let called = |&point: &usize| {
        let leading = ends.iter().position(|&end| end == point).unwrap_or(point);
        match point {
            0 => NEW.to_owned(),
            _ if point == part.steps.len() => DONE.to_owned(),
            _ => part.steps[leading].name.as_ref().map_or_else(|| format!("step {leading}"), |name| name.value.clone()),
        }
    };
    let steps = begins.iter().zip(&ends).map(|(&begin, &end)| (stage(begin), stage(end))).collect();
    DraftPlan { stages: points.iter().map(called).collect(), steps, is_whole }
}

/// The step that `or` names, which must have been listed.
fn earlier(other: &LocatedName, at: usize, names: &NameTable<'_>, report: &mut Report) -> Option<usize> {
    let found = names.find(other, "step of this part", report)?;
    if found < at {
        return Some(found);
    }
    report.add(
        Problem::error(other.at.clone(), format!("`{}` is not listed before this step", other.value))
            .hint("the first of several alternatives has no `or`; the others name it"),
    );
    None
}

/// Beginning of the step that `then` names, if that is later.
fn later(
    other: &LocatedName,
    at: usize,
    begins: &[usize],
    names: &NameTable<'_>,
    report: &mut Report,
) -> Option<usize> {
    let found = names.find(other, "step of this part", report)?;
    if begins[found] > at {
        return Some(begins[found]);
    }
    report.add(
        Problem::error(other.at.clone(), format!("`then` leads back to `{}`", other.value))
            .hint("a plan leads forward only; list the step again under another name if it is done twice"),
    );
    None
}

/// Target of a step without one: the next one listed, alternatives to itself left out.
fn following(step: &RawStep, at: usize, begins: &[usize], part: &RawPart, report: &mut Report) -> Option<usize> {
    let next = (at + 1..part.steps.len()).find(|&next| begins[next] != begins[at]);
    let Some(next) = next else { return Some(part.steps.len()) };
    if begins[next] == next {
        return Some(next);
    }
    let place = step.name.as_ref().map_or_else(|| step.at.clone(), |name| name.at.clone());
    let name = |step: &RawStep| step.name.as_ref().map_or_else(|| "?".to_owned(), |name| name.value.clone());
    report.add(
        Problem::error(place, format!("no successor for step `{}`", name(step)))
            .label(format!("`{}` follows, which begins elsewhere", name(&part.steps[next])))
            .hint("name the next step in `then`, or write `then = \"done\"` where it is the last"),
    );
    None
}

/// The part type that is as `of` is but for the steps that it is without.
pub(super) fn variant<'a>(
    of: &DraftPart<'a>,
    raw: &'a RawVariant,
    names: &NameTable<'_>,
    report: &mut Report,
) -> DraftPart<'a> {
    let name = raw.name.as_ref().map_or("?", |name| name.value.as_str());
    let written = raw.without.iter().flat_map(|without| &without.value);
    let found: Vec<Option<usize>> = written.map(|step| names.find(step, "step of this part", report)).collect();
    let is_known = raw.without.is_some() && found.iter().all(Option::is_some);
    let out = |at: &usize| found.contains(&Some(*at));
    let is_whole = of.is_whole && is_known;
    let mut made = DraftPart { variant: Some(raw), name, stages: Vec::new(), steps: Vec::new(), is_whole, ..*of };
    if !is_whole {
        return made;
    }
    // Of each stage the last of those that are one with it.
    let mut last: Vec<usize> = (0..of.stages.len()).collect();
    for step in of.steps.iter().enumerate().filter(|(at, _)| out(at)).map(|(_, step)| step) {
        let (one, other) = (last[step.from], last[step.to]);
        last.iter_mut().filter(|stage| **stage == one || **stage == other).for_each(|stage| *stage = one.max(other));
    }
    let mut left = last.clone();
    left.sort_unstable();
    left.dedup();
    let number = |stage: usize| left.partition_point(|&known| known < last[stage]);
    let kept = of.steps.iter().enumerate().filter(|(at, _)| !out(at)).map(|(_, step)| step);
    made.steps = kept.map(|s| DraftStep { from: number(s.from), to: number(s.to), ..s.clone() }).collect();
    made.stages = left.iter().map(|&stage| called(of, &made.steps, number(stage), stage)).collect();
    made.is_whole = can_be_without(&made, report);
    made
}

/// The name of a stage of a variant.
fn called(of: &DraftPart<'_>, steps: &[DraftStep<'_>], number: usize, stage: usize) -> String {
    let leading = steps.iter().find(|step| step.to == number).map(|step| step.name);
    match leading {
        _ if stage + 1 == of.stages.len() => DONE.to_owned(),
        None => NEW.to_owned(),
        Some(name) => name.to_owned(),
    }
}

/// Something is left of the plan, and it leads forward.
fn can_be_without(made: &DraftPart<'_>, report: &mut Report) -> bool {
    let at = made.variant.and_then(|raw| raw.without.as_ref()).map_or(0..0, |without| without.at.clone());
    if made.steps.is_empty() {
        report.add(
            Problem::error(at, format!("nothing is done with part `{}`", made.name))
                .hint("a variant leaves out some of the steps, not all"),
        );
        return false;
    }
    let Some(step) = made.steps.iter().find(|step| step.from >= step.to) else { return true };
    report.add(
        Problem::error(at, format!("step `{}` is another way for what `{}` is without", step.name, made.name))
            .hint("name all alternatives in `without`, or none"),
    );
    false
}
