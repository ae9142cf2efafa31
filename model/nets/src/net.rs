//! The structure of a net: places, transitions, weighted arcs, and the marking it starts from.
//!
//! A [`Net`] never changes, and exists only in sound form (see [`crate::NetBuilder`]), so no method here returns a
//! `Result`. The meaning of its places and transitions is elsewhere: conditions, actions, stations, and equally the
//! time intervals, event arcs or colours of a richer kind of net, are tables beside it, indexed by its ids.
//!
//! Arcs are stored twice, by transition and by place. The token game reads the one, a controller that needs what leads
//! on from a marked place reads the other, and both are hot.

use std::collections::HashMap;
use std::sync::Arc;

use crate::{Marking, NamedId, NetNode, PlaceId, TransitionId};

/// A marked place/transition net {P, T, Pre, Post, M} with weighted arcs (seed 002 §3.1; the weights, which are all 1
/// there, are those of the usual place/transition nets).
///
/// # Panics
/// Methods that take an id panic when it is not an id of this net; so they do with markings of another size.
#[derive(Clone, Debug)]
pub struct Net {
    pub(crate) name: String,
    pub(crate) place_names: Vec<Arc<str>>,
    pub(crate) transition_names: Vec<Arc<str>>,
    pub(crate) place_by_name: HashMap<Arc<str>, PlaceId>,
    pub(crate) transition_by_name: HashMap<Arc<str>, TransitionId>,
    pub(crate) presets: Adjacency<PlaceId>,
    pub(crate) postsets: Adjacency<PlaceId>,
    pub(crate) consumers: Adjacency<TransitionId>,
    pub(crate) producers: Adjacency<TransitionId>,
    pub(crate) initial: Marking,
}

impl Net {
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of places.
    pub fn place_count(&self) -> usize {
        self.place_names.len()
    }

    /// Number of transitions.
    pub fn transition_count(&self) -> usize {
        self.transition_names.len()
    }

    /// All places, in the order of declaration.
    pub fn places(&self) -> impl ExactSizeIterator<Item = PlaceId> + Clone + use<> {
        // `build` bounds the count far below 32 bits.
        (0..self.place_count() as u32).map(PlaceId)
    }

    /// All transitions, in the order of declaration.
    pub fn transitions(&self) -> impl ExactSizeIterator<Item = TransitionId> + Clone + use<> {
        (0..self.transition_count() as u32).map(TransitionId)
    }

    pub fn place_name(&self, place: PlaceId) -> &str {
        &self.place_names[place.index()]
    }

    pub fn transition_name(&self, transition: TransitionId) -> &str {
        &self.transition_names[transition.index()]
    }

    pub fn place_named(&self, name: &str) -> Option<PlaceId> {
        self.place_by_name.get(name).copied()
    }

    pub fn transition_named(&self, name: &str) -> Option<TransitionId> {
        self.transition_by_name.get(name).copied()
    }

    /// •t: what firing the transition takes, and from where; ordered by place.
    pub fn preset(&self, transition: TransitionId) -> &[(PlaceId, u32)] {
        self.presets.of(transition.index())
    }

    /// t•: what firing the transition gives, and where; ordered by place.
    pub fn postset(&self, transition: TransitionId) -> &[(PlaceId, u32)] {
        self.postsets.of(transition.index())
    }

    /// p•: the transitions that take from the place, and how much; ordered by transition.
    pub fn consumers(&self, place: PlaceId) -> &[(TransitionId, u32)] {
        self.consumers.of(place.index())
    }

    /// •p: the transitions that give to the place, and how much; ordered by transition.
    pub fn producers(&self, place: PlaceId) -> &[(TransitionId, u32)] {
        self.producers.of(place.index())
    }

    /// M₀: the marking the net was built with.
    pub fn initial_marking(&self) -> Marking {
        self.initial.clone()
    }

    /// A place with its name, for messages.
    pub fn place(&self, place: PlaceId) -> NamedId<PlaceId> {
        NamedId { id: place, name: self.place_names[place.index()].clone() }
    }

    /// A transition with its name, for messages.
    pub fn transition(&self, transition: TransitionId) -> NamedId<TransitionId> {
        NamedId { id: transition, name: self.transition_names[transition.index()].clone() }
    }

    /// A node with its name, for messages.
    pub fn node(&self, node: NetNode) -> NamedId<NetNode> {
        let name = match node {
            NetNode::Place(place) => &self.place_names[place.index()],
            NetNode::Transition(transition) => &self.transition_names[transition.index()],
        };
        NamedId { id: node, name: name.clone() }
    }
}

/// For each node of one kind, its neighbours of the other kind and the weights of the arcs, in one block of memory.
#[derive(Clone, Debug)]
pub(crate) struct Adjacency<I> {
    /// Where the arcs of each node start; one more entry than nodes.
    starts: Vec<usize>,
    arcs: Vec<(I, u32)>,
}

impl<I: Copy + Ord> Adjacency<I> {
    /// `arcs` in any order, each with the index of the node it is listed under.
    pub(crate) fn new(nodes: usize, arcs: impl Iterator<Item = (usize, (I, u32))>) -> Self {
        let mut arcs: Vec<_> = arcs.collect();
        arcs.sort_unstable();
        let starts = (0..=nodes).map(|node| arcs.partition_point(|&(of, _)| of < node)).collect();
        Adjacency { starts, arcs: arcs.into_iter().map(|(_, arc)| arc).collect() }
    }

    fn of(&self, node: usize) -> &[(I, u32)] {
        &self.arcs[self.starts[node]..self.starts[node + 1]]
    }
}

#[cfg(test)]
mod tests {
    use crate::{NetBuilder, PlaceId, TransitionId};

    #[test]
    fn arcs_are_found_from_both_ends() {
        let mut b = NetBuilder::new("assembly");
        let [bolts, plate, part] = [("bolts", 4), ("plate", 1), ("part", 0)].map(|(name, n)| b.place(name, n));
        let screw = b.transition("screw");
        let idle = b.transition("idle");
        b.output(screw, part, 1).input(screw, plate, 1).input(screw, bolts, 4);
        let net = b.build().unwrap();

        assert_eq!(net.preset(screw), [(bolts, 4), (plate, 1)]);
        assert_eq!(net.postset(screw), [(part, 1)]);
        assert_eq!(net.consumers(bolts), [(screw, 4)]);
        assert_eq!(net.producers(part), [(screw, 1)]);
        assert!(net.preset(idle).is_empty() && net.producers(bolts).is_empty());
        assert_eq!(net.places().collect::<Vec<_>>(), [PlaceId(0), PlaceId(1), PlaceId(2)]);
        assert_eq!(net.transitions().collect::<Vec<_>>(), [TransitionId(0), TransitionId(1)]);
        assert_eq!(net.initial_marking().total(), 5);
        assert_eq!(net.place(part).to_string(), "place `part`");
        assert_eq!(net.place_named("nut"), None);
    }
}
