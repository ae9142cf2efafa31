//! Deadlines of a fixed set of things.
//!
//! A tournament tree: the winner is known at once, and a change costs as many comparisons as the tree is high. Of two
//! things at the same moment the one with the lower number comes first, so the order never depends on anything else.

use linewright_line::Tick;

/// A deadline for each of a fixed number of slots.
#[derive(Clone, Debug)]
pub(crate) struct Timers {
    /// Leaves, a power of two.
    leaves: usize,
    /// Node `n` has the children `2n` and `2n + 1`; the root is node 1.
    nodes: Vec<Tick>,
}

impl Timers {
    /// `slots` slots without a deadline.
    pub(crate) fn new(slots: usize) -> Self {
        let leaves = slots.max(1).next_power_of_two();
        Timers { leaves, nodes: vec![Tick::NEVER; 2 * leaves] }
    }

    /// Sets the deadline of a slot.
    pub(crate) fn set(&mut self, slot: usize, at: Tick) {
        let mut node = self.leaves + slot;
        self.nodes[node] = at;
        while node > 1 {
            node /= 2;
            let winner = self.nodes[2 * node].min(self.nodes[2 * node + 1]);
            if self.nodes[node] == winner {
                return;
            }
            self.nodes[node] = winner;
        }
    }

    /// The earliest deadline; [`Tick::NEVER`] if there is none.
    pub(crate) fn earliest(&self) -> Tick {
        self.nodes[1]
    }

    /// The lowest slot with the earliest deadline.
    pub(crate) fn first(&self) -> usize {
        let earliest = self.nodes[1];
        let mut node = 1;
        while node < self.leaves {
            node *= 2;
            if self.nodes[node] != earliest {
                node += 1;
            }
        }
        node - self.leaves
    }
}
