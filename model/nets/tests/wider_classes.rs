//! The wider classes of nets against their definitions, spelled out.

use std::collections::BTreeSet;

use linewright_nets::{Net, PlaceId, TransitionId};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The same nets on every run.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(1989), ..ProptestConfig::default() }
}

/// Up to four places and transitions, most arcs of weight 1.
fn small_net() -> impl Strategy<Value = Net> {
    let side = |n| {
        prop::collection::btree_map(0..n, prop_oneof![4 => Just(1_u32), 1 => Just(2)], 0..=2)
            .prop_map(|arcs| arcs.into_iter().collect::<Vec<_>>())
    };
    (1_usize..=4)
        .prop_flat_map(move |n| (prop::collection::vec(0_u32..=2, n), prop::collection::vec((side(n), side(n)), 0..=4)))
        .prop_map(|(tokens, transitions)| crate::common::net(&tokens, &transitions))
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn the_wider_classes_are_what_their_definitions_say(net in small_net()) {
        let consumers = |p: PlaceId| net.consumers(p).iter().map(|&(t, _)| t).collect::<BTreeSet<TransitionId>>();
        let light = net.transitions().all(|t| net.preset(t).iter().chain(net.postset(t)).all(|&(_, weight)| weight == 1));
        let pairs: Vec<_> = net.places().flat_map(|p| net.places().map(move |q| (p, q))).collect();
        let share = |p, q| !consumers(p).is_disjoint(&consumers(q));
        let extended = pairs.iter().all(|&(p, q)| !share(p, q) || consumers(p) == consumers(q));
        let subset = |p, q| consumers(p).is_subset(&consumers(q)) || consumers(q).is_subset(&consumers(p));
        let asymmetric = pairs.iter().all(|&(p, q)| !share(p, q) || subset(p, q));
        prop_assert_eq!(net.is_extended_free_choice().is_ok(), light && extended);
        prop_assert_eq!(net.is_asymmetric_choice().is_ok(), light && asymmetric);
        prop_assert_eq!(net.is_choice_free().is_ok(), net.places().all(|p| consumers(p).len() <= 1));
        prop_assert!(net.is_free_choice().is_err() || net.is_extended_free_choice().is_ok());
    }
}
