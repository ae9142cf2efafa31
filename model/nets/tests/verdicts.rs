//! Structure against exploration: decisions on the arcs must agree with playing everything out.

use linewright_nets::{
    Net, NetBuilder, NetNode, Reachability, StateId, StateMachineVerdict, explore, state_machine_verdict,
};
use proptest::prelude::*;

/// Three tokens on six places have at most 56 markings; the weighed nets are small too.
const ENOUGH: usize = 100_000;

/// The verdict of the structure, after checking it against exploration.
fn confirmed(net: &Net) -> StateMachineVerdict {
    let verdict = state_machine_verdict(net).expect("the net is a state machine");
    let explored = explore(net, ENOUGH).expect("state machines are bounded");
    assert_eq!(verdict.live.is_ok(), explored.is_live(), "{net}{verdict}");
    assert_eq!(verdict.safe.is_ok(), explored.is_safe(), "{net}{verdict}");
    assert_eq!(verdict.reversible.is_ok(), explored.is_reversible().is_ok(), "{net}{verdict}");
    if let Err(why) = &verdict.safe {
        assert!(explored.bound_of(why.place.id) > 1, "{net}{why}");
    }
    verdict
}

/// Nodes that can be reached from a node, by walking.
fn reachable_from(net: &Net, start: NetNode) -> Vec<NetNode> {
    let mut seen = vec![start];
    let mut next = 0;
    while let Some(&node) = seen.get(next) {
        let successors: Vec<NetNode> = match node {
            NetNode::Place(p) => net.consumers(p).iter().map(|&(t, _)| t.into()).collect(),
            NetNode::Transition(t) => net.postset(t).iter().map(|&(p, _)| p.into()).collect(),
        };
        for successor in successors {
            if !seen.contains(&successor) {
                seen.push(successor);
            }
        }
        next += 1;
    }
    seen
}

/// The states that can be reached from a state, by walking.
fn futures(explored: &Reachability, start: StateId) -> Vec<StateId> {
    let mut seen = vec![false; explored.states().len()];
    seen[start.index()] = true;
    let mut found = vec![start];
    let mut next = 0;
    while let Some(&state) = found.get(next) {
        for step in explored.steps_from(state) {
            if !std::mem::replace(&mut seen[step.to.index()], true) {
                found.push(step.to);
            }
        }
        next += 1;
    }
    found
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn the_verdict_on_any_state_machine_is_what_exploration_finds(net in crate::common::any_state_machine()) {
        confirmed(&net);
    }

    #[test]
    fn theorems_1_and_2_hold_as_written_for_strongly_connected_nets(net in crate::common::connected_state_machine()) {
        prop_assert_eq!(net.is_strongly_connected(), Ok(()));
        let verdict = confirmed(&net);
        let tokens = net.initial_marking().total();
        prop_assert_eq!(verdict.live.is_ok(), tokens >= 1);
        prop_assert_eq!(verdict.safe.is_ok(), tokens <= 1);
        prop_assert!(verdict.reversible.is_ok());
    }

    #[test]
    fn strong_connection_is_what_walking_finds(net in crate::common::any_net()) {
        let places = net.places().map(NetNode::from);
        let nodes: Vec<NetNode> = places.chain(net.transitions().map(NetNode::from)).collect();
        let all = nodes.iter().all(|&node| reachable_from(&net, node).len() == nodes.len());
        match net.is_strongly_connected() {
            Ok(()) => prop_assert!(all),
            Err(why) => prop_assert!(!reachable_from(&net, why.from.id).contains(&why.to.id), "{why}"),
        }
    }

    #[test]
    fn the_classes_relate_as_they_should(net in crate::common::any_net(), machine in crate::common::any_state_machine()) {
        prop_assert_eq!(machine.is_free_choice(), Ok(()));
        if net.is_marked_graph().is_ok() {
            prop_assert_eq!(net.is_free_choice(), Ok(()));
        }
        prop_assert_eq!(machine.incidence().place_invariant(&vec![1; machine.place_count()]), Ok(()));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn an_exploration_says_what_its_definitions_say((net, _) in crate::common::weighed_net()) {
        let explored = explore(&net, ENOUGH).unwrap();
        let states: Vec<StateId> = (0..explored.states().len() as u32).map(StateId).collect();
        let mut reversible = true;
        let mut live = vec![true; net.transition_count()];
        for &state in &states {
            let future = futures(&explored, state);
            reversible &= future.contains(&StateId::INITIAL);
            for t in net.transitions() {
                live[t.index()] &= future.iter().any(|&state| net.is_enabled(explored.marking(state), t));
            }
        }
        prop_assert_eq!(explored.is_live(), live.iter().all(|&live| live));
        for t in net.transitions() {
            prop_assert_eq!(explored.is_transition_live(t).is_ok(), live[t.index()]);
            if let Err(state) = explored.is_transition_live(t) {
                let dead = |&state: &StateId| !net.is_enabled(explored.marking(state), t);
                prop_assert!(futures(&explored, state).iter().all(dead));
            }
        }
        prop_assert_eq!(explored.is_reversible().is_ok(), reversible);
        if let Err(state) = explored.is_reversible() {
            prop_assert!(!futures(&explored, state).contains(&StateId::INITIAL));
        }
        let stuck = states.iter().copied().filter(|&state| net.enabled(explored.marking(state)).next().is_none());
        prop_assert!(explored.deadlocks().eq(stuck));
    }

    #[test]
    fn every_state_is_reached_by_its_path((net, _) in crate::common::weighed_net()) {
        let explored = explore(&net, ENOUGH).unwrap();
        for (i, marking) in explored.states().iter().enumerate() {
            let mut played = net.initial_marking();
            for t in explored.path_to(StateId(i as u32)) {
                net.fire(&mut played, t).unwrap();
            }
            prop_assert_eq!(&played, marking);
        }
    }
}

/// A station of reversible operation modules, each with the places O, IC and C of its normal and of its recovery block
/// (seed 002 §4.5.2), connected in a ring; the token starts where the last operation is complete.
fn station(operations: &[&str]) -> Net {
    let mut b = NetBuilder::new("station");
    let last = operations.len() - 1;
    let modules: Vec<_> = (0..operations.len())
        .map(|i| {
            let mut place = |state: &str, tokens| b.place(format!("{} {state}", operations[i]), tokens);
            let home = u32::from(i == last);
            [place("O", 0), place("IC", 0), place("C", home), place("O.F", 0), place("IC.F", 0), place("C.F", 0)]
        })
        .collect();
    for (i, p) in modules.iter().enumerate() {
        let next = modules[(i + 1) % modules.len()][0];
        let previous = modules[(i + last) % modules.len()][3];
        let inner = [(0, 1), (1, 0), (0, 2), (2, 3), (1, 3), (3, 4), (4, 3), (3, 5), (5, 0), (4, 0)];
        let inner = inner.map(|(from, to)| (p[from], p[to]));
        for (n, (from, to)) in inner.into_iter().chain([(p[2], next), (p[5], previous)]).enumerate() {
            let t = b.transition(format!("{} t{}", operations[i], n + 1));
            b.input(t, from, 1).output(t, to, 1);
        }
    }
    b.build().unwrap()
}

#[test]
fn a_station_of_reversible_modules_is_live_safe_and_reversible() {
    let net = station(&["clamp", "drill", "unclamp"]);
    assert_eq!(net.place_count(), 6 * 3);
    assert_eq!(net.is_strongly_connected(), Ok(()));
    let verdict = confirmed(&net);
    assert!(verdict.holds(), "{verdict}");
}

#[test]
fn a_long_line_is_decided_by_structure() {
    let names: Vec<String> = (0..20_000).map(|i| format!("op{i}")).collect();
    let net = station(&names.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(state_machine_verdict(&net).unwrap().holds());
}
