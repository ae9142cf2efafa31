//! Published results about plain nets, recomputed: Colombo, *Hierarchical control structures of flexible production
//! systems using high-level Petri nets*, 1998 (seed 000).
//!
//! The drawings of the nets are lost. What the text prints is asserted as printed; what had to be rebuilt is marked.

use linewright_nets::certificate::{NetProperty, check, decide_by_structure};
use linewright_nets::coverability::{self, coverability};
use linewright_nets::semiflows::{Semiflow, SemiflowLimits, Semiflows, place_semiflows, transition_semiflows};
use linewright_nets::{Net, NetBuilder, PlaceId, TransitionId, explore};

/// The places of the sub-net, in the order in which its place flows are printed (L2480-2485).
const PLACES: [&str; 9] = ["pa", "pb", "pc", "pd", "pe", "pf", "pg", "ph", "pi"];

/// The four printed place flows, as supports.
const PRINTED: [&[&str]; 4] = [
    &["pd", "pe", "pf"],
    &["pa", "pb", "pc"],
    &["pd", "pe", "pf", "pg", "ph"],
    &["pa", "pb", "pc", "pd", "pe", "pf", "pg", "ph", "pi"],
];

/// The sub-net that refines "robot 1 loads robot 2" (Fig. 30), for its one firing mode, without colours.
///
/// Printed: nine places, eight transitions (L2487), robot 2 passes pa, pb, pc and robot 1 passes pd, pe, pf, each in
/// that order (L2498-2509). Rebuilt: which transition joins which places, and pi as the monitor place that is marked
/// while the operation is not under way.
fn loading() -> NetBuilder {
    let mut b = NetBuilder::new("robot 1 loads robot 2");
    let places = PLACES.map(|name| b.place(name, u32::from(name == "pi")));
    let place = |name: &str| places[PLACES.iter().position(|&other| other == name).unwrap()];
    for (name, takes, gives) in [
        ("Start", vec!["pi"], vec!["pa"]),
        ("ta", vec!["pa"], vec!["pb"]),
        ("tb", vec!["pb"], vec!["pc", "pg"]),
        ("tc", vec!["pg"], vec!["pd"]),
        ("td", vec!["pd"], vec!["pe"]),
        ("te", vec!["pe"], vec!["pf"]),
        ("tf", vec!["pf"], vec!["ph"]),
        ("End", vec!["pc", "ph"], vec!["pi"]),
    ] {
        let t = b.transition(name);
        takes.into_iter().for_each(|name| _ = b.input(t, place(name), 1));
        gives.into_iter().for_each(|name| _ = b.output(t, place(name), 1));
    }
    b
}

fn supports(net: &Net, flows: &Semiflows<PlaceId>) -> Vec<Vec<String>> {
    let names = |flow: &Semiflow<PlaceId>| flow.support().map(|p| net.place_name(p).to_owned()).collect();
    flows.all().iter().map(names).collect()
}

fn weights(net: &Net, places: &[&str]) -> Vec<i64> {
    net.places().map(|p| i64::from(places.contains(&net.place_name(p)))).collect()
}

#[test]
fn the_sub_net_of_loading_has_its_printed_transition_flow() {
    let net = loading().build().unwrap();
    assert_eq!((net.place_count(), net.transition_count()), (9, 8));
    // L2487 and Proposition 18 (L2465): one transition flow, and all eight transitions are in it, once each.
    let flows = transition_semiflows(&net, &SemiflowLimits::default()).unwrap();
    let all: Vec<_> = net.transitions().map(|t| (t, 1)).collect();
    assert_eq!(flows.all(), [Semiflow { weights: all }]);
    // L2514: {Start, ta, tb, tc, td, te, tf, End} returns to the initial marking.
    let mut marking = net.initial_marking();
    for name in ["Start", "ta", "tb", "tc", "td", "te", "tf", "End"] {
        net.fire(&mut marking, net.transition_named(name).unwrap()).unwrap();
    }
    assert_eq!(marking, net.initial_marking());
}

#[test]
fn of_the_four_printed_place_flows_two_are_minimal_once_closed() {
    let net = loading().build().unwrap();
    let flows = place_semiflows(&net, &SemiflowLimits::default()).unwrap();
    // The printed supports lie in each other, flow 1 in flow 3 in flow 4, so not all four can be minimal. What the net
    // has is flow 2 (robot 2) closed by pi, and flow 3 (coordination) closed by the part that the robots share.
    assert_eq!(
        supports(&net, &flows),
        [vec!["pa", "pb", "pc", "pi"], vec!["pa", "pb", "pd", "pe", "pf", "pg", "ph", "pi"]]
    );
    let all: Vec<&str> = flows.all()[1].support().map(|p| net.place_name(p)).chain(["pc"]).collect();
    assert_eq!(all.len(), PRINTED[3].len(), "flow 4, all tasks, is the support of their sum");
    for (printed, closing) in [(PRINTED[1], &["pi"][..]), (PRINTED[2], &["pa", "pb", "pi"])] {
        assert!(net.incidence().place_invariant(&weights(&net, printed)).is_err());
        assert_eq!(net.incidence().place_invariant(&weights(&net, &[printed, closing].concat())), Ok(()));
    }
    assert!(net.incidence().place_invariant(&weights(&net, PRINTED[0])).is_err());
    // L2495: pd, pe and pf hold at most one token and exclude each other.
    let initial = net.initial_marking();
    let [pd, pe, pf] = ["pd", "pe", "pf"].map(|name| net.place_named(name).unwrap());
    for (a, b) in [(pd, pe), (pe, pf), (pd, pf)] {
        assert!(flows.excludes(a, b, &initial).is_some());
        assert_eq!(flows.bound(a, &initial).unwrap().0, 1);
    }
    // Requirements R1 and R5 (L2444, L2461): all places and transitions are covered. R7 (L2472): live.
    assert_eq!(flows.uncovered(&net).count(), 0);
    let verdict = decide_by_structure(&net);
    for property in NetProperty::ALL {
        assert_eq!(verdict.answer(property).holds(), Some(true), "{property}");
        assert_eq!(check(&net, verdict.answer(property).certificate().unwrap()), Ok(()));
    }
}

/// The error pattern (Fig. 50) without colours and timer: a task pa that tb ends, or that the watchdog tc ends, which
/// marks pe and unmarks its complement. Whether pe is ever unmarked again is not part of the pattern; `recovery` adds
/// t_rec for that, which the text describes but does not draw here (L3122-3129).
fn watchdog(recovery: bool) -> Net {
    let mut b = NetBuilder::new("watchdog");
    let [pa, error, no_error] = [("pa", 0), ("pe", 0), ("~pe", 1)].map(|(name, n)| b.place(name, n));
    let [ta, tb, tc] = ["ta", "tb", "tc"].map(|name| b.transition(name));
    b.output(ta, pa, 1).input(tb, pa, 1);
    b.input(tc, pa, 1).input(tc, no_error, 1).output(tc, error, 1);
    if recovery {
        let t = b.transition("t_rec");
        b.input(t, error, 1).output(t, no_error, 1);
    }
    b.build().unwrap()
}

fn counts(flows: &Semiflows<TransitionId>, net: &Net) -> Vec<Vec<String>> {
    let names = |flow: &Semiflow<TransitionId>| flow.support().map(|t| net.transition_name(t).to_owned()).collect();
    flows.all().iter().map(names).collect()
}

#[test]
fn the_places_of_the_watchdog_are_a_place_flow_and_exclude_each_other() {
    for recovery in [false, true] {
        let net = watchdog(recovery);
        let flows = place_semiflows(&net, &SemiflowLimits::default()).unwrap();
        // L3058: the sum of pe and ~pe is the one error token; L3059: they are never both marked.
        assert_eq!(supports(&net, &flows), [["pe", "~pe"]]);
        let [error, no_error] = ["pe", "~pe"].map(|name| net.place_named(name).unwrap());
        assert_eq!(flows.all()[0].sum(&net.initial_marking()), 1);
        assert!(flows.excludes(error, no_error, &net.initial_marking()).is_some());
        // The pattern is open: nothing in it limits how many tasks are begun.
        let found = coverability(&net, &coverability::CoverabilityLimits::default()).unwrap();
        assert!(found.unbounded().eq([net.place_named("pa").unwrap()]));
    }
}

#[test]
fn the_normal_sequence_is_a_transition_flow_and_the_error_sequence_needs_a_recovery() {
    let net = watchdog(false);
    let flows = transition_semiflows(&net, &SemiflowLimits::default()).unwrap();
    // L3060: [ta tb 0] is a canonical transition flow.
    assert_eq!(counts(&flows, &net), [["ta", "tb"]]);
    // L3061 prints [ta 0 tc] as one too. It is not while tc moves the token from ~pe to pe …
    let change = |t| net.incidence().entry(net.place_named("pe").unwrap(), TransitionId(t));
    assert_eq!(change(0) + change(2), 1);
    // … and is, with the recovery that moves it back.
    let net = watchdog(true);
    let flows = transition_semiflows(&net, &SemiflowLimits::default()).unwrap();
    assert_eq!(counts(&flows, &net), [vec!["ta", "tb"], vec!["ta", "tc", "t_rec"]]);
}

#[test]
fn a_sub_net_with_a_watchdog_keeps_its_properties_if_it_can_recover() {
    // The pattern on the task pd of the sub-net; recovery by doing the task again (L3104, "redo"). Rebuilt.
    let guarded = |recovery: bool| {
        let mut b = loading();
        let pd = PlaceId(3);
        let (error, no_error) = (b.place("perr", 0), b.place("~perr", 1));
        let expired = b.transition("t_expired");
        b.input(expired, pd, 1).input(expired, no_error, 1).output(expired, error, 1);
        if recovery {
            let t = b.transition("t_rec");
            b.input(t, error, 1).output(t, no_error, 1).output(t, pd, 1);
        }
        b.build().unwrap()
    };
    let net = guarded(true);
    let flows = place_semiflows(&net, &SemiflowLimits::default()).unwrap();
    assert!(supports(&net, &flows).contains(&vec!["perr".to_owned(), "~perr".to_owned()]), "{flows:?}");
    assert_eq!(flows.uncovered(&net).count(), 0);
    assert_eq!(decide_by_structure(&net).safe.holds(), Some(true));
    let explored = explore(&net, 1_000).unwrap();
    assert!(explored.is_live() && explored.is_safe() && explored.is_reversible().is_ok());
    assert!(explore(&guarded(false), 1_000).unwrap().deadlocks().next().is_some());
    assert!(net.is_free_choice().is_err() && net.is_asymmetric_choice().is_ok());
}
