//! The coverability graph against playing everything out, for nets that are bounded and for nets that are not.

use std::collections::HashSet;

use linewright_nets::coverability::{Coverability, CoverabilityLimit, CoverabilityLimits, GrowthWitness, coverability};
use linewright_nets::{Marking, Net, NetBuilder, PlaceId, TransitionId, explore};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The same nets on every run.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(1969), ..ProptestConfig::default() }
}

/// All markings within some steps, and at most so many.
fn some_markings(net: &Net, most: usize) -> Vec<Marking> {
    let mut seen = HashSet::from([net.initial_marking()]);
    let mut found = vec![net.initial_marking()];
    let mut next = 0;
    while next < found.len() && found.len() < most {
        for t in net.transitions() {
            let mut marking = found[next].clone();
            if net.fire(&mut marking, t).is_ok() && seen.insert(marking.clone()) {
                found.push(marking);
            }
        }
        next += 1;
    }
    found
}

fn is_above(label: &[Option<u32>], marking: &Marking) -> bool {
    label.iter().zip(marking.as_slice()).all(|(count, &tokens)| count.is_none_or(|count| count >= tokens))
}

/// The slow tree of Karp and Miller, branch by branch: only a label that is equal to one on its own branch ends it.
fn slow_tree(net: &Net, budget: &mut usize) -> Option<HashSet<Vec<Option<u32>>>> {
    let mut labels = HashSet::new();
    let initial: Vec<_> = net.initial_marking().as_slice().iter().map(|&n| Some(n)).collect();
    branch(net, &mut vec![initial], &mut labels, budget).then_some(labels)
}

fn branch(
    net: &Net,
    path: &mut Vec<Vec<Option<u32>>>,
    labels: &mut HashSet<Vec<Option<u32>>>,
    budget: &mut usize,
) -> bool {
    if *budget == 0 {
        return false;
    }
    *budget -= 1;
    let here = path.last().unwrap().clone();
    labels.insert(here.clone());
    if path[..path.len() - 1].contains(&here) {
        return true;
    }
    for t in net.transitions() {
        let enough = |&(p, weight): &(PlaceId, u32)| here[p.index()].is_none_or(|count| count >= weight);
        if !net.preset(t).iter().all(enough) {
            continue;
        }
        let mut next = here.clone();
        net.preset(t).iter().for_each(|&(p, weight)| next[p.index()] = next[p.index()].map(|count| count - weight));
        net.postset(t).iter().for_each(|&(p, weight)| next[p.index()] = next[p.index()].map(|count| count + weight));
        let reaches =
            |count: Option<u32>, other: Option<u32>| count.is_none() || other.is_some_and(|o| count >= Some(o));
        for before in path.iter() {
            if next.iter().zip(before).all(|(&count, &other)| reaches(count, other)) {
                for (count, other) in next.iter_mut().zip(before) {
                    if *count != *other {
                        *count = None;
                    }
                }
            }
        }
        path.push(next);
        let finished = branch(net, path, labels, budget);
        path.pop();
        if !finished {
            return false;
        }
    }
    true
}

fn replays(net: &Net, pump: &GrowthWitness) -> bool {
    let mut marking = net.initial_marking();
    let mut play = |sequence: &[TransitionId]| {
        sequence.iter().for_each(|&t| net.fire(&mut marking, t).expect("the pump can be played"));
        marking.clone()
    };
    let mut last = play(&pump.prefix);
    for _ in 0..5 {
        let next = play(&pump.cycle);
        let grown: Vec<PlaceId> = net.places().filter(|&place| next.tokens(place) > last.tokens(place)).collect();
        if grown != pump.grows || net.places().any(|place| next.tokens(place) < last.tokens(place)) {
            return false;
        }
        last = next;
    }
    !pump.grows.is_empty()
}

fn agrees_with_exploration(net: &Net, found: &Coverability) {
    let explored = explore(net, 5_000).unwrap();
    assert_eq!(found.is_bounded(), Ok(()));
    assert_eq!(found.labels().count(), explored.states().len());
    for p in net.places() {
        assert_eq!(found.bound_of(p), Some(explored.bound_of(p)));
    }
    let fires: HashSet<TransitionId> = explored.steps().iter().map(|step| step.transition).collect();
    assert!(net.transitions().filter(|t| !fires.contains(t)).eq(found.dead_transitions().iter().copied()));
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn it_agrees_with_playing_everything_out(net in crate::common::any_net(), target in prop::collection::vec(0_u32..=6, 5)) {
        let limits = CoverabilityLimits { labels: 1_000, ..CoverabilityLimits::default() };
        let Ok(found) = coverability(&net, &limits) else { return Ok(()) };
        let markings = some_markings(&net, 1_000);
        for marking in &markings {
            prop_assert!(found.is_coverable(marking));
            prop_assert!(net.enabled(marking).all(|t| !found.dead_transitions().contains(&t)));
        }
        match found.is_bounded() {
            Ok(()) => agrees_with_exploration(&net, &found),
            Err(pump) => {
                prop_assert!(explore(&net, 1_000).is_err());
                prop_assert!(pump.is_valid(&net) && replays(&net, pump), "{:?}", pump);
                prop_assert!(pump.grows.iter().all(|&place| found.bound_of(place).is_none()));
            }
        }
        let target = Marking::from_tokens(target.into_iter().take(net.place_count()));
        let above = markings.iter().any(|marking| marking.as_slice().iter().zip(target.as_slice()).all(|(m, t)| m >= t));
        prop_assert!(!above || found.is_coverable(&target));
    }

    #[test]
    fn it_covers_what_the_slow_tree_covers(net in crate::common::any_net()) {
        let Some(tree) = slow_tree(&net, &mut 3_000) else { return Ok(()) };
        let found = coverability(&net, &CoverabilityLimits::default()).unwrap();
        let most = |place: usize| {
            if tree.iter().any(|label| label[place].is_none()) { None } else { tree.iter().map(|label| label[place]).max().unwrap() }
        };
        for place in net.places() {
            prop_assert_eq!(found.bound_of(place), most(place.index()), "{}", net);
        }
        // Both sets have the same maximal labels; ω is tried as a large count here.
        let high = |count: &Option<u32>| count.unwrap_or(1_000_000);
        for label in &tree {
            prop_assert!(found.is_coverable(&Marking::from_tokens(label.iter().map(high))));
        }
        for label in found.labels() {
            let target = Marking::from_tokens(label.map(|count| high(&count)));
            prop_assert!(tree.iter().any(|label| is_above(label, &target)));
        }
    }

    #[test]
    fn a_conserved_net_is_its_own_graph((net, _) in crate::common::weighed_net()) {
        agrees_with_exploration(&net, &coverability(&net, &CoverabilityLimits::default()).unwrap());
    }
}

/// A store that a supplier fills and a customer empties: nothing limits the store, but its counter does the customer.
fn store() -> Net {
    let mut b = NetBuilder::new("store");
    let [ready, store, served, never] =
        [("ready", 1), ("store", 0), ("served", 0), ("never", 0)].map(|(name, n)| b.place(name, n));
    let [supply, serve, wait] = ["supply", "serve", "wait"].map(|name| b.transition(name));
    b.input(supply, ready, 1).output(supply, ready, 1).output(supply, store, 1);
    b.input(serve, store, 3).input(serve, ready, 1).output(serve, served, 1);
    b.input(wait, never, 1).output(wait, ready, 1);
    b.build().unwrap()
}

#[test]
fn a_store_without_a_limit_is_unbounded_and_its_counter_is_not() {
    let net = store();
    let found = coverability(&net, &CoverabilityLimits::default()).unwrap();
    let place = |name| net.place_named(name).unwrap();
    assert!(found.unbounded().eq([place("store")]));
    assert_eq!((found.bound_of(place("ready")), found.bound_of(place("served"))), (Some(1), Some(1)));
    assert_eq!(found.dead_transitions(), [net.transition_named("wait").unwrap()]);
    assert!(found.is_coverable(&Marking::from_tokens([1, 1_000_000, 0, 0])));
    assert!(found.is_coverable(&Marking::from_tokens([0, 1_000_000, 1, 0])));
    assert!(!found.is_coverable(&Marking::from_tokens([1, 0, 1, 0])));
    assert!(replays(&net, found.is_bounded().unwrap_err()));
}

/// Each label of a drain is compared with all before it, and in the other net all have ω and none covers another.
#[test]
fn what_would_take_hours_of_comparing_is_undecided() {
    let mut b = NetBuilder::new("drain");
    let (pool, drain) = (b.place("pool", 1_000_000), b.transition("drain"));
    b.input(drain, pool, 1);
    let long = b.build().unwrap();

    let mut b = NetBuilder::new("switches");
    let (pool, spring) = (b.place("pool", 0), b.transition("spring"));
    b.output(spring, pool, 1);
    for i in 0..20 {
        let [on, off] = ["on", "off"].map(|name| b.place(format!("{name} {i}"), u32::from(name == "on")));
        let [set, reset] = ["set", "reset"].map(|name| b.transition(format!("{name} {i}")));
        b.input(set, off, 1).output(set, on, 1).input(reset, on, 1).output(reset, off, 1);
    }
    let wide = b.build().unwrap();
    for net in [long, wide] {
        let limits = CoverabilityLimits { comparisons: 10_000_000, ..CoverabilityLimits::default() };
        let stopped = coverability(&net, &limits).unwrap_err();
        assert_eq!(stopped.cause, CoverabilityLimit::Comparisons);
        assert!((1000..100_000).contains(&stopped.labels), "{stopped}");
    }
}

#[test]
fn what_does_not_fit_is_undecided() {
    let limits = CoverabilityLimits { labels: 2, ..CoverabilityLimits::default() };
    let error = coverability(&store(), &limits).unwrap_err();
    assert_eq!((error.labels, error.cause.clone()), (2, CoverabilityLimit::Labels));
    assert_eq!(error.to_string(), "undecided after 2 generalised markings: there are more than allowed");
    let limits = CoverabilityLimits { bytes: 100, ..CoverabilityLimits::default() };
    assert_eq!(coverability(&store(), &limits).unwrap_err().cause, CoverabilityLimit::Bytes);
    let limits = CoverabilityLimits { comparisons: 3, ..CoverabilityLimits::default() };
    assert_eq!(coverability(&store(), &limits).unwrap_err().cause, CoverabilityLimit::Comparisons);

    let mut b = NetBuilder::new("flood");
    let (pool, spring) = (b.place("pool", 1), b.transition("spring"));
    b.output(spring, pool, u32::MAX - 1);
    let error = coverability(&b.build().unwrap(), &CoverabilityLimits::default()).unwrap_err();
    assert!(matches!(error.cause, CoverabilityLimit::Overflow(_)));

    let mut b = NetBuilder::new("full");
    b.place("pool", u32::MAX);
    let error = coverability(&b.build().unwrap(), &CoverabilityLimits::default()).unwrap_err();
    assert!(error.to_string().contains("place `pool` has 4294967295 tokens"), "{error}");
}
