//! The wider classes of nets against their definitions, spelled out.

use std::collections::BTreeSet;

use linewright_nets::{PlaceId, TransitionId};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The same nets on every run.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(1989), ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn the_wider_classes_are_what_their_definitions_say(net in crate::common::light_net(4)) {
        let consumers = |p: PlaceId| net.consumers(p).iter().map(|&(t, _)| t).collect::<BTreeSet<TransitionId>>();
        let light = net.transitions().all(|t| net.preset(t).iter().chain(net.postset(t)).all(|&(_, weight)| weight == 1));
        let pairs: Vec<_> = net.places().flat_map(|p| net.places().map(move |q| (p, q))).collect();
        let share = |p, q| !consumers(p).is_disjoint(&consumers(q));
        let extended = pairs.iter().all(|&(p, q)| !share(p, q) || consumers(p) == consumers(q));
        let subset = |p, q| consumers(p).is_subset(&consumers(q)) || consumers(q).is_subset(&consumers(p));
        let asymmetric = pairs.iter().all(|&(p, q)| !share(p, q) || subset(p, q));
        prop_assert_eq!(net.is_extended_free_choice().is_ok(), light && extended);
        prop_assert_eq!(net.is_asymmetric_choice().is_ok(), light && asymmetric);
        prop_assert!(net.is_free_choice().is_err() || net.is_extended_free_choice().is_ok());
    }
}
