//! Strong connection of the graph of places and transitions.
//!
//! It is the structural half of liveness for state machines, and a sanity check for every cyclic controller: a node
//! from which no path leads back is a state that the controller cannot leave again. Weights do not matter here, and
//! neither do tokens.

use thiserror::Error;

use crate::components::Components;
use crate::{NamedId, Net, NetNode, PlaceId, TransitionId};

/// Reason why a net is not strongly connected: two nodes without a path between them.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("no path leads from {from} to {to}")]
pub struct NotConnected {
    /// Where a path would start.
    pub from: NamedId<NetNode>,
    /// Where it would have to end.
    pub to: NamedId<NetNode>,
}

impl Net {
    /// Whether a directed path leads from every node to every other (seed 002 §3.1, Definitions 2 and 5).
    ///
    /// Places and transitions are nodes alike. Definition 5 requires paths between transitions "(or places)"; here a
    /// transition without an output place counts too, because such a net does lose its tokens.
    pub fn is_strongly_connected(&self) -> Result<(), NotConnected> {
        let places = self.place_count();
        let edges = self.transitions().flat_map(|t| {
            let node = places + t.index();
            let inputs = self.preset(t).iter().map(move |&(p, _)| (p.index(), node));
            inputs.chain(self.postset(t).iter().map(move |&(p, _)| (node, p.index())))
        });
        let found = Components::new(places + self.transition_count(), edges);
        if found.count() <= 1 {
            return Ok(());
        }
        // The first component is terminal, so that nothing leads from it to any other.
        let node = |index: usize| match index.checked_sub(places) {
            None => NetNode::Place(PlaceId(index as u32)),
            Some(index) => NetNode::Transition(TransitionId(index as u32)),
        };
        let first_of = |component| self.node(node(found.members(component)[0]));
        Err(NotConnected { from: first_of(0), to: first_of(found.count() - 1) })
    }
}

#[cfg(test)]
mod tests {
    use crate::NetBuilder;

    #[test]
    fn a_ring_is_strongly_connected_and_a_chain_is_not() {
        let mut b = NetBuilder::new("n");
        let (home, away) = (b.place("home", 1), b.place("away", 0));
        let go = b.transition("go");
        b.input(go, home, 1).output(go, away, 1);
        let chain = b.clone().build().unwrap();
        let error = chain.is_strongly_connected().unwrap_err();
        assert_eq!(error.to_string(), "no path leads from place `away` to place `home`");

        let back = b.transition("back");
        b.input(back, away, 1).output(back, home, 1);
        assert_eq!(b.build().unwrap().is_strongly_connected(), Ok(()));
    }

    #[test]
    fn one_node_is_connected_and_two_apart_are_not() {
        let mut b = NetBuilder::new("n");
        b.place("a", 0);
        assert_eq!(b.clone().build().unwrap().is_strongly_connected(), Ok(()));
        b.transition("t");
        assert!(b.build().unwrap().is_strongly_connected().is_err());
    }
}
