//! Interlocks: their states are those of executions, and executions fulfil them.

use super::zones::is_ordered;
use crate::parse::findings::TableFindings;
use crate::{ComponentState, Execution, ExecutionStep, Interlock, InterlockTerm, InterlockedAction, Relations};

/// The state of another machine that an automatic term asks for is one that an execution brings about (rule 5).
pub(super) fn external_states_are_declared(relations: &Relations, findings: &mut TableFindings<'_>) {
    for interlock in &relations.interlocks {
        let own = match &interlock.action {
            InterlockedAction::State { component, .. } => component.machine,
            InterlockedAction::Operation { operation, .. } => relations.operation(*operation).machine,
        };
        for term in interlock.terms.iter().filter(|term| term.is_automatic) {
            for state in term.states.iter().filter(|state| state.component.machine != own) {
                let mut steps = relations.executions.iter().flat_map(|execution| execution.steps());
                let name = relations.component_name(state.component);
                if !steps.any(|step| step.state(state.component) == Some(Some(state.state))) {
                    let word = relations.state_name(state.component, state.state);
                    let message = format!("no execution has {name} in state {word}");
                    let hint =
                        "states that an interlock asks for in automatic mode are declared in executions (rule 5)";
                    findings.error(term.row, &name, message, hint);
                }
            }
        }
    }
}

/// An execution that does an action fulfils the internal states of a term that is expected in automatic mode.
pub(super) fn executions_fulfil_an_automatic_term(relations: &Relations, findings: &mut TableFindings<'_>) {
    for interlock in &relations.interlocks {
        let InterlockedAction::State { component, to } = interlock.action else { continue };
        let name = format!("{} to {}", relations.component_name(component), relations.state_name(component, to));
        for way in &relations.executions {
            let steps: Vec<&ExecutionStep> = way.steps().collect();
            for pair in steps.windows(2).filter(|pair| is_ordered(way, pair[1], component, to)) {
                let id = &relations.operation(way.operation).id;
                if !interlock.terms.iter().any(|term| term.is_automatic) {
                    let message =
                        format!("operation `{id}` moves {name}, and no term of that is expected in automatic mode");
                    let hint =
                        format!("write `yes` in the column `automatic` of the term that operation `{id}` fulfils");
                    findings.error(interlock.terms[0].row, "automatic", message, hint);
                } else if let Some(why) = unfulfilled(relations, interlock, way, pair[0]) {
                    let message =
                        format!("operation `{id}` moves {name}, and fulfils no automatic term of its interlock");
                    findings.error(pair[1].row, "step", message, why);
                }
            }
        }
    }
}

/// What each automatic term lacks; none where one is fulfilled.
fn unfulfilled(
    relations: &Relations,
    interlock: &Interlock,
    way: &Execution,
    before: &ExecutionStep,
) -> Option<String> {
    let own = relations.operation(way.operation).machine;
    let mut reasons = Vec::new();
    for term in interlock.terms.iter().filter(|term| term.is_automatic) {
        let wrong = wrong_state(term, before, own);
        let (of, state) = wrong?;
        let is = match before.state(of) {
            Some(Some(is)) => relations.state_name(of, is),
            Some(None) => "any",
            None => "not stated",
        };
        let (name, wanted) = (relations.component_name(of), relations.state_name(of, state));
        reasons.push(format!("{}: {name} is {is} before, not {wanted}", relations.place(term.row)));
    }
    Some(reasons.join("; "))
}

/// The first state of the machine itself that a row does not have.
fn wrong_state(
    term: &InterlockTerm,
    before: &ExecutionStep,
    own: crate::MachineId,
) -> Option<(crate::ComponentRef, ComponentState)> {
    let internal = term.states.iter().filter(|state| state.component.machine == own);
    let mut wrong = internal.filter(|state| before.state(state.component) != Some(Some(state.state)));
    wrong.next().map(|state| (state.component, state.state))
}
