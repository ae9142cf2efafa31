//! A plan that fails, with as few faults as possible.

use crate::mutants::Mutant;
use crate::plan::FaultPlan;
use crate::run::play_plan;

/// Characters in which two findings of a kind agree.
const KIND: usize = 45;

/// Leaves out one fault after another while the run still ends with a finding of the same kind.
pub fn shrink(plan: &mut FaultPlan, mutant: Option<Mutant>) {
    let kind = |plan: &FaultPlan| play_plan(plan, mutant).finding.map(|finding| kind_of(&finding.text));
    let Some(first) = kind(plan) else { return };
    let mut at = plan.faults.len();
    while at > 0 {
        at -= 1;
        let fault = plan.faults.remove(at);
        if kind(plan).as_ref() != Some(&first) {
            plan.faults.insert(at, fault);
        }
    }
}

/// What a finding has in common with others of its kind: its first words, without numbers.
fn kind_of(text: &str) -> String {
    text.chars().filter(|c| !c.is_ascii_digit()).take(KIND).collect()
}
