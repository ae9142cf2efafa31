//! Nets of each class, drawn from a fixed seed: the same ones on every run.

use linewright_nets::{Net, NetBuilder};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

/// The first `count` values of a strategy.
pub fn samples<S: Strategy>(strategy: S, count: usize) -> Vec<S::Value> {
    let mut runner = TestRunner::deterministic();
    (0..count).map(|_| strategy.new_tree(&mut runner).expect("the strategy rejects nothing").current()).collect()
}

/// Any marked graph: connected or not, live or not, bounded or not.
pub fn marked_graph() -> impl Strategy<Value = Net> {
    (1_usize..=5)
        .prop_flat_map(|n| (Just(n), prop::collection::vec((0..n, 0..n, 0_u32..=2), 0..=8)))
        .prop_map(|(transitions, edges)| from_edges(transitions, &edges))
}

/// A marked graph in which every place is on a circuit, hence bounded.
pub fn connected_marked_graph() -> impl Strategy<Value = Net> {
    (1_usize..=5)
        .prop_flat_map(|n| {
            let ring = prop::collection::vec(0_u32..=1, n);
            (Just(n), ring, prop::collection::vec((0..n, 0..n, 0_u32..=2), 0..=4))
        })
        .prop_map(|(n, ring, chords)| {
            let ring = ring.into_iter().enumerate().map(|(i, tokens)| (i, (i + 1) % n, tokens));
            from_edges(n, &ring.chain(chords).collect::<Vec<_>>())
        })
}

/// Transitions as nodes, places as edges (from, to, tokens).
fn from_edges(transitions: usize, edges: &[(usize, usize, u32)]) -> Net {
    let mut b = NetBuilder::new("graph");
    let transitions: Vec<_> = (0..transitions).map(|i| b.transition(format!("t{i}"))).collect();
    for (i, &(from, to, tokens)) in edges.iter().enumerate() {
        let place = b.place(format!("p{i}"), tokens);
        b.output(transitions[from], place, 1).input(transitions[to], place, 1);
    }
    b.build().unwrap()
}

/// Arcs as sets of indices: what each transition takes and gives.
#[derive(Clone, Debug)]
struct Raw {
    places: usize,
    moves: Vec<(Vec<usize>, Vec<usize>)>,
}

impl Raw {
    /// One step of a synthesis that keeps a net free-choice, and live and bounded under some marking.
    fn refine(&mut self, step: u8, at: usize) {
        let (place, t) = (at % self.places, at % self.moves.len());
        match step {
            // A place in the middle of a transition.
            0 => {
                let gives = std::mem::replace(&mut self.moves[t].1, vec![self.places]);
                self.moves.push((vec![self.places], gives));
                self.places += 1;
            }
            // A transition in the middle of a place.
            1 => {
                for (takes, _) in &mut self.moves {
                    takes.iter_mut().filter(|taken| **taken == place).for_each(|taken| *taken = self.places);
                }
                self.moves.push((vec![place], vec![self.places]));
                self.places += 1;
            }
            // A second way to do what a transition does.
            2 => self.moves.push(self.moves[t].clone()),
            // A second place beside a place.
            _ => {
                for side in self.moves.iter_mut().flat_map(|(takes, gives)| [takes, gives]) {
                    if side.contains(&place) {
                        side.push(self.places);
                    }
                }
                self.places += 1;
            }
        }
    }

    fn build(&self, tokens: &[u32]) -> Net {
        let side = |places: &[usize]| places.iter().map(|&place| (place, 1)).collect();
        let moves: Vec<_> = self.moves.iter().map(|(takes, gives)| (side(takes), side(gives))).collect();
        crate::common::net(&tokens[..self.places], &moves)
    }
}

/// A choice between two ways to fork, the branches of which come together before they join. With a token on the left
/// branch of one way and on the right branch of the other it is live, but never comes back to that.
fn crossed() -> Raw {
    let [c, a1, a2, b1, b2, a, b] = [0, 1, 2, 3, 4, 5, 6];
    let moves = [
        (vec![c], vec![a1, b1]),
        (vec![c], vec![a2, b2]),
        (vec![a1], vec![a]),
        (vec![a2], vec![a]),
        (vec![b1], vec![b]),
        (vec![b2], vec![b]),
        (vec![a, b], vec![c]),
    ];
    Raw { places: 7, moves: moves.into() }
}

/// A free-choice net made from a single loop, or from [`crossed`]; with a marking that may or may not suit it, and with at
/// most one arc that does not belong there.
pub fn free_choice_net() -> impl Strategy<Value = Net> {
    let steps = prop::collection::vec((0_u8..4, 0_usize..100), 0..=7);
    let tokens = prop::collection::vec(prop_oneof![6 => Just(0_u32), 3 => Just(1), 1 => Just(2)], 14);
    let extra = prop::option::weighted(0.2, (0_usize..100, 0_usize..100));
    (prop::bool::weighted(0.3), steps, tokens, extra).prop_map(|(cross, steps, tokens, extra)| {
        let mut raw = if cross { crossed() } else { Raw { places: 1, moves: vec![(vec![0], vec![0])] } };
        let most = if cross { 3 } else { 7 };
        steps.into_iter().take(most).for_each(|(step, at)| raw.refine(step, at));
        if let Some((t, place)) = extra {
            let (t, place) = (t % raw.moves.len(), place % raw.places);
            if !raw.moves[t].1.contains(&place) {
                raw.moves[t].1.push(place);
            }
        }
        raw.build(&tokens)
    })
}
