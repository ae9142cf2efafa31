//! Facts about a net after all its markings have been visited.

use crate::{Marking, TransitionId};

/// A marking together with a way to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WitnessMarking {
    pub marking: Marking,
    /// A shortest firing sequence from the initial marking to it.
    pub path: Vec<TransitionId>,
}

/// Markings that can be reached from everywhere.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Home {
    /// Number of markings.
    pub states: u64,
    /// One of these markings.
    pub example: Marking,
}

/// Storage of the markings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// One bit per possible code.
    Bitmap {
        /// Number of codes.
        codes: u64,
    },
    /// A table of exact keys.
    Table {
        /// The bits of a key.
        bits: u32,
    },
}

/// All that [`super::decide`] decides. Every number is exact.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NetFacts {
    /// Reachable markings.
    pub states: u64,
    /// Arcs of the reachability graph: each transition that is enabled at each marking counts.
    pub arcs: u64,
    /// Reachable markings at which nothing is enabled.
    pub deadlocks: u64,
    /// One of the dead markings.
    pub deadlock: Option<WitnessMarking>,
    /// Per place, the most tokens that it ever holds.
    pub bounds: Vec<u32>,
    /// Per transition, whether it fires at some reachable marking.
    pub fires: Vec<bool>,
    /// Per transition that is not live, a reachable marking after which it never fires again.
    pub lost: Vec<Option<Marking>>,
    /// A reachable marking from which the initial one cannot be reached, if there is one.
    pub no_return: Option<Marking>,
    /// Terminal components of the reachability graph: 1 if and only if there are home states.
    pub terminal_components: u64,
    /// The markings that can be reached from every reachable marking, if there are any.
    pub home: Option<Home>,
    /// Storage of the markings.
    pub storage: Storage,
    /// The most bytes that were held at a time; see [`super::ExplorationLimits::bytes`].
    pub bytes: usize,
}

impl NetFacts {
    /// The most tokens that any place ever holds.
    pub fn bound(&self) -> u32 {
        self.bounds.iter().copied().max().unwrap_or(0)
    }

    /// Whether no place ever holds more than one token.
    pub fn is_safe(&self) -> bool {
        self.bound() <= 1
    }

    /// Whether a transition can always be made to fire again.
    pub fn is_transition_live(&self, transition: TransitionId) -> bool {
        self.lost[transition.index()].is_none()
    }

    /// Whether all transitions can.
    pub fn is_live(&self) -> bool {
        self.lost.iter().all(Option::is_none)
    }

    /// Whether the initial marking can be reached from every reachable one.
    pub fn is_reversible(&self) -> bool {
        self.no_return.is_none()
    }
}
