//! Zones stand in declarations, relations, executions and interlocks; those of the relations count.
//!
//! In automatic mode a zone is booked with the start of the operation that has it in `zones_before`, and free with the end of the
//! one that does not keep it in `zones_after`. Marks of executions refine when within the operation, and must come to the same.
//! Interlocks count in manual mode alone; where they say something else, that is a warning.

use std::collections::BTreeSet;

use super::listed;
use crate::parse::findings::TableFindings;
use crate::{InterlockedAction, MachineSequence, RelatedOperation, Relations, ZoneId};

type Zones = BTreeSet<ZoneId>;

fn names(relations: &Relations, zones: &Zones) -> String {
    listed(zones.iter().map(|zone| relations.zone(*zone).name.as_str()))
}

/// For each row the zones that its machine has when it begins.
fn held(sequence: &MachineSequence) -> Vec<(&RelatedOperation, Zones)> {
    let mut all = Vec::new();
    let mut zones = Zones::new();
    for element in &sequence.elements {
        all.extend(element.alternatives.iter().map(|row| (row, zones.clone())));
        for row in &element.alternatives {
            zones.retain(|zone| !row.zones_before.contains(zone));
        }
        zones.extend(element.alternatives.iter().flat_map(|row| &row.zones_after));
    }
    all
}

/// A zone that is kept is one that was taken, and a later operation frees it.
pub(super) fn zones_are_kept_until_they_are_freed(relations: &Relations, findings: &mut TableFindings<'_>) {
    for sequence in &relations.sequences {
        for (nth, element) in sequence.elements.iter().enumerate() {
            let first = &element.alternatives[0];
            for row in &element.alternatives {
                let not_taken: Zones =
                    row.zones_after.iter().filter(|zone| !row.zones_before.contains(zone)).copied().collect();
                if !not_taken.is_empty() {
                    let message = format!("zone {} is kept without being taken", names(relations, &not_taken));
                    findings.error(row.row, "zones_after", message, "zones_after are some of zones_before");
                }
                for zone in row.zones_after.iter().filter(|zone| !not_taken.contains(zone)) {
                    let later = sequence.elements[nth + 1..].iter().flat_map(|element| &element.alternatives);
                    let mut later = later.filter(|later| later.zones_before.contains(zone));
                    if !later.any(|later| !later.zones_after.contains(zone)) {
                        let name = &relations.zone(*zone).name;
                        let message = format!("zone {name} is kept, and no later operation of this machine frees it");
                        let hint = "an operation frees a zone that it has in zones_before and not in zones_after";
                        findings.error(row.row, "zones_after", message, hint);
                    }
                }
            }
            let rare = element.alternatives.iter().find(|row| relations.operation(row.operation).every > 1);
            if let Some(row) = rare
                && (!row.zones_after.is_empty()
                    || held(sequence).iter().any(|(other, had)| {
                        std::ptr::eq(*other, row) && row.zones_before.iter().any(|zone| had.contains(zone))
                    }))
            {
                let id = &relations.operation(row.operation).id;
                let message =
                    format!("operation `{id}` is not done in every cycle, and keeps or frees a zone for others");
                let hint =
                    "where it is left out, its machine would have other zones: take and free the zone in it alone";
                findings.error(row.row, "zones_before", message, hint);
            }
            let kept_before: Zones = held(sequence)
                .into_iter()
                .find(|(row, _)| std::ptr::eq(*row, first))
                .map(|(_, z)| z)
                .unwrap_or_default();
            for row in &element.alternatives[1..] {
                let of = |row: &RelatedOperation| -> (Zones, Zones) {
                    let taken = row.zones_before.iter().filter(|zone| kept_before.contains(zone)).copied().collect();
                    (taken, row.zones_after.iter().copied().collect())
                };
                if of(row) != of(first) {
                    let message = "alternatives free or keep different zones";
                    let hint =
                        "what a machine has afterwards does not depend on the alternative: keep the same zones in each";
                    findings.error(row.row, "zones_after", message, hint);
                }
            }
        }
    }
}

/// The marks of an execution come to the zones of the relations.
pub(super) fn executions_book_what_relations_say(relations: &Relations, findings: &mut TableFindings<'_>) {
    for sequence in &relations.sequences {
        for (row, had) in held(sequence) {
            let before: Zones = row.zones_before.iter().copied().collect();
            let after: Zones = row.zones_after.iter().copied().collect();
            for way in relations.ways(row.operation) {
                let mut has = had.clone();
                let mut booked = Zones::new();
                for step in way.steps() {
                    let not_had: Zones = step.released.iter().filter(|zone| !has.contains(zone)).copied().collect();
                    if !not_had.is_empty() {
                        let message = format!("zone {} is unbooked and not booked before", names(relations, &not_had));
                        findings.error(
                            step.row,
                            "zones",
                            message,
                            "an earlier step of this operation, or an operation before it, books it",
                        );
                    }
                    has.retain(|zone| !step.released.contains(zone));
                    has.extend(&step.booked);
                    booked.extend(&step.booked);
                }
                let place = relations.place(row.row);
                let too_many: Zones = booked.difference(&before).copied().collect();
                let missing: Zones = before.difference(&(&booked | &had)).copied().collect();
                for (zones, what) in [(too_many, "books"), (missing, "does not book")] {
                    if !zones.is_empty() {
                        let message = format!("this execution {what} zone {}", names(relations, &zones));
                        let hint =
                            format!("{place} has {} in zones_before, and that counts", names(relations, &before));
                        findings.error(way.initial.row, "operation", message, hint);
                    }
                }
                let in_the_end: Zones = has.iter().filter(|zone| before.contains(zone)).copied().collect();
                if in_the_end != after && booked.is_subset(&before) {
                    let message =
                        format!("after this execution its machine has zone {}", names(relations, &in_the_end));
                    let hint = format!("{place} has {} in zones_after, and that counts", names(relations, &after));
                    findings.error(way.actions.last().unwrap_or(&way.initial).row, "zones", message, hint);
                }
            }
        }
    }
}

/// Zones of the declaration, where it has any, are those of the relations.
pub(super) fn declared_zones_are_those_of_relations(relations: &Relations, findings: &mut TableFindings<'_>) {
    for sequence in &relations.sequences {
        for row in sequence.rows() {
            let operation = relations.operation(row.operation);
            let Some(declared) = &operation.zones else { continue };
            let (declared, before): (Zones, Zones) =
                (declared.iter().copied().collect(), row.zones_before.iter().copied().collect());
            if declared != before {
                let message =
                    format!("operation `{}` is declared with zone {}", operation.id, names(relations, &declared));
                let (place, before) = (relations.place(row.row), names(relations, &before));
                let hint = format!("{place} has {before} in zones_before, and that counts; this column may be empty");
                findings.error(operation.row, "zones", message, hint);
            }
        }
    }
}

/// The terms that are expected in automatic mode book what the execution has while it does the action.
pub(super) fn interlocks_book_what_executions_do(relations: &Relations, findings: &mut TableFindings<'_>) {
    for sequence in &relations.sequences {
        for (row, had) in held(sequence) {
            for way in relations.ways(row.operation) {
                let mut has = had.clone();
                for step in way.steps() {
                    has.extend(&step.booked);
                    let during = has.clone();
                    has.retain(|zone| !step.released.contains(zone));
                    let terms = relations.interlocks.iter().filter(|interlock| match interlock.action {
                        InterlockedAction::State { component, to } => {
                            step.row != way.initial.row && is_ordered(way, step, component, to)
                        }
                        InterlockedAction::Operation { .. } => false,
                    });
                    for term in terms.flat_map(|interlock| &interlock.terms).filter(|term| term.is_automatic) {
                        let (before, after): (Zones, Zones) =
                            (term.zones_before.iter().copied().collect(), term.zones_after.iter().copied().collect());
                        if before != during || after != has {
                            let id = &relations.operation(row.operation).id;
                            let message = format!(
                                "in manual mode this action takes zone {} and keeps {}; in operation `{id}` it takes {} and keeps {}",
                                names(relations, &before),
                                names(relations, &after),
                                names(relations, &during),
                                names(relations, &has)
                            );
                            let hint = "in automatic mode the relations count; in manual mode this term does";
                            findings.warning(term.row, "zones_before", message, hint);
                        }
                    }
                }
            }
        }
    }
}

/// Whether a step orders a component into a state that it was not in.
pub(super) fn is_ordered(
    way: &crate::Execution,
    step: &crate::ExecutionStep,
    component: crate::ComponentRef,
    to: crate::ComponentState,
) -> bool {
    let before = way.steps().take_while(|other| other.row != step.row).last();
    step.state(component) == Some(Some(to)) && before.is_some_and(|before| before.state(component) != Some(Some(to)))
}
