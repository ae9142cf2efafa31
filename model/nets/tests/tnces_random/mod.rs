//! Random systems: the crate against a second, slow and obvious implementation, and against the plain net.

mod plain;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicUsize, Ordering};

use linewright_nets::tnces::{
    EventMode, Interval, Latest, Policy, Semantics, StateGraph, TimedLabel, Tnces, TncesBuilder, TncesPlayer,
};
use linewright_nets::{Net, NetBuilder, PlaceId, TransitionId, explore};
use plain::{Marking, Plain, Space, Transition};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The same system for the crate.
fn tnces(plain: &Plain, modes: &[bool]) -> Tnces {
    let mut b = NetBuilder::new("generated");
    let places: Vec<_> = plain.tokens.iter().enumerate().map(|(i, &n)| b.place(format!("p{i}"), n)).collect();
    let ts: Vec<_> = (0..plain.transitions.len()).map(|i| b.transition(format!("t{i}"))).collect();
    for (transition, &t) in plain.transitions.iter().zip(&ts) {
        transition.takes.iter().for_each(|&(p, n, ..)| _ = b.input(t, places[p], n));
        transition.gives.iter().for_each(|&(p, n)| _ = b.output(t, places[p], n));
    }
    let mut b = TncesBuilder::new(b.build().expect("generated nets are sound"));
    b.semantics(plain.semantics);
    for ((transition, &t), &all) in plain.transitions.iter().zip(&ts).zip(modes) {
        for &(p, _, earliest, latest) in transition.takes.iter().filter(|_| plain.timed) {
            b.interval(t, places[p], Interval { earliest, latest });
        }
        transition.reads.iter().for_each(|&(p, n)| _ = b.condition(t, places[p], n));
        if all {
            b.event_mode(t, EventMode::All);
        }
        transition.groups.iter().flatten().for_each(|&from| _ = b.event(ts[from], t));
        if transition.external {
            b.external(t);
        }
    }
    plain.ages.iter().zip(&places).filter(|_| plain.timed).for_each(|(&age, &p)| _ = b.initial_age(p, age));
    b.build().expect("generated systems are sound")
}

fn side(places: usize) -> impl Strategy<Value = BTreeMap<usize, u32>> {
    prop::collection::btree_map(0..places, prop_oneof![3 => Just(1_u32), 1 => Just(2)], 0..=2)
}

fn interval() -> impl Strategy<Value = (u32, Option<u32>)> {
    prop_oneof![
        1 => Just((0, None)),
        2 => (0_u32..=4).prop_map(|dr| (dr, None)),
        3 => (0_u32..=4, 0_u32..=2).prop_map(|(dr, more)| (dr, Some(dr + more))),
    ]
}

/// A transition without its events; it never makes more tokens than it takes, so that the net is bounded.
fn transition(places: usize) -> impl Strategy<Value = Transition> {
    let read = prop_oneof![2 => Just(None), 1 => (0..places, 1_u32..=2).prop_map(Some)];
    (side(places), side(places), prop::collection::vec(interval(), 2), read, prop::bool::weighted(0.15)).prop_map(
        |(takes, gives, intervals, read, external)| {
            let mut left: u32 = takes.values().sum();
            let mut out = Vec::new();
            for (p, n) in gives {
                let n = n.min(left);
                left -= n;
                if n > 0 {
                    out.push((p, n));
                }
            }
            let takes = takes.into_iter().zip(intervals).map(|((p, n), (dr, dl))| (p, n, dr, dl)).collect();
            Transition { takes, gives: out, reads: read.into_iter().collect(), groups: Vec::new(), external }
        },
    )
}

/// A system, and for each transition whether it waits for all its events.
fn system(timed: bool) -> impl Strategy<Value = (Plain, Vec<bool>)> {
    let semantics = prop::sample::select(Semantics::all().collect::<Vec<_>>());
    (2_usize..=4, 1_usize..=5, semantics, prop_oneof![3 => Just(1_u32), 1 => Just(3)])
        .prop_flat_map(|(places, ts, semantics, scale)| {
            let tokens = prop::collection::vec(0_u32..=2, places);
            let ages = prop::collection::vec(prop_oneof![3 => Just(0_u32), 1 => 0_u32..=3], places);
            let transitions = prop::collection::vec(transition(places), ts);
            let events = prop::collection::vec((0..ts, 0..ts), 0..=4);
            let order = prop::collection::vec(any::<u16>(), ts);
            let modes = prop::collection::vec(prop::bool::weighted(0.3), ts);
            (tokens, ages, transitions, events, order, modes, Just(semantics), Just(scale))
        })
        .prop_map(move |(tokens, ages, mut transitions, events, order, modes, semantics, scale)| {
            for t in &mut transitions {
                for (_, _, dr, dl) in &mut t.takes {
                    (*dr, *dl) = (*dr * scale, dl.map(|dl| dl * scale));
                }
            }
            // Events go from lower to higher keys, hence in no cycle.
            let arcs: BTreeSet<(usize, usize)> =
                events.into_iter().filter(|&(from, to)| (order[from], from) < (order[to], to)).collect();
            for (from, to) in arcs {
                let t = &mut transitions[to];
                t.external = false;
                if modes[to] || t.groups.is_empty() {
                    t.groups.push(Vec::new());
                }
                t.groups.last_mut().expect("there is one").push(from);
            }
            let ages = ages.into_iter().map(|age| age * scale).collect();
            (Plain { tokens, ages, transitions, semantics, timed }, modes)
        })
}

fn slice(marking: &linewright_nets::Marking) -> Marking {
    marking.as_slice().to_vec()
}

/// Findings of the crate, in the words of the other.
fn moves<S>(graph: &StateGraph<S>, marking: impl Fn(&S) -> Marking) -> BTreeSet<(Marking, Vec<usize>, Marking)> {
    let steps = graph.arcs().iter().filter(|arc| matches!(arc.label, TimedLabel::Step(_)));
    let numbers = |ts: &[TransitionId]| {
        let mut ts: Vec<usize> = ts.iter().map(|t| t.index()).collect();
        ts.sort_unstable();
        ts
    };
    steps.map(|arc| (marking(graph.state(arc.from)), numbers(graph.fired(arc)), marking(graph.state(arc.to)))).collect()
}

fn untimed_agrees((plain, modes): (Plain, Vec<bool>)) {
    let space = Space::new(&plain, 2_000).expect("bounded");
    let graph = tnces(&plain, &modes).untimed_space(2_000).expect("bounded");
    assert_eq!(graph.states().len(), space.states.len());
    let markings: BTreeSet<Marking> = graph.states().iter().map(slice).collect();
    assert_eq!(markings, (0..space.states.len()).map(|state| space.marking(state)).collect());
    assert_eq!(moves(&graph, slice), space.moves());
    assert_eq!(graph.arcs().len(), space.next.iter().map(Vec::len).sum::<usize>());
    assert_eq!(graph.deadlocks().map(|s| slice(graph.state(s))).collect::<BTreeSet<_>>(), space.dead());
}

fn timed_agrees((plain, modes): (Plain, Vec<bool>), decided: &AtomicUsize) {
    let Some(space) = Space::new(&plain, 1_500) else { return };
    decided.fetch_add(1, Ordering::Relaxed);
    let system = tnces(&plain, &modes);
    let graph = system.timed_space(10_000).expect("bounded nets have finitely many clipped states");
    assert!(graph.states().len() <= space.states.len());
    let of = |state: &linewright_nets::tnces::TimedState| slice(state.marking());
    assert_eq!(moves(&graph, of), space.moves());
    assert_eq!(graph.deadlocks().map(|s| of(graph.state(s))).collect::<BTreeSet<_>>(), space.dead());
    let earliest = space.earliest();
    assert_eq!(graph.states().iter().map(of).collect::<BTreeSet<_>>(), earliest.keys().cloned().collect());
    for (goal, time) in earliest {
        let span = graph.span(linewright_nets::StateId::INITIAL, |state| of(state) == goal).expect("reachable");
        assert_eq!(span.earliest, time, "{goal:?}");
        let latest = match span.latest {
            Latest::After(time) => Some(time),
            Latest::Never(_) => None,
        };
        assert_eq!(latest, space.latest(&goal), "{goal:?}");
    }
}

/// Plays a while, now and then an external transition, and checks each delay and step with the other implementation.
fn player_agrees((plain, modes): (Plain, Vec<bool>), policy: Policy, pokes: &[usize]) {
    let system = tnces(&plain, &modes);
    let mut player = TncesPlayer::new(&system, policy);
    let (mut state, mut now) = (plain.initial(), 0);
    let mut follow = |fired: &linewright_nets::tnces::FiredStep, until: u64| {
        while now < until {
            state = plain.tick(&state).expect("no time passes while something is due");
            now += 1;
        }
        if !fired.step.is_empty() {
            let mut step: Vec<usize> = fired.step.iter().map(|t| t.index()).collect();
            step.sort_unstable();
            assert!(plain.steps(&state).contains(&step), "{step:?} in {state:?}");
            state = plain.fire(&state, &step);
        }
        Plain::marking(&state)
    };
    let nothing = |time| linewright_nets::tnces::FiredStep { time, step: [].into() };
    for (round, &poke) in (1_u64..).zip(pokes) {
        let t = TransitionId((poke % plain.transitions.len()) as u32);
        let possible = player.steps().iter().any(|step| step[0] == t);
        match player.fire(t) {
            Ok(fired) => {
                assert!(possible);
                assert_eq!(follow(&fired, fired.time), slice(player.marking()));
            }
            Err(_) => assert!(!possible),
        }
        let promised = player.next_time();
        match player.advance(round * 2, 20) {
            Ok(fired) => {
                assert_eq!(fired.first().map(|fired| fired.time), promised.filter(|&time| time <= round * 2));
                fired.iter().for_each(|fired| _ = follow(fired, fired.time));
                assert_eq!(player.now(), round * 2);
                assert_eq!(follow(&nothing(player.now()), player.now()), slice(player.marking()));
            }
            // Without end at one instant: nothing more to compare.
            Err(_) => return,
        }
    }
}

fn cases(n: u32) -> ProptestConfig {
    ProptestConfig { cases: n, failure_persistence: None, rng_seed: RngSeed::Fixed(3), ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(cases(4_000))]

    #[test]
    fn steps_with_conditions_and_events_are_the_maximal_subsets(system in system(false)) {
        untimed_agrees(system);
    }

    #[test]
    fn a_run_of_the_player_is_a_run(system in system(true), late in any::<bool>(), pokes in prop::collection::vec(0_usize..60, 0..8)) {
        player_agrees(system, if late { Policy::WhenDue } else { Policy::Soonest }, &pokes);
    }

    #[test]
    fn without_conditions_events_and_time_it_is_the_plain_net((mut plain, modes) in system(false)) {
        for t in &mut plain.transitions {
            (t.reads, t.groups) = (Vec::new(), Vec::new());
        }
        let system = tnces(&plain, &modes);
        let net: &Net = system.net();
        let reach = explore(net, 2_000).expect("bounded");
        let graph = system.untimed_space(2_000).expect("bounded");
        prop_assert_eq!(graph.states(), reach.states());
        let arcs: Vec<_> = graph.arcs().iter().map(|arc| (arc.from, graph.fired(arc)[0], arc.to)).collect();
        prop_assert_eq!(arcs, reach.steps().iter().map(|s| (s.from, s.transition, s.to)).collect::<Vec<_>>());
        prop_assert!(graph.deadlocks().eq(reach.deadlocks()));
        // Time without bounds adds at most waiting, and under `Window` takes nothing away.
        let timed = system.timed_space(2_000).expect("bounded");
        let markings = |p: PlaceId| timed.states().iter().map(|s| s.marking().tokens(p)).max();
        prop_assert!(net.places().all(|p| markings(p) == Some(reach.bound_of(p))));
        prop_assert_eq!(timed.states().len(), reach.states().len());
    }
}

#[test]
fn clipped_and_jumping_time_is_time_in_single_units() {
    let decided = AtomicUsize::new(0);
    let mut runner = proptest::test_runner::TestRunner::new(cases(4_000));
    runner
        .run(&system(true), |case| {
            timed_agrees(case, &decided);
            Ok(())
        })
        .unwrap_or_else(|error| panic!("{error}"));
    assert!(decided.into_inner() > 3_500, "most cases must be small enough to compare");
}
