//! The error pattern of a watched task, seed 000, Fig. 50, L3000-3080, in its coloured form.
//!
//! Printed: the error domain E as last component before <•> (definitions 52 to 55), the places pa, pe and ~pe, that tc is
//! parallel to tb and moves ~pe to pe, the place-flow proj(n−1).m(pe) + succ((n−1)_j).m(~pe) = <e_j> and the canonical
//! transition-flows [ta tb 0] and [ta 0 tc] (L3058-3065). Rebuilt: where ta takes from and tb gives to, so that the task
//! can be done again; and a recovery that puts ~pe back, without which [ta 0 tc] is no flow. Time is not here: the net
//! leaves open whether tb or tc comes first.

use linewright_nets::coloured::flow::{PlaceFlow, TransitionFlow};
use linewright_nets::coloured::{
    BasicId, ColouredBuilder, ColouredNet, Domain, Guard, colour, explore, id, pred, proj, succ,
};

use super::{mode, names, play};

/// A task on one of two machines that may end with error `j` of `errors`; e0 means none (definition 54).
fn watched(errors: u32, j: u32, recovery: bool) -> ColouredNet {
    let mut b = ColouredBuilder::new("watchdog");
    let m = b.basic("M", 2);
    let e = b.named_basic("E", (0..=errors).map(|error| format!("e{error}")));
    let idle = b.place("idle", [m, e]);
    let [pa, pe, not_pe] = ["pa", "pe", "~pe"].map(|name| b.place(name, [m, e]));
    for machine in [1, 2] {
        b.tokens(idle, &[machine, 1], 1).tokens(not_pe, &[machine, 1], 1);
    }
    let [ta, tb, tc] = ["ta", "tb", "tc"].map(|name| b.transition(name, Domain::Universal));
    b.input(ta, idle, id()).output(ta, pa, id());
    b.input(tb, pa, id()).output(tb, idle, id());
    b.input(tc, pa, id()).input(tc, not_pe, id()).output(tc, pe, succ(2, j));
    if recovery {
        let t_rec = b.transition("t_rec", Domain::Universal);
        b.input(t_rec, pe, id()).output(t_rec, not_pe, pred(2, j)).output(t_rec, idle, pred(2, j));
        b.guard(t_rec, Guard::all([colour(2, j + 1)]));
    }
    b.build().unwrap()
}

/// L3058-3061: proj(n−1).m(pe) + succ((n−1)_j).m(~pe), for one machine <e_j>; there are two here.
#[test]
fn the_printed_place_flow_holds() {
    for (errors, j) in [(1, 1), (3, 1), (3, 3), (5, 2)] {
        for recovery in [false, true] {
            let net = watched(errors, j, recovery);
            let place = |name| net.place_named(name).unwrap();
            // E is component 2 here; n counts <•> too.
            let weights = [(place("pe"), proj([2])), (place("~pe"), proj([2]).of(succ(2, j)))];
            let flow = PlaceFlow::new(&net, BasicId(1), weights).unwrap();
            assert_eq!(flow.check(&net, 0), Ok(()));
            let reached = explore(&net, 1000).unwrap();
            for state in reached.numbers() {
                assert_eq!(flow.value(&net, reached.marking(state)), [(vec![j + 1], 2)]);
                // pe and ~pe exclude each other with regard to e_j, for each machine.
                for machine in [1, 2] {
                    let marking = reached.marking(state);
                    let on = |name, error: u32| net.count(marking, place(name), &[machine, error + 1]).unwrap();
                    assert_eq!(on("pe", j) + on("~pe", 0), 1);
                }
            }
        }
    }
    // As L3059 prints it, without the tilde, nothing is conserved.
    let net = watched(3, 1, false);
    let pe = net.place_named("pe").unwrap();
    let flow = PlaceFlow::new(&net, BasicId(1), [(pe, proj([2]) + proj([2]).of(succ(2, 1)))]).unwrap();
    assert!(flow.check(&net, 100).is_err());
}

/// L3062-3065: [ta tb 0] is a flow. [ta 0 tc] leaves pe marked and is none, until a recovery follows.
#[test]
fn the_printed_transition_flows() {
    let net = watched(3, 2, true);
    let cycle = |modes: &[&str]| TransitionFlow::new(modes.iter().map(|name| (mode(&net, name), 1)));
    assert_eq!(cycle(&["ta<1,e0>", "tb<1,e0>"]).check(&net), Ok(()));
    let error = cycle(&["ta<1,e0>", "tc<1,e0>"]).check(&net).unwrap_err();
    assert_eq!(error.to_string(), "the modes together change `idle<1,e0>` by -1");
    assert_eq!(cycle(&["ta<1,e0>", "tc<1,e0>", "t_rec<1,e2>"]).check(&net), Ok(()));

    let mut marking = net.initial_marking();
    play(&net, &mut marking, &["ta<1,e0>"]);
    assert_eq!(names(&net, net.enabled(&marking)), ["ta<2,e0>", "tb<1,e0>", "tc<1,e0>"]);
    play(&net, &mut marking, &["tc<1,e0>", "t_rec<1,e2>"]);
    assert_eq!(marking, net.initial_marking());
}

/// Without recovery an error ends the work of its machine; with it, everything can be reached again from everywhere.
#[test]
fn only_a_recovery_makes_it_reversible() {
    let net = watched(3, 2, false);
    let reached = explore(&net, 1000).unwrap();
    assert_eq!((reached.states().len(), reached.deadlocks().count()), (3 * 3, 1));
    assert!(reached.is_reversible().is_err());
    let net = watched(3, 2, true);
    let reached = explore(&net, 1000).unwrap();
    assert_eq!((reached.states().len(), reached.is_reversible()), (3 * 3, Ok(())));
    // Of the modes, those in which the task begins normally are live; the others never occur.
    let live: Vec<_> =
        net.transitions().flat_map(|t| net.modes(t)).filter(|&m| reached.is_transition_live(m).is_ok()).collect();
    let normal = ["ta<1,e0>", "ta<2,e0>", "tb<1,e0>", "tb<2,e0>", "tc<1,e0>", "tc<2,e0>", "t_rec<1,e2>", "t_rec<2,e2>"];
    assert_eq!(names(&net, live), normal);
}
