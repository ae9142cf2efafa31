//! Why there is no supervisor: rows that contradict each other, of which none can be left out, and a way into the trap.
//!
//! Predecessors, bookings of zones and interlocks only restrict: with fewer of them more is possible, so that taking them away one
//! after the other, by whole syntheses, leaves a set of which none can be missing. Operations, their order in each machine, choices
//! and what is finished in the end are taken as given.

use linewright_relations::{ConditionId, Relations};

use crate::compose::{compose, restrictions};
use crate::fixpoint::control;
use crate::lock::{Trap, way_into_trap};
use crate::model::{Composition, MarkSet, Restriction};
use crate::supervisor::{SynthesisLimits, TooLarge, exists, within_limits};

/// Up to so many states are looked at for the shortest way into the trap.
const STATES_MAX: usize = 20_000;

/// Restrictions that contradict each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Contradiction {
    /// The condition of each product, the first that came first.
    pub products: Vec<ConditionId>,
    pub composition: Composition,
    /// Without any one of these there is a supervisor, if all others of the tables are left out. Empty where operations,
    /// sequences and choices by themselves cannot be finished.
    pub conflict: Vec<Restriction>,
    /// From the beginning into the trap, with these restrictions alone.
    pub trap: Option<Trap>,
    /// Syntheses that were made for it.
    pub syntheses: usize,
}

/// Finds the restrictions of a cell that has no supervisor.
pub(crate) fn explain(
    relations: &Relations,
    products: &[ConditionId],
    composition: &Composition,
    limits: &SynthesisLimits,
) -> Result<Contradiction, TooLarge> {
    let all = restrictions(composition);
    let mut syntheses = 0;
    let mut contradicts = |kept: &[Restriction]| {
        syntheses += 1;
        exists(relations, products, &|restriction| !kept.contains(restriction), limits).map(|exists| !exists)
    };
    // Which of several conflicts is left depends on the order in which rows are taken away: the smaller of two.
    let mut conflict = smaller(all.clone(), &mut contradicts)?;
    let backwards = smaller(all.into_iter().rev().collect(), &mut contradicts)?;
    if backwards.len() < conflict.len() {
        conflict = backwards;
    }
    conflict.sort_unstable();
    let few = compose(relations, products, &|restriction| !conflict.contains(restriction));
    let trap = within_limits(&few, limits, &mut |diagrams, _| {
        let good = control(diagrams, &few)?.good;
        let is_lost = |state: &MarkSet| !diagrams.has(&good, state);
        Ok(way_into_trap(&few, &MarkSet::new(), &is_lost, STATES_MAX))
    })?;
    let products = products.to_vec();
    Ok(Contradiction { products, composition: few, conflict, trap, syntheses })
}

/// Restrictions that still contradict each other, and of which none can be taken away.
fn smaller(
    mut conflict: Vec<Restriction>,
    contradicts: &mut dyn FnMut(&[Restriction]) -> Result<bool, TooLarge>,
) -> Result<Vec<Restriction>, TooLarge> {
    // Large parts first: most rows take no part.
    let mut size = conflict.len().div_ceil(2);
    while size > 0 {
        let mut from = 0;
        while from < conflict.len() {
            let mut fewer = conflict.clone();
            fewer.drain(from..(from + size).min(conflict.len()));
            if contradicts(&fewer)? {
                conflict = fewer;
            } else {
                from += size;
            }
        }
        size = if size == 1 { 0 } else { size.div_ceil(2) };
    }
    Ok(conflict)
}
