//! The linear properties and the wider classes of nets against their definitions, spelled out.

use std::collections::BTreeSet;

use linewright_nets::semiflows::SemiflowLimits;
use linewright_nets::structure::Positive;
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

/// Every vector of `length` numbers from 1 to 4.
fn positive_vectors(length: usize) -> impl Iterator<Item = Vec<i64>> {
    (0..4_u32.pow(length as u32))
        .map(move |code| (0..length as u32).map(|i| i64::from(code / 4_u32.pow(i) % 4) + 1).collect())
}

/// y·C, an entry per transition.
fn by_weights(net: &Net, weights: &[i64]) -> Vec<i64> {
    let c = net.incidence();
    net.transitions().map(|t| c.column(t).iter().map(|&(p, change)| weights[p.index()] * change).sum()).collect()
}

/// C·x, an entry per place.
fn by_counts(net: &Net, counts: &[i64]) -> Vec<i64> {
    let c = net.incidence();
    net.places().map(|p| net.transitions().map(|t| c.entry(p, t) * counts[t.index()]).sum()).collect()
}

fn compare<I>(found: &Positive<I>, length: usize, holds: impl Fn(&[i64]) -> bool) {
    match found {
        Ok(weights) => {
            let weights: Vec<i64> = weights.iter().map(|&weight| weight as i64).collect();
            assert!(weights.len() == length && weights.iter().all(|&weight| weight > 0) && holds(&weights));
        }
        Err(nodes) => {
            assert!(!nodes.is_empty());
            assert!(!positive_vectors(length).any(|vector| holds(&vector)));
        }
    }
}

fn zero(values: Vec<i64>) -> bool {
    values.iter().all(|&value| value == 0)
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn linear_properties_are_what_small_weights_say(net in small_net()) {
        let found = net.linear_properties(&SemiflowLimits::default()).unwrap();
        let (places, transitions) = (net.place_count(), net.transition_count());
        compare(&found.conservative, places, |y| zero(by_weights(&net, y)));
        compare(&found.structurally_bounded, places, |y| by_weights(&net, y).iter().all(|&change| change <= 0));
        compare(&found.consistent, transitions, |x| zero(by_counts(&net, x)));
        compare(&found.repetitive, transitions, |x| by_counts(&net, x).iter().all(|&change| change >= 0));
        // The alternatives of Farkas' lemma: a place that can grow, a transition that wears something out.
        if let Err(grow) = &found.structurally_bounded {
            let grows = |p: PlaceId| {
                (0..4_u32.pow(transitions as u32)).any(|code| {
                    let counts: Vec<i64> = (0..transitions as u32).map(|i| i64::from(code / 4_u32.pow(i) % 4)).collect();
                    let change = by_counts(&net, &counts);
                    change.iter().all(|&change| change >= 0) && change[p.index()] > 0
                })
            };
            let missed = net.places().filter(|&p| grows(p)).find(|p| !grow.contains(p));
            prop_assert_eq!(missed, None);
        }
        if found.full_rank {
            prop_assert!(found.conservative.is_err() || places == 0);
        }
    }

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
