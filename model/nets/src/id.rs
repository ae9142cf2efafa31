//! Identity of places and transitions: a number to compute with, a name to show.
//!
//! Everything a controller does at run time uses the numbers, dense from zero, so that an id is an index into a table.
//! Findings and errors are read by people and carry a [`NamedId`] id: the name is shared with the net, not copied. An id
//! has no reference to its net; using it with another net is a programming error that only an index out of range brings
//! to light.

use std::fmt;
use std::sync::Arc;

/// A place of a net, numbered in the order of declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PlaceId(pub u32);

/// A transition of a net, numbered in the order of declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TransitionId(pub u32);

impl PlaceId {
    /// The position in tables that have one entry per place.
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

impl TransitionId {
    /// The position in tables that have one entry per transition.
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// Either kind of node: P ∪ T of the definition of a net (seed 002 §3.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NetNode {
    Place(PlaceId),
    Transition(TransitionId),
}

impl From<PlaceId> for NetNode {
    fn from(place: PlaceId) -> NetNode {
        NetNode::Place(place)
    }
}

impl From<TransitionId> for NetNode {
    fn from(transition: TransitionId) -> NetNode {
        NetNode::Transition(transition)
    }
}

/// An id together with the name it has in its net. Displays as "place `home`" or "transition `start`".
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NamedId<I> {
    /// The number.
    pub id: I,
    pub name: Arc<str>,
}

impl<I: Copy + Into<NetNode>> fmt::Display for NamedId<I> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = match self.id.into() {
            NetNode::Place(_) => "place",
            NetNode::Transition(_) => "transition",
        };
        write!(f, "{kind} `{}`", self.name)
    }
}
