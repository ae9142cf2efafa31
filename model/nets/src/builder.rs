//! Builder of nets, and their one check.
//!
//! A builder accepts everything, so that the code which generates a net need not stop at each arc; [`NetBuilder::build`]
//! then reports *all* errors, or returns a [`Net`] whose arcs resolve, whose weights are positive and whose names are
//! unique. Nothing after that has to check again.
//!
//! A builder cannot distinguish the ids of another builder from its own as long as they are in range.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use thiserror::Error;

use crate::net::Adjacency;
use crate::{Marking, NamedId, Net, PlaceId, TransitionId};

/// The largest number of places, and of transitions. A line of hundreds of stations has tens of thousands; sixteen
/// million come from a faulty generator, which should get the error before the memory is used up.
pub const MAX_NODES: usize = 1 << 24;

/// The direction of an arc.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ArcDirection {
    /// From a place to a transition (the relation Pre).
    Input,
    /// From a transition to a place (the relation Post).
    Output,
}

/// An arc, as error messages name it: "place `home` → transition `start`".
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ArcName {
    /// The end that is the place.
    pub direction: ArcDirection,
    /// The place at one end.
    pub place: NamedId<PlaceId>,
    /// The transition at the other.
    pub transition: NamedId<TransitionId>,
}

impl fmt::Display for ArcName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.direction {
            ArcDirection::Input => write!(f, "{} → {}", self.place, self.transition),
            ArcDirection::Output => write!(f, "{} → {}", self.transition, self.place),
        }
    }
}

/// One error of a net under construction.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum NetError {
    /// A net has at least one place or transition (seed 002 §3.1: P ∪ T ≠ ∅).
    #[error("the net has neither a place nor a transition")]
    Empty,
    /// Two places have the same name.
    #[error("two places are named `{name}` (#{} and #{})", first.0, second.0)]
    DuplicatePlace {
        name: Arc<str>,
        first: PlaceId,
        /// Another that has it.
        second: PlaceId,
    },
    /// Two transitions have the same name.
    #[error("two transitions are named `{name}` (#{} and #{})", first.0, second.0)]
    DuplicateTransition {
        name: Arc<str>,
        first: TransitionId,
        /// Another that has it.
        second: TransitionId,
    },
    /// An arc at a place that was not declared.
    #[error("the arc {arc} names place #{}, but the net has {places} places", arc.place.id.0)]
    UnknownPlace {
        arc: ArcName,
        /// Number of places declared.
        places: usize,
    },
    /// An arc at a transition that was not declared.
    #[error("the arc {arc} names transition #{}, but the net has {transitions} transitions", arc.transition.id.0)]
    UnknownTransition {
        arc: ArcName,
        /// Number of transitions declared.
        transitions: usize,
    },
    /// An arc that would move no token.
    #[error("the arc {arc} has weight 0")]
    ZeroWeight { arc: ArcName },
    /// The same two nodes are joined more than once in the same direction; a weight is for that.
    #[error("the arc {arc} is declared {times} times")]
    DuplicateArc {
        arc: ArcName,
        /// Number of declarations.
        times: usize,
    },
    /// More places than [`MAX_NODES`].
    #[error("the net has {count} places; at most {limit} are possible")]
    TooManyPlaces {
        /// Number declared.
        count: usize,
        limit: usize,
    },
    /// More transitions than [`MAX_NODES`].
    #[error("the net has {count} transitions; at most {limit} are possible")]
    TooManyTransitions {
        /// Number declared.
        count: usize,
        limit: usize,
    },
}

/// An arc as declared. The derived order groups duplicates and puts arcs in the order of the tables.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct DeclaredArc {
    direction: ArcDirection,
    transition: TransitionId,
    place: PlaceId,
    weight: u32,
}

/// A marked net under construction.
#[derive(Clone)]
pub struct NetBuilder {
    name: String,
    places: Vec<Arc<str>>,
    tokens: Vec<u32>,
    transitions: Vec<Arc<str>>,
    arcs: Vec<DeclaredArc>,
    /// Declarations, those beyond the limit included; the names of those are dropped.
    places_declared: usize,
    transitions_declared: usize,
    limit: usize,
}

impl NetBuilder {
    /// A net with nothing in it yet.
    pub fn new(name: impl Into<String>) -> Self {
        NetBuilder {
            name: name.into(),
            places: Vec::new(),
            tokens: Vec::new(),
            transitions: Vec::new(),
            arcs: Vec::new(),
            places_declared: 0,
            transitions_declared: 0,
            limit: MAX_NODES,
        }
    }

    /// Declares a place and the tokens it has in the initial marking.
    pub fn place(&mut self, name: impl Into<String>, tokens: u32) -> PlaceId {
        let id = PlaceId(dense(self.places_declared));
        self.places_declared += 1;
        if self.places.len() < self.limit {
            self.places.push(name.into().into());
            self.tokens.push(tokens);
        }
        id
    }

    /// Declares a transition.
    pub fn transition(&mut self, name: impl Into<String>) -> TransitionId {
        let id = TransitionId(dense(self.transitions_declared));
        self.transitions_declared += 1;
        if self.transitions.len() < self.limit {
            self.transitions.push(name.into().into());
        }
        id
    }

    /// Declares that firing `transition` takes `weight` tokens from `place`.
    pub fn input(&mut self, transition: TransitionId, place: PlaceId, weight: u32) -> &mut Self {
        self.arcs.push(DeclaredArc { direction: ArcDirection::Input, transition, place, weight });
        self
    }

    /// Declares that firing `transition` puts `weight` tokens on `place`.
    pub fn output(&mut self, transition: TransitionId, place: PlaceId, weight: u32) -> &mut Self {
        self.arcs.push(DeclaredArc { direction: ArcDirection::Output, transition, place, weight });
        self
    }

    /// The net, or all its errors: sizes first, then names, then arcs.
    pub fn build(mut self) -> Result<Net, Vec<NetError>> {
        self.arcs.sort_unstable();
        let mut problems = Vec::new();
        self.check_sizes(&mut problems);
        self.check_names(&mut problems);
        self.check_arcs(&mut problems);
        if !problems.is_empty() {
            return Err(problems);
        }

        let by_transition = |direction| {
            let arcs = self.arcs.iter().filter(move |arc| arc.direction == direction);
            Adjacency::new(self.transitions.len(), arcs.map(|arc| (arc.transition.index(), (arc.place, arc.weight))))
        };
        let by_place = |direction| {
            let arcs = self.arcs.iter().filter(move |arc| arc.direction == direction);
            Adjacency::new(self.places.len(), arcs.map(|arc| (arc.place.index(), (arc.transition, arc.weight))))
        };
        let (presets, postsets) = (by_transition(ArcDirection::Input), by_transition(ArcDirection::Output));
        let (consumers, producers) = (by_place(ArcDirection::Input), by_place(ArcDirection::Output));
        Ok(Net {
            name: self.name,
            place_by_name: self.places.iter().cloned().zip((0..).map(PlaceId)).collect(),
            transition_by_name: self.transitions.iter().cloned().zip((0..).map(TransitionId)).collect(),
            place_names: self.places,
            transition_names: self.transitions,
            presets,
            postsets,
            consumers,
            producers,
            initial: Marking::from_tokens(self.tokens),
        })
    }

    fn check_sizes(&self, problems: &mut Vec<NetError>) {
        let (places, transitions, limit) = (self.places_declared, self.transitions_declared, self.limit);
        if places + transitions == 0 {
            problems.push(NetError::Empty);
        }
        if places > limit {
            problems.push(NetError::TooManyPlaces { count: places, limit });
        }
        if transitions > limit {
            problems.push(NetError::TooManyTransitions { count: transitions, limit });
        }
    }

    fn check_names(&self, problems: &mut Vec<NetError>) {
        for (name, first, second) in duplicates(&self.places) {
            problems.push(NetError::DuplicatePlace { name, first: PlaceId(first), second: PlaceId(second) });
        }
        for (name, first, second) in duplicates(&self.transitions) {
            let (first, second) = (TransitionId(first), TransitionId(second));
            problems.push(NetError::DuplicateTransition { name, first, second });
        }
    }

    /// Expects the arcs sorted, so that duplicates are neighbours.
    fn check_arcs(&self, problems: &mut Vec<NetError>) {
        for arc in &self.arcs {
            if arc.place.index() >= self.places_declared {
                problems.push(NetError::UnknownPlace { arc: self.named(arc), places: self.places_declared });
            }
            if arc.transition.index() >= self.transitions_declared {
                let transitions = self.transitions_declared;
                problems.push(NetError::UnknownTransition { arc: self.named(arc), transitions });
            }
            if arc.weight == 0 {
                problems.push(NetError::ZeroWeight { arc: self.named(arc) });
            }
        }
        let ends = |arc: &DeclaredArc| (arc.direction, arc.transition, arc.place);
        for same in self.arcs.chunk_by(|a, b| ends(a) == ends(b)).filter(|same| same.len() > 1) {
            problems.push(NetError::DuplicateArc { arc: self.named(&same[0]), times: same.len() });
        }
    }

    /// An arc with the names of its ends; an end that was never declared is shown by its number.
    fn named(&self, arc: &DeclaredArc) -> ArcName {
        let name = |names: &[Arc<str>], id: u32| names.get(id as usize).cloned().unwrap_or(format!("#{id}").into());
        ArcName {
            direction: arc.direction,
            place: NamedId { id: arc.place, name: name(&self.places, arc.place.0) },
            transition: NamedId { id: arc.transition, name: name(&self.transitions, arc.transition.0) },
        }
    }
}

/// The id of the next declaration. Beyond 32 bits all share the last id; the net is refused for its size by then.
fn dense(declared: usize) -> u32 {
    u32::try_from(declared).unwrap_or(u32::MAX)
}

/// Every name that is not the first of its kind, with the position of the first and its own.
fn duplicates(names: &[Arc<str>]) -> Vec<(Arc<str>, u32, u32)> {
    let mut first_of: HashMap<&str, u32> = HashMap::with_capacity(names.len());
    let mut found = Vec::new();
    for (name, position) in names.iter().zip(0..) {
        let first = *first_of.entry(name).or_insert(position);
        if first != position {
            found.push((name.clone(), first, position));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn messages(builder: NetBuilder) -> Vec<String> {
        builder.build().unwrap_err().iter().map(ToString::to_string).collect()
    }

    #[test]
    fn every_problem_is_reported_at_once() {
        let mut b = NetBuilder::new("bad");
        let home = b.place("home", 1);
        b.place("home", 0);
        let start = b.transition("start");
        b.transition("start");
        b.input(start, home, 0);
        b.output(start, home, 1).output(start, home, 2);
        b.input(TransitionId(7), PlaceId(9), 1);
        assert_eq!(
            messages(b),
            [
                "two places are named `home` (#0 and #1)",
                "two transitions are named `start` (#0 and #1)",
                "the arc place `home` → transition `start` has weight 0",
                "the arc place `#9` → transition `#7` names place #9, but the net has 2 places",
                "the arc place `#9` → transition `#7` names transition #7, but the net has 2 transitions",
                "the arc transition `start` → place `home` is declared 2 times",
            ]
        );
    }

    #[test]
    fn a_net_has_at_least_one_node() {
        assert_eq!(NetBuilder::new("nothing").build().unwrap_err(), [NetError::Empty]);
    }

    #[test]
    fn sizes_are_bounded() {
        let mut b = NetBuilder::new("big");
        b.limit = 2;
        for i in 0..3 {
            let p = b.place(format!("p{i}"), 0);
            let t = b.transition(format!("t{i}"));
            b.input(t, p, 1);
        }
        assert_eq!(
            b.build().unwrap_err(),
            [NetError::TooManyPlaces { count: 3, limit: 2 }, NetError::TooManyTransitions { count: 3, limit: 2 }]
        );
    }

    #[test]
    fn a_place_and_a_transition_may_share_a_name() {
        let mut b = NetBuilder::new("n");
        let p = b.place("clamp", 1);
        let t = b.transition("clamp");
        b.input(t, p, 1);
        let net = b.build().unwrap();
        assert_eq!(net.place_named("clamp"), Some(p));
        assert_eq!(net.transition_named("clamp"), Some(t));
    }
}
