//! Terminal components: parts of the graph of markings that nothing leaves.
//!
//! Every marking leads into one of them, so what holds for good is read off them alone. Found by Tarjan's algorithm
//! with a stack of its own (a graph of markings is far deeper than a thread's), firing each marking once. Markings that
//! are known to lie in no terminal component can be left out, which in practice is nearly all of them.

use super::limits::{ExplorationUndecided, MemoryBudget};
use super::space::Space;

/// Not visited yet.
const NEW: u32 = 0;
/// Visited, and its component is complete.
const DONE: u32 = u32::MAX;

/// A part that nothing leaves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct TerminalComponent {
    /// Number of its markings.
    pub(super) states: u64,
    /// The least of them.
    pub(super) first: u32,
}

/// Common facts of the terminal components.
#[derive(Clone, Debug)]
pub(super) struct Terminal {
    pub(super) count: u64,
    /// The one whose first state has the least number.
    pub(super) first: Option<TerminalComponent>,
    /// Per transition, the first state of a part in which it never fires.
    pub(super) lost: Vec<Option<u32>>,
}

/// A state that is being visited.
struct TarjanFrame {
    state: u32,
    order: u32,
    low: u32,
    /// Whether something leads out of what will become its component.
    leaves: bool,
    /// Where its successors start in the stack of successors; those above `next` have been looked at.
    start: usize,
}

/// Finds them among the states for which `skip` does not hold. No state that is skipped may be in one of them, and
/// every state from which a skipped one is reached must be skipped itself.
pub(super) fn terminal<S: Space>(
    space: &mut S,
    transitions: usize,
    skip: impl Fn(&S, u32) -> bool,
    budget: &mut MemoryBudget,
) -> Result<Terminal, ExplorationUndecided> {
    let states = space.len();
    let table = states * size_of::<u32>();
    budget.take(table, states as u64)?;
    let mut search = TarjanSearch {
        order: vec![NEW; states],
        next: 1,
        waiting: Vec::new(),
        successors: Vec::new(),
        frames: Vec::new(),
    };
    let mut found = Terminal { count: 0, first: None, lost: vec![None; transitions] };
    let mut held = 0;
    for root in 0..states as u32 {
        if search.order[root as usize] != NEW || skip(space, root) {
            continue;
        }
        search.enter(root, space);
        while !search.frames.is_empty() {
            if search.step(space) {
                search.leave(space, &mut found);
            }
            let needs = search.bytes();
            if needs > held {
                // What vectors hold at most while they grow.
                let more = needs.next_power_of_two() * 2 - held;
                budget.take(more, states as u64)?;
                held += more;
            }
        }
    }
    budget.give_back(table + held);
    Ok(found)
}

struct TarjanSearch {
    /// Per state: not visited, complete, or when it was visited.
    order: Vec<u32>,
    next: u32,
    /// Visited, and in no complete component yet.
    waiting: Vec<u32>,
    /// Of all frames, one after the other.
    successors: Vec<u32>,
    frames: Vec<TarjanFrame>,
}

impl TarjanSearch {
    fn bytes(&self) -> usize {
        (self.waiting.len() + self.successors.len()) * size_of::<u32>() + self.frames.len() * size_of::<TarjanFrame>()
    }

    fn enter<S: Space>(&mut self, state: u32, space: &mut S) {
        let start = self.successors.len();
        space.successors(state, &mut |_, to| self.successors.push(to));
        self.order[state as usize] = self.next;
        self.frames.push(TarjanFrame { state, order: self.next, low: self.next, leaves: false, start });
        self.waiting.push(state);
        self.next += 1;
    }

    /// Looks at one more successor of the top frame; true if there is none.
    fn step<S: Space>(&mut self, space: &mut S) -> bool {
        let Some(top) = self.frames.last_mut() else { return false };
        if self.successors.len() == top.start {
            return true;
        }
        let Some(to) = self.successors.pop() else { return true };
        match self.order[to as usize] {
            NEW => self.enter(to, space),
            // It belongs to a component that was complete before this one.
            DONE => top.leaves = true,
            order => top.low = top.low.min(order),
        }
        false
    }

    /// Completes the top frame, and its component if it is the root of one.
    fn leave<S: Space>(&mut self, space: &mut S, found: &mut Terminal) {
        let Some(top) = self.frames.pop() else { return };
        let is_root = top.low == top.order;
        if let Some(below) = self.frames.last_mut() {
            below.low = below.low.min(top.low);
            below.leaves |= is_root || top.leaves;
        }
        if !is_root {
            return;
        }
        let from = self.waiting.iter().rposition(|&state| state == top.state).unwrap_or(0);
        self.waiting[from..].iter().for_each(|&state| self.order[state as usize] = DONE);
        if !top.leaves {
            found.add(&self.waiting[from..], space);
        }
        self.waiting.truncate(from);
    }
}

impl Terminal {
    fn add<S: Space>(&mut self, members: &[u32], space: &mut S) {
        let first = members.iter().copied().min().unwrap_or(0);
        let part = TerminalComponent { states: members.len() as u64, first };
        self.count += 1;
        let mut fires = vec![false; self.lost.len()];
        for &state in members {
            space.successors(state, &mut |transition, _| fires[transition as usize] = true);
        }
        for (lost, _) in self.lost.iter_mut().zip(fires).filter(|(_, fires)| !fires) {
            *lost = Some(lost.map_or(first, |known| known.min(first)));
        }
        if self.first.as_ref().is_none_or(|known| first < known.first) {
            self.first = Some(part);
        }
    }
}
