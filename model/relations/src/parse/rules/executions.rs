//! Executions: which states they may change, and what they begin and end with.

use std::collections::{BTreeMap, BTreeSet};

use crate::parse::findings::TableFindings;
use crate::{
    ComponentKind, ComponentRef, ComponentState, Execution, MachineSequence, OperationId, Relations, SequenceElement,
};

/// A sequence begins with the check of its machine's home position: one row, the same for all sequences (rule 6).
pub(super) fn sequences_begin_at_home(relations: &Relations, findings: &mut TableFindings<'_>) {
    let has_components = |sequence: &&MachineSequence| !relations.machine(sequence.machine).components.is_empty();
    let mut homes: BTreeMap<_, &Execution> = BTreeMap::new();
    for sequence in relations.sequences.iter().filter(has_components) {
        let machine = &relations.machine(sequence.machine).name;
        let first = &sequence.elements[0].alternatives[0];
        let id = &relations.operation(first.operation).id;
        let hint = "the first operation of a sequence checks the home position: one execution of one row (rule 6)";
        let mut ways = relations.ways(first.operation);
        let Some(home) = ways.next() else {
            let message =
                format!("operation `{id}` does not check the home position of {machine}: it has no execution");
            findings.error(first.row, "operation", message, hint);
            continue;
        };
        if let Some(more) = home.actions.first().or_else(|| ways.next().map(|way| &way.initial)) {
            let message = format!("operation `{id}` does more than check the home position of {machine}");
            findings.error(more.row, "step", message, hint);
        }
        let earlier = homes.entry(sequence.machine).or_insert(home);
        if earlier.initial.states != home.initial.states {
            let message = format!("the home position of {machine} is another one here");
            let hint = format!("the first is in {} (rule 6)", relations.place(earlier.initial.row));
            findings.error(home.initial.row, "operation", message, hint);
        }
    }
}

/// Each row of an execution has all its components; states of other machines that choose a way stand in the initial row alone
/// (rules 2b and 9).
pub(super) fn rows_name_the_same_components(relations: &Relations, findings: &mut TableFindings<'_>) {
    for execution in &relations.executions {
        let own = relations.operation(execution.operation).machine;
        let chooses = |of: &ComponentRef| of.machine != own && relations.component(*of).kind.is_active();
        let all: BTreeSet<ComponentRef> =
            execution.steps().flat_map(|step| step.states.iter().map(|(of, _)| *of)).collect();
        for of in all.iter().filter(|of| !chooses(of)) {
            let name = relations.component_name(*of);
            for step in execution.steps().filter(|step| step.state(*of).is_none()) {
                let message = format!("this row has no state of {name}, and another one of this execution has");
                findings.error(
                    step.row,
                    "step",
                    message,
                    "each row has the states of all components (rule 2); `*` is any state",
                );
            }
        }
        for step in &execution.actions {
            for (of, _) in step.states.iter().filter(|(of, _)| chooses(of)) {
                let name = relations.component_name(*of);
                let message = format!("this step would end by a state of another machine, {name}");
                let hint =
                    "the end of an action is detected by its own component alone (rule 9): make it a predecessor";
                findings.error(step.row, &name, message, hint);
            }
        }
    }
}

/// An action changes components of its machine that can be ordered, sensors of others, or books zones (rules 1, 2 and 8).
pub(super) fn actions_change_what_they_may(relations: &Relations, findings: &mut TableFindings<'_>) {
    for execution in &relations.executions {
        let own = relations.operation(execution.operation).machine;
        let steps: Vec<_> = execution.steps().collect();
        for pair in steps.windows(2) {
            let (before, step) = (pair[0], pair[1]);
            let changed =
                step.states.iter().filter(|(of, state)| before.state(*of).is_some_and(|known| known != *state));
            let mut is_detected = !step.booked.is_empty() || !step.released.is_empty();
            for (of, _) in changed {
                let name = relations.component_name(*of);
                match relations.component(*of).kind {
                    ComponentKind::Actuator | ComponentKind::Variable => is_detected |= of.machine == own,
                    ComponentKind::Sensor if of.machine != own => {}
                    ComponentKind::Sensor => {
                        let message = format!("{name} is a sensor of this machine, and an action cannot change it");
                        let hint = "what an actuator moves is part of the actuator's component; a component that is a sensor alone is \
                                    changed by other machines (rule 1)";
                        findings.error(step.row, &name, message, hint);
                        is_detected = true;
                    }
                }
            }
            if !is_detected {
                let message = "this step orders nothing, so that its end cannot be seen";
                let hint = "a step changes a component of its machine, whose own sensors show the end (rule 8), or books zones";
                findings.error(step.row, "step", message, hint);
            }
        }
    }
}

/// States in which a component can be; not there where nothing is known.
type Possible = BTreeMap<ComponentRef, BTreeSet<ComponentState>>;

/// A machine is where the next execution expects it, and at home in the end (rule 3d).
pub(super) fn states_follow_each_other(relations: &Relations, findings: &mut TableFindings<'_>) {
    for sequence in &relations.sequences {
        let mut possible = Possible::new();
        for element in &sequence.elements {
            follow(relations, sequence, element, &mut possible, findings);
        }
        let first = relations.ways(sequence.elements[0].alternatives[0].operation).next();
        let last = sequence.elements.last().map(|element| &element.alternatives[0]);
        let (Some(home), Some(last)) = (first, last) else { continue };
        for (of, state) in &home.initial.states {
            let (Some(state), Some(reached)) = (state, possible.get(of)) else { continue };
            if reached.iter().any(|reached| reached != state) {
                let name = relations.component_name(*of);
                let states: Vec<&str> = reached.iter().map(|reached| relations.state_name(*of, *reached)).collect();
                let message = format!("after the last operation {name} is {}", states.join(" or "));
                let home = relations.state_name(*of, *state);
                let hint = format!("every sequence can begin after the last operation (rule 3): at home it is {home}");
                findings.error(last.row, "operation", message, hint);
            }
        }
    }
}

/// Plays an element: the ways of its alternatives that can begin, and the states that they end with.
fn follow(
    relations: &Relations,
    sequence: &MachineSequence,
    element: &SequenceElement,
    possible: &mut Possible,
    findings: &mut TableFindings<'_>,
) {
    // What is ordered by this machine alone.
    let is_own = |of: &ComponentRef| of.machine == sequence.machine && relations.component(*of).kind.is_active();
    let ways: Vec<&Execution> = element.alternatives.iter().flat_map(|row| relations.ways(row.operation)).collect();
    let is_skipped = element.alternatives.iter().all(|row| relations.operation(row.operation).every > 1);
    let mismatch = |way: &Execution, possible: &Possible| {
        let states = way.initial.states.iter().filter(|(of, _)| is_own(of));
        states.copied().find_map(|(of, state)| {
            let known = possible.get(&of)?;
            (!known.contains(&state?)).then_some((of, state?))
        })
    };
    let begun: Vec<&&Execution> = ways.iter().filter(|way| mismatch(way, possible).is_none()).collect();
    if let (Some(first), true) = (ways.first(), begun.is_empty())
        && let Some((of, state)) = mismatch(first, possible)
    {
        let name = relations.component_name(of);
        let known: Vec<&str> = possible[&of].iter().map(|known| relations.state_name(of, *known)).collect();
        let message = format!("{name} is {} then, not {}", known.join(" or "), relations.state_name(of, state));
        let before = earlier(relations, sequence, element, of);
        let hint = before.map_or_else(String::new, |before| format!("{before} leaves it so; "));
        findings.error(first.initial.row, &name, message, format!("{hint}an unexpected start state is an alarm"));
    }
    let mut after = Possible::new();
    for way in if begun.is_empty() { ways.iter().collect() } else { begun } {
        let components: BTreeSet<ComponentRef> =
            way.steps().flat_map(|step| step.states.iter().map(|(of, _)| *of)).collect();
        for of in components.into_iter().filter(|of| is_own(of)) {
            match way.last_state(of) {
                Some(state) => {
                    after.entry(of).or_default().insert(state);
                }
                None => after.entry(of).or_default().extend(possible.get(&of).into_iter().flatten()),
            }
        }
    }
    let keeps_others = ways.is_empty() || is_skipped;
    for (of, states) in after {
        let known = possible.entry(of).or_default();
        if !keeps_others {
            known.clear();
        }
        known.extend(states);
        if known.is_empty() {
            possible.remove(&of);
        }
    }
}

/// The last operation before an element that states what a component is left in.
fn earlier(
    relations: &Relations,
    sequence: &MachineSequence,
    element: &SequenceElement,
    of: ComponentRef,
) -> Option<String> {
    let place = sequence.elements.iter().position(|other| std::ptr::eq(other, element))?;
    let rows = sequence.elements[..place].iter().rev().flat_map(|element| &element.alternatives);
    let states = |operation: OperationId| relations.ways(operation).any(|way| way.last_state(of).is_some());
    let row = rows.into_iter().find(|row| states(row.operation))?;
    Some(format!("operation `{}`", relations.operation(row.operation).id))
}
