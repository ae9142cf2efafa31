//! The classes of nets for which structure alone decides behaviour.
//!
//! A state machine has choice but no synchronisation, a marked graph has synchronisation but no choice, and a
//! free-choice net keeps the two apart. All three classes are defined for nets whose arcs have weight 1, as all arcs of
//! seed 002 do; a heavier arc is therefore a counterexample to each of them.

use thiserror::Error;

use crate::{ArcDirection, ArcName, NamedId, Net, PlaceId, TransitionId};

/// An arc that moves more than one token at a time.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("the arc {arc} has weight {weight}")]
pub struct HeavyArc {
    pub arc: ArcName,
    /// Its weight, at least 2.
    pub weight: u32,
}

/// Reason why a net is no state machine.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum NotStateMachine {
    /// |•t| ≠ 1: the transition synchronises, or needs nothing.
    #[error("{transition} has {count} input places, not 1")]
    Inputs {
        transition: NamedId<TransitionId>,
        /// |•t|.
        count: usize,
    },
    /// |t•| ≠ 1: the transition forks, or leads nowhere.
    #[error("{transition} has {count} output places, not 1")]
    Outputs {
        transition: NamedId<TransitionId>,
        /// |t•|.
        count: usize,
    },
    #[error(transparent)]
    Weight(HeavyArc),
}

/// Reason why a net is no marked graph.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum NotMarkedGraph {
    /// |•p| ≠ 1.
    #[error("{place} has {count} input transitions, not 1")]
    Producers {
        place: NamedId<PlaceId>,
        /// |•p|.
        count: usize,
    },
    /// |p•| ≠ 1: there is a choice, or nothing leads on.
    #[error("{place} has {count} output transitions, not 1")]
    Consumers {
        place: NamedId<PlaceId>,
        /// |p•|.
        count: usize,
    },
    #[error(transparent)]
    Weight(HeavyArc),
}

/// Reason why a net is not free-choice.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum NotFreeChoice {
    /// The place offers a choice, and one of the candidates also waits for another place.
    #[error("{place} offers the choice between {chosen} and {other}, but {chosen} also waits for {waits_for}")]
    Entangled {
        place: NamedId<PlaceId>,
        /// The candidate that is not free.
        chosen: NamedId<TransitionId>,
        /// Another candidate.
        other: NamedId<TransitionId>,
        /// The other place that `chosen` needs.
        waits_for: NamedId<PlaceId>,
    },
    #[error(transparent)]
    Weight(HeavyArc),
}

impl Net {
    /// Whether |•t| = |t•| = 1 for every transition (seed 002 §3.1, Definition 4). Tokens are then neither made nor
    /// lost, and none waits for another.
    pub fn is_state_machine(&self) -> Result<(), NotStateMachine> {
        for t in self.transitions() {
            let (inputs, outputs) = (self.preset(t).len(), self.postset(t).len());
            if inputs != 1 {
                return Err(NotStateMachine::Inputs { transition: self.transition(t), count: inputs });
            }
            if outputs != 1 {
                return Err(NotStateMachine::Outputs { transition: self.transition(t), count: outputs });
            }
        }
        self.heavy_arc().map_or(Ok(()), |heavy| Err(NotStateMachine::Weight(heavy)))
    }

    /// Whether |•p| = |p•| = 1 for every place: the mirror image of a state machine.
    pub fn is_marked_graph(&self) -> Result<(), NotMarkedGraph> {
        for p in self.places() {
            let (producers, consumers) = (self.producers(p).len(), self.consumers(p).len());
            if producers != 1 {
                return Err(NotMarkedGraph::Producers { place: self.place(p), count: producers });
            }
            if consumers != 1 {
                return Err(NotMarkedGraph::Consumers { place: self.place(p), count: consumers });
            }
        }
        self.heavy_arc().map_or(Ok(()), |heavy| Err(NotMarkedGraph::Weight(heavy)))
    }

    /// Whether every arc from a place to a transition is the only one from that place or the only one to that
    /// transition: where there is a choice there is no wait. State machines and marked graphs are free-choice.
    pub fn is_free_choice(&self) -> Result<(), NotFreeChoice> {
        for p in self.places() {
            let [(first, _), (second, _), ..] = *self.consumers(p) else { continue };
            for &(t, _) in self.consumers(p) {
                if let Some(&(waits_for, _)) = self.preset(t).iter().find(|&&(place, _)| place != p) {
                    return Err(NotFreeChoice::Entangled {
                        place: self.place(p),
                        chosen: self.transition(t),
                        other: self.transition(if t == first { second } else { first }),
                        waits_for: self.place(waits_for),
                    });
                }
            }
        }
        self.heavy_arc().map_or(Ok(()), |heavy| Err(NotFreeChoice::Weight(heavy)))
    }

    /// The first arc whose weight is not 1.
    pub(super) fn heavy_arc(&self) -> Option<HeavyArc> {
        let heavy = |direction, t, arcs: &[(PlaceId, u32)]| {
            arcs.iter().find(|&&(_, weight)| weight > 1).map(|&(place, weight)| HeavyArc {
                arc: ArcName { direction, place: self.place(place), transition: self.transition(t) },
                weight,
            })
        };
        self.transitions().find_map(|t| {
            heavy(ArcDirection::Input, t, self.preset(t)).or_else(|| heavy(ArcDirection::Output, t, self.postset(t)))
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::NetBuilder;
    use crate::structure::testnets::{net, why};

    #[test]
    fn a_state_machine_chooses_and_never_synchronises() {
        assert_eq!(why(net(&["a>b", "a>c", "b>a", "c>a"]).is_state_machine()), "yes");
        assert_eq!(why(net(&["a>b", "ab>c"]).is_state_machine()), "transition `ab>c` has 2 input places, not 1");
        assert_eq!(why(net(&["a>"]).is_state_machine()), "transition `a>` has 0 output places, not 1");
    }

    #[test]
    fn a_marked_graph_synchronises_and_never_chooses() {
        assert_eq!(why(net(&["ab>cd", "c>a", "d>b"]).is_marked_graph()), "yes");
        assert_eq!(why(net(&["ab>cd", "c>a", "c>b"]).is_marked_graph()), "place `c` has 2 output transitions, not 1");
        assert_eq!(why(net(&["a>b"]).is_marked_graph()), "place `a` has 0 input transitions, not 1");
    }

    #[test]
    fn free_choice_keeps_choice_and_synchronisation_apart() {
        assert_eq!(why(net(&["a>b", "a>c", "bc>d", "d>a"]).is_free_choice()), "yes");
        assert_eq!(
            why(net(&["a>c", "ab>d"]).is_free_choice()),
            "place `a` offers the choice between transition `ab>d` and transition `a>c`, \
             but transition `ab>d` also waits for place `b`"
        );
    }

    #[test]
    fn the_classes_are_those_of_nets_without_weights() {
        let mut b = NetBuilder::new("n");
        let (p, t) = (b.place("p", 0), b.transition("t"));
        b.input(t, p, 1).output(t, p, 2);
        let net = b.build().unwrap();
        let heavy = "the arc transition `t` → place `p` has weight 2";
        assert_eq!(why(net.is_state_machine()), heavy);
        assert_eq!(why(net.is_marked_graph()), heavy);
        assert_eq!(why(net.is_free_choice()), heavy);
    }
}
