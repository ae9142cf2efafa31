//! Shortest firing sequences in a graph of markings that is complete.

use super::limits::{ExplorationUndecided, MemoryBudget};
use super::space::Space;
use crate::TransitionId;

/// A shortest way from one marking to another that is reachable from it.
pub(super) fn path_to(
    space: &mut dyn Space,
    from: u32,
    to: u32,
    budget: &mut MemoryBudget,
) -> Result<Vec<TransitionId>, ExplorationUndecided> {
    let states = space.len();
    // Predecessors, and the queue.
    let bytes = 2 * states * size_of::<u32>();
    budget.take(bytes, states as u64)?;
    let mut found_by = vec![u32::MAX; states];
    let mut queue = Vec::with_capacity(states);
    queue.push(from);
    found_by[from as usize] = from;
    let mut next = 0;
    while found_by[to as usize] == u32::MAX && next < queue.len() {
        let state = queue[next];
        next += 1;
        space.successors(state, &mut |_, successor| {
            if found_by[successor as usize] == u32::MAX {
                found_by[successor as usize] = state;
                queue.push(successor);
            }
        });
    }
    let mut path = Vec::new();
    let mut at = to;
    while at != from {
        let before = found_by[at as usize];
        let mut by = None;
        space.successors(before, &mut |transition, successor| {
            if successor == at && by.is_none() {
                by = Some(TransitionId(transition));
            }
        });
        path.extend(by);
        at = before;
    }
    path.reverse();
    budget.give_back(bytes);
    Ok(path)
}
