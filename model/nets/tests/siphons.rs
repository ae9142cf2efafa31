//! Siphons and traps against all sets of places, and Commoner's theorem against exploration.

use crate::explicit_ring::ring;
use linewright_nets::siphons::{
    SiphonLimit, SiphonLimits, commoner, largest_empty_siphon, largest_siphon_in, largest_trap_in, minimal_siphons,
    minimal_traps,
};
use linewright_nets::{Net, NetBuilder, PlaceId, explore};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The same nets on every run.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(1972), ..ProptestConfig::default() }
}

/// The sets of places with a property, as bits, by looking at every one.
fn sets(net: &Net, holds: impl Fn(&dyn Fn(PlaceId) -> bool) -> bool) -> Vec<u32> {
    (1..1 << net.place_count()).filter(|set| holds(&|place| set >> place.0 & 1 == 1)).collect()
}

/// •S ⊆ S•, spelled out.
fn siphons(net: &Net) -> Vec<u32> {
    sets(net, |inside| {
        net.transitions().all(|t| {
            let gives = net.postset(t).iter().any(|&(p, _)| inside(p));
            !gives || net.preset(t).iter().any(|&(p, _)| inside(p))
        })
    })
}

/// S• ⊆ •S, spelled out.
fn traps(net: &Net) -> Vec<u32> {
    sets(net, |inside| {
        net.transitions().all(|t| {
            let takes = net.preset(t).iter().any(|&(p, _)| inside(p));
            !takes || net.postset(t).iter().any(|&(p, _)| inside(p))
        })
    })
}

fn minimal(sets: &[u32]) -> Vec<u32> {
    sets.iter().copied().filter(|&set| !sets.iter().any(|&other| other != set && other & !set == 0)).collect()
}

fn bits(places: &[PlaceId]) -> u32 {
    places.iter().map(|place| 1 << place.0).sum()
}

fn all_bits(sets: &[Vec<PlaceId>]) -> Vec<u32> {
    let mut found: Vec<u32> = sets.iter().map(|set| bits(set)).collect();
    found.sort_unstable();
    found
}

fn places(set: u32) -> Vec<PlaceId> {
    (0..32).filter(|place| set >> place & 1 == 1).map(PlaceId).collect()
}

fn union(sets: &[u32], within: u32) -> u32 {
    sets.iter().filter(|&&set| set & !within == 0).fold(0, |union, set| union | set)
}

/// Nets of up to eight places with few arcs, so that the sets are not all alike.
fn sparse_net() -> impl Strategy<Value = Net> {
    let side = |n| prop::collection::btree_map(0..n, 1_u32..=2, 0..=2).prop_map(|arcs| arcs.into_iter().collect());
    (1_usize..=8)
        .prop_flat_map(move |n| {
            let moves = prop::collection::vec((side(n), side(n)), 0..=9);
            (prop::collection::vec(0_u32..=1, n), moves)
        })
        .prop_map(|(tokens, transitions)| crate::common::net(&tokens, &transitions))
}

/// Free-choice nets: each transition either shares its one input place or has its input places to itself.
fn free_choice_net() -> impl Strategy<Value = Net> {
    (2_usize..=6)
        .prop_flat_map(|n| {
            let give = prop::collection::vec(0..n, 1..=2);
            let tokens = prop::collection::vec(0_u32..=1, n);
            (tokens, prop::collection::vec(0_usize..4, n), prop::collection::vec(give, n + 3))
        })
        .prop_map(|(tokens, group, gives)| {
            // Places in one group with a neighbour are synchronised; a place in a group of its own may offer a choice.
            let mut moves: Vec<crate::common::Moves> = Vec::new();
            let mut gives = gives.into_iter();
            let mut place = 0;
            while place < tokens.len() {
                let (taken, ways) = match group[place] {
                    0 if place + 1 < tokens.len() => (vec![place, place + 1], 1),
                    1 => (vec![place], 2),
                    _ => (vec![place], 1),
                };
                for _ in 0..ways {
                    let mut given = gives.next().unwrap_or_default();
                    given.sort_unstable();
                    given.dedup();
                    let arcs = |places: &[usize]| places.iter().map(|&place| (place, 1)).collect();
                    moves.push((arcs(&taken), arcs(&given)));
                }
                place += taken.len();
            }
            crate::common::net(&tokens, &moves)
        })
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn they_are_those_among_all_sets_of_places(net in sparse_net(), any in any::<u32>()) {
        let (siphons, traps) = (siphons(&net), traps(&net));
        prop_assert_eq!(all_bits(&minimal_siphons(&net, &SiphonLimits::default()).unwrap()), minimal(&siphons));
        prop_assert_eq!(all_bits(&minimal_traps(&net, &SiphonLimits::default()).unwrap()), minimal(&traps));

        let all = (1 << net.place_count()) - 1;
        let within = any & all;
        prop_assert_eq!(bits(&largest_siphon_in(&net, &places(within))), union(&siphons, within));
        prop_assert_eq!(bits(&largest_trap_in(&net, &places(within))), union(&traps, within));

        let initial = net.initial_marking();
        let marked: u32 = initial.marked().map(|place| 1 << place.0).sum();
        prop_assert_eq!(bits(&largest_empty_siphon(&net, &initial)), union(&siphons, all & !marked));

        let controlled = |siphon: u32| traps.iter().any(|&trap| trap & !siphon == 0 && trap & marked != 0);
        let feeds = |siphon: u32| places(siphon).iter().any(|&place| !net.consumers(place).is_empty());
        let expected = siphons.iter().all(|&siphon| !feeds(siphon) || controlled(siphon));
        match commoner(&net, &SiphonLimits::default()).unwrap() {
            Ok(()) => prop_assert!(expected),
            Err(why) => {
                prop_assert!(!expected && siphons.contains(&bits(&why.siphon)));
                prop_assert_eq!(bits(&why.trap), union(&traps, bits(&why.siphon)));
                prop_assert!(bits(&why.trap) & marked == 0);
            }
        }
    }

    #[test]
    fn commoners_theorem_decides_liveness_of_free_choice_nets(net in free_choice_net()) {
        prop_assert_eq!(net.is_free_choice(), Ok(()));
        let Ok(explored) = explore(&net, 2_000) else { return Ok(()) };
        let condition = commoner(&net, &SiphonLimits::default()).unwrap();
        prop_assert_eq!(condition.is_ok(), explored.is_live(), "{}", net);
    }

    #[test]
    fn without_weights_the_condition_excludes_deadlocks(net in sparse_net()) {
        let light = |arcs: &[(PlaceId, u32)]| arcs.iter().all(|&(_, weight)| weight == 1);
        let ordinary = net.transitions().all(|t| light(net.preset(t)) && light(net.postset(t)));
        let Ok(explored) = explore(&net, 500) else { return Ok(()) };
        if ordinary && net.transition_count() > 0 && commoner(&net, &SiphonLimits::default()).unwrap().is_ok() {
            prop_assert_eq!(explored.deadlocks().count(), 0, "{}", net);
        }
    }
}

#[test]
fn the_siphons_of_a_long_ring_are_its_circuits() {
    let net = ring(100, false);
    let siphons = minimal_siphons(&net, &SiphonLimits::default()).unwrap();
    assert_eq!(siphons.len(), 202);
    assert_eq!(minimal_traps(&net, &SiphonLimits::default()).unwrap(), siphons);
    assert_eq!(commoner(&net, &SiphonLimits::default()).unwrap(), Ok(()));
    // Without parts, the way round the line on which they would go is empty.
    let uncontrolled = commoner(&ring(10, true), &SiphonLimits::default()).unwrap().unwrap_err();
    assert!(uncontrolled.siphon.len() >= 10);
}

#[test]
fn too_many_are_undecided() {
    // Each of 30 places is fed by a transition that takes from either of two more: 2³⁰ ways to close the first one.
    let mut b = NetBuilder::new("layers");
    let layers: Vec<[PlaceId; 2]> = (0..30).map(|i| [0, 1].map(|side| b.place(format!("p{i}.{side}"), 0))).collect();
    for i in 0..layers.len() {
        for side in 0..2 {
            let t = b.transition(format!("t{i}.{side}"));
            let from = layers[(i + 1) % layers.len()];
            b.output(t, layers[i][side], 1).input(t, from[0], 1).input(t, from[1], 1);
        }
    }
    let net = b.build().unwrap();
    let limits = SiphonLimits { sets: 1_000, ..SiphonLimits::default() };
    let error = minimal_siphons(&net, &limits).unwrap_err();
    assert_eq!((error.cause.clone(), error.sets), (SiphonLimit::Sets, 1_000));
    assert!(error.to_string().starts_with("undecided after 1000 partial sets"), "{error}");
    let limits = SiphonLimits { bytes: 1_000, ..SiphonLimits::default() };
    assert_eq!(minimal_siphons(&net, &limits).unwrap_err().cause, SiphonLimit::Bytes);
}
