//! Ways of an operation, alternatives, and passive components that several machines affect.

use super::order::Order;
use crate::parse::findings::TableFindings;
use crate::{ComponentRef, ComponentState, ConditionId, Execution, OperationId, OperationKind, Relations};

/// An operation that is executed in several ways has an execution for each (rule 12), and so has an alternative; their initial
/// states are different.
pub(super) fn ways_differ(relations: &Relations, findings: &mut TableFindings<'_>) {
    for sequence in &relations.sequences {
        for element in &sequence.elements {
            for row in &element.alternatives {
                let id = &relations.operation(row.operation).id;
                let ways: Vec<&Execution> = relations.ways(row.operation).collect();
                let has_ways = row.kind == OperationKind::AlternativeExecution;
                if has_ways && ways.len() < 2 {
                    let message = format!("operation `{id}` has {} ways", ways.len());
                    let hint = "an alternative execution has an execution for each way, at least two, named in the column `way` (rule 12)";
                    findings.error(row.row, "kind", message, hint);
                } else if !has_ways && ways.len() > 1 {
                    let message = format!("operation `{id}` has {} ways", ways.len());
                    let hint = "write `alternative-execution` as its kind (rule 12), or leave out what it does not do";
                    findings.error(row.row, "kind", message, hint);
                }
            }
            let ways: Vec<&Execution> =
                element.alternatives.iter().flat_map(|row| relations.ways(row.operation)).collect();
            for (nth, way) in ways.iter().enumerate() {
                if let Some(other) = ways[..nth].iter().find(|other| can_both_begin(way, other)) {
                    let other = relations.place(other.initial.row);
                    let message = format!("this way and that of {other} can begin in the same state");
                    findings.error(
                        way.initial.row,
                        "operation",
                        message,
                        "the initial states choose the way (rule 12): they differ",
                    );
                }
            }
        }
    }
}

fn can_both_begin(one: &Execution, other: &Execution) -> bool {
    let differs = one.initial.states.iter().any(|(of, state)| {
        let known = other.initial.state(*of).flatten();
        matches!((state, known), (Some(state), Some(known)) if *state != known)
    });
    !differs
}

/// The same action is not shown by different sensors in different ways (rule 10).
pub(super) fn ends_are_detected_alike(relations: &Relations, findings: &mut TableFindings<'_>) {
    for (nth, way) in relations.executions.iter().enumerate() {
        let others = relations.executions[..nth].iter().filter(|other| other.operation == way.operation);
        for other in others {
            for (before, step) in way.steps().zip(&way.actions) {
                let own = relations.operation(way.operation).machine;
                let split = |of: &ComponentRef| of.machine == own;
                let changes = |step: &crate::ExecutionStep, before: &crate::ExecutionStep, is_own: bool| {
                    let changed = step.states.iter().filter(|(of, state)| {
                        split(of) == is_own && before.state(*of).is_some_and(|known| known != *state)
                    });
                    changed.copied().collect::<Vec<_>>()
                };
                let own_changes = changes(step, before, true);
                let alike = other
                    .steps()
                    .zip(&other.actions)
                    .find(|(before, step)| !own_changes.is_empty() && changes(step, before, true) == own_changes);
                let Some((other_before, other_step)) = alike else { continue };
                if components(&changes(step, before, false)) != components(&changes(other_step, other_before, false)) {
                    let other = relations.place(other_step.row);
                    let message = format!("this step changes other sensors than the same action in {other}");
                    let hint = "which sensor shows the end of an action does not depend on the way (rule 10)";
                    findings.error(step.row, "step", message, hint);
                }
            }
        }
    }
}

fn components(of: &[(ComponentRef, Option<ComponentState>)]) -> Vec<ComponentRef> {
    of.iter().map(|(of, _)| *of).collect()
}

/// While an operation affects a passive component of another machine, no other machine does (rule 2c).
pub(super) fn passive_components_are_affected_one_by_one(relations: &Relations, findings: &mut TableFindings<'_>) {
    let affected: Vec<(OperationId, ComponentRef, &Execution)> =
        relations.executions.iter().flat_map(affects(relations)).collect();
    for condition in 0..relations.conditions.len() {
        let condition = ConditionId(condition);
        let order = Order::of(relations, condition);
        let zones = |operation: OperationId| {
            let row = relations.related(condition).find(|(_, row)| row.operation == operation);
            row.map(|(_, row)| &row.zones_before[..])
        };
        for (nth, (one, of, execution)) in affected.iter().enumerate() {
            for (other, _, earlier) in affected[..nth].iter().filter(|(_, component, _)| component == of) {
                let machine = |operation: OperationId| relations.operation(operation).machine;
                let (Some(here), Some(there)) = (zones(*one), zones(*other)) else { continue };
                let is_apart = machine(*one) == machine(*other)
                    || order.before(*one).contains(other)
                    || order.before(*other).contains(one)
                    || here.iter().any(|zone| there.contains(zone));
                if !is_apart {
                    let name = relations.component_name(*of);
                    let id = &relations.operation(*other).id;
                    let message = format!("operation `{id}` of another machine may change {name} at the same time");
                    let hint = format!(
                        "one machine at a time does (rule 2): make one the predecessor of the other, or give both a zone; it is in {}",
                        relations.place(earlier.initial.row)
                    );
                    findings.error(execution.initial.row, "operation", message, hint);
                }
            }
        }
    }
}

/// The components of other machines that an execution changes.
fn affects<'a>(relations: &'a Relations) -> impl Fn(&'a Execution) -> Vec<(OperationId, ComponentRef, &'a Execution)> {
    |execution| {
        let own = relations.operation(execution.operation).machine;
        let foreign = execution.initial.states.iter().filter(|(of, _)| of.machine != own);
        let changed =
            foreign.filter(|(of, state)| execution.steps().any(|step| step.state(*of).is_some_and(|s| s != *state)));
        changed.map(|(of, _)| (execution.operation, *of, execution)).collect()
    }
}
