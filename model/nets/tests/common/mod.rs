//! Nets for property tests: written as plain data, so that a failing case can be read.

use linewright_nets::{Net, NetBuilder};
use proptest::prelude::*;

/// A transition as (taken, given), each (place, weight) without repetition.
pub type Moves = (Vec<(usize, u32)>, Vec<(usize, u32)>);

/// Builds a net with places `p0`, `p1`, … and transitions `t0`, `t1`, ….
pub fn net(tokens: &[u32], transitions: &[Moves]) -> Net {
    let mut b = NetBuilder::new("generated");
    let places: Vec<_> = tokens.iter().enumerate().map(|(i, &n)| b.place(format!("p{i}"), n)).collect();
    for (i, (takes, gives)) in transitions.iter().enumerate() {
        let t = b.transition(format!("t{i}"));
        takes.iter().for_each(|&(p, weight)| _ = b.input(t, places[p], weight));
        gives.iter().for_each(|&(p, weight)| _ = b.output(t, places[p], weight));
    }
    b.build().expect("generated nets are sound")
}

/// A state machine from the edges of a graph of places.
pub fn state_machine(tokens: &[u32], edges: &[(usize, usize)]) -> Net {
    let moves: Vec<Moves> = edges.iter().map(|&(from, to)| (vec![(from, 1)], vec![(to, 1)])).collect();
    net(tokens, &moves)
}

/// Up to three tokens, each on one of `places` places.
fn few_tokens(places: usize) -> impl Strategy<Value = Vec<u32>> {
    prop::collection::vec(0..places, 0..=3).prop_map(move |tokens| {
        let mut counts = vec![0; places];
        tokens.into_iter().for_each(|place| counts[place] += 1);
        counts
    })
}

/// Any state machine: connected or not, with loops and parallel transitions.
pub fn any_state_machine() -> impl Strategy<Value = Net> {
    (1_usize..=6)
        .prop_flat_map(|n| (few_tokens(n), prop::collection::vec((0..n, 0..n), 0..=9)))
        .prop_map(|(tokens, edges)| state_machine(&tokens, &edges))
}

/// A state machine that is strongly connected: a ring through all places, and chords.
pub fn connected_state_machine() -> impl Strategy<Value = Net> {
    (1_usize..=6).prop_flat_map(|n| (few_tokens(n), Just(n), prop::collection::vec((0..n, 0..n), 0..=4))).prop_map(
        |(tokens, n, chords)| {
            let ring = (0..n).map(|place| (place, (place + 1) % n));
            state_machine(&tokens, &ring.chain(chords).collect::<Vec<_>>())
        },
    )
}

fn side(places: usize) -> impl Strategy<Value = Vec<(usize, u32)>> {
    prop::collection::btree_map(0..places, 1_u32..=3, 0..=places.min(3)).prop_map(|arcs| arcs.into_iter().collect())
}

/// Up to so many places and transitions, arcs of weight 1 and some of 2: few semiflows have large weights.
pub fn light_net(most: usize) -> impl Strategy<Value = Net> {
    let side = |n| {
        prop::collection::btree_map(0..n, prop_oneof![4 => Just(1_u32), 1 => Just(2)], 0..=2)
            .prop_map(|arcs| arcs.into_iter().collect::<Vec<_>>())
    };
    (1..=most)
        .prop_flat_map(move |n| {
            (prop::collection::vec(0_u32..=2, n), prop::collection::vec((side(n), side(n)), 0..=most))
        })
        .prop_map(|(tokens, transitions)| net(&tokens, &transitions))
}

/// Any place/transition net with weights; may be unbounded.
pub fn any_net() -> impl Strategy<Value = Net> {
    (1_usize..=5)
        .prop_flat_map(|n| (prop::collection::vec(0_u32..=5, n), prop::collection::vec((side(n), side(n)), 1..=5)))
        .prop_map(|(tokens, transitions)| net(&tokens, &transitions))
}

/// A net with a positive place invariant, hence bounded, and the invariant. Each transition turns tokens of one place
/// into tokens of another at the rate of their weights, and needs a third place without using it up.
pub fn weighed_net() -> impl Strategy<Value = (Net, Vec<u32>)> {
    (2_usize..=4)
        .prop_flat_map(|n| {
            let weights = prop::collection::vec(1_u32..=3, n);
            let tokens = prop::collection::vec(0_u32..=3, n);
            (weights, tokens, prop::collection::vec((0..n, 0..n, 0..n), 1..=5))
        })
        .prop_map(|(weights, tokens, exchanges)| {
            let turn = |(from, to, needs): (usize, usize, usize)| {
                let (mut takes, mut gives) = (vec![(from, weights[to])], vec![(to, weights[from])]);
                if needs != from && needs != to {
                    takes.push((needs, 1));
                    gives.push((needs, 1));
                }
                (takes, gives)
            };
            let transitions: Vec<Moves> = exchanges.into_iter().map(turn).collect();
            (net(&tokens, &transitions), weights)
        })
}
