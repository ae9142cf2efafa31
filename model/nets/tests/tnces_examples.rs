//! The examples of seed 003: its net with weights, its event-driven variable, its conveyor. Lines are those of its text.

use linewright_nets::tnces::{
    ArcClock, FiredStep, Interval, Latest, NotEnabled, Policy, Restless, Semantics, StateGraph, TimeBound, TimedLabel,
    Tnces, TncesBuilder, TncesPlayer,
};
use linewright_nets::{Marking, Net, NetBuilder, PlaceId, StateId, TransitionId, explore};

fn marking(counts: &[u32]) -> Marking {
    Marking::from_tokens(counts.iter().copied())
}

/// Figure 4, of which L346 keeps the markings. With single arcs p5 would get one token; it gets two.
#[test]
fn figure_4_needs_an_output_of_weight_2() {
    let mut b = NetBuilder::new("figure 4");
    let p: Vec<_> = [1, 2, 0, 0, 0].iter().enumerate().map(|(i, &n)| b.place(format!("p{}", i + 1), n)).collect();
    let t = b.transition("t");
    b.input(t, p[0], 1).input(t, p[1], 1).output(t, p[2], 1).output(t, p[3], 1).output(t, p[4], 2);
    let system = TncesBuilder::new(b.build().unwrap()).build().unwrap();
    let graph = system.untimed_space(10).unwrap();
    assert_eq!(graph.states(), [marking(&[1, 2, 0, 0, 0]), marking(&[0, 1, 1, 1, 2])]);
}

/// Figure 3 (L306-308): the lift is on the second floor, e0 begins; e2 takes it to x3, and then e3, e5, e6, e7 to x6,
/// x5, x8, x3. Events that are not expected in a state change nothing.
#[test]
fn figure_3_is_a_course_of_a_variable_under_events() {
    let mut b = NetBuilder::new("lift");
    let floors: Vec<_> = (0..=8).map(|i| b.place(format!("x{i}"), u32::from(i == 2))).collect();
    let course = [("e2", 2, 3), ("e3", 3, 6), ("e5", 6, 5), ("e6", 5, 8), ("e7", 8, 3)];
    let mut calls = Vec::new();
    for (event, from, to) in course {
        let call = b.transition(event);
        let ride = b.transition(format!("{event}: x{from} to x{to}"));
        b.input(ride, floors[from], 1).output(ride, floors[to], 1);
        calls.push((call, ride, to));
    }
    let mut b = TncesBuilder::new(b.build().unwrap());
    calls.iter().for_each(|&(call, ride, _)| _ = b.external(call).event(call, ride));
    let system = b.build().unwrap();
    let mut lift = TncesPlayer::new(&system, Policy::Soonest);
    for (at, &(call, ride, to)) in calls.iter().enumerate() {
        // The last event of all finds no transition that waits for it before its turn comes.
        let last = calls[calls.len() - 1].0;
        if at + 1 < calls.len() {
            assert_eq!(lift.fire(last).unwrap().step.as_ref(), [last]);
        }
        assert_eq!(lift.fire(call).unwrap().step.as_ref(), [call, ride]);
        assert!(lift.marking().marked().eq([floors[to]]));
    }
    assert!(matches!(lift.fire(calls[0].1), Err(NotEnabled::Forced { .. })));
}

/// Where the conveyor's three seconds are on t2; which arcs carry them in Figure 8 is lost.
#[derive(Clone, Copy)]
enum Three {
    /// On the arc from "location 1 is busy" only.
    OnBusy,
    /// On both input arcs.
    OnBoth,
}

/// Figure 8 (L491-495): p1 and p2 mean that location 1 is free or busy, p3 and p4 location 2. t1 "will be fired if an
/// extern event happens, and t2 and t3 will happen three seconds after they will be enabled".
fn conveyor(clock: ArcClock, three: Three) -> Tnces {
    let mut b = NetBuilder::new("conveyor");
    let [p1, p2, p3, p4] = [("p1", 1), ("p2", 0), ("p3", 1), ("p4", 0)].map(|(name, n)| b.place(name, n));
    let [t1, t2, t3] = ["t1", "t2", "t3"].map(|name| b.transition(name));
    b.input(t1, p1, 1).output(t1, p2, 1);
    b.input(t2, p2, 1).input(t2, p3, 1).output(t2, p1, 1).output(t2, p4, 1);
    b.input(t3, p4, 1).output(t3, p3, 1);
    let mut b = TncesBuilder::new(b.build().unwrap());
    b.external(t1).semantics(Semantics { clock, ..Semantics::default() });
    b.interval(t2, p2, Interval::exactly(3)).interval(t3, p4, Interval::exactly(3));
    if matches!(three, Three::OnBoth) {
        b.interval(t2, p3, Interval::exactly(3));
    }
    b.build().unwrap()
}

const CLOCKS: [ArcClock; 3] = [ArcClock::TokenAge, ArcClock::SinceMarked, ArcClock::SinceEnabled];

#[test]
fn the_conveyor_has_the_four_markings_of_l495_and_five_arcs() {
    let system = conveyor(ArcClock::SinceEnabled, Three::OnBusy);
    let graph = system.untimed_space(100).unwrap();
    let m = [[1, 0, 1, 0], [0, 1, 1, 0], [1, 0, 0, 1], [0, 1, 0, 1]].map(|m| marking(&m));
    assert_eq!(graph.states(), m);
    let name = |arc: &linewright_nets::tnces::GraphArc| {
        let fired = graph.fired(arc).iter().map(|&t| system.net().transition_name(t));
        (arc.from.0 + 1, fired.collect::<Vec<_>>().join("+"), arc.to.0 + 1)
    };
    let arcs: Vec<_> = graph.arcs().iter().map(name).collect();
    let expected = [(1, "t1", 2), (2, "t2", 3), (3, "t1", 4), (3, "t3", 1), (4, "t3", 2)];
    assert_eq!(arcs, expected.map(|(from, t, to)| (from, t.to_owned(), to)));
    assert_eq!(graph.deadlocks().count(), 0);
    assert_eq!(explore(system.net(), 100).unwrap().states(), graph.states());
    // With time the same markings are reached, in every reading.
    for (clock, three) in CLOCKS.into_iter().flat_map(|clock| [(clock, Three::OnBusy), (clock, Three::OnBoth)]) {
        let timed = conveyor(clock, three).timed_space(1_000).unwrap();
        assert!(m.iter().all(|m| timed.states().iter().any(|state| state.marking() == m)));
        assert!(timed.states().iter().all(|state| m.contains(state.marking())));
        assert_eq!((timed.deadlocks().count(), timed.standstill()), (0, None));
    }
}

/// Loads a piece at 0 and one at 4 s, and returns when which transition fired.
fn two_pieces(system: &Tnces) -> Vec<(u64, String)> {
    let mut player = TncesPlayer::new(system, Policy::Soonest);
    let t1 = system.net().transition_named("t1").unwrap();
    let mut log = vec![player.fire(t1).unwrap()];
    assert_eq!(player.next_time(), Some(3));
    log.extend(player.advance(4, 10).unwrap());
    log.push(player.fire(t1).unwrap());
    log.extend(player.advance(100, 10).unwrap());
    assert_eq!((player.now(), player.next_time()), (100, None));
    log.into_iter().map(|FiredStep { time, step }| (time, system.net().transition_name(step[0]).to_owned())).collect()
}

/// Location 2 is free again at 6. L491 and L512 count three seconds from the enabling; L403 counts the time the token
/// has spent at the place, and the second piece has been there since 4.
#[test]
fn the_second_piece_leaves_at_9_or_at_7_as_the_clock_is_read() {
    let second = |clock, three| {
        let log = two_pieces(&conveyor(clock, three));
        let expected = [(0, "t1"), (3, "t2"), (4, "t1"), (6, "t3")].map(|(time, t)| (time, t.to_owned()));
        assert_eq!(log[..4], expected);
        assert_eq!((log[4].1.as_str(), log[5].1.as_str()), ("t2", "t3"));
        (log[4].0, log[5].0)
    };
    assert_eq!(second(ArcClock::SinceMarked, Three::OnBusy), (9, 12));
    assert_eq!(second(ArcClock::SinceEnabled, Three::OnBusy), (9, 12));
    assert_eq!(second(ArcClock::TokenAge, Three::OnBusy), (7, 10));
    assert_eq!(second(ArcClock::TokenAge, Three::OnBoth), (9, 12));
}

/// Times between states (L898). A piece that has just been put on an empty conveyor reaches location 2 after 3 s and is
/// off after 6, unless the next piece comes; that one comes when the environment likes.
#[test]
fn times_between_states_of_the_conveyor() {
    let graph = conveyor(ArcClock::SinceEnabled, Three::OnBusy).timed_space(1_000).unwrap();
    let is = |m: &[u32]| {
        let m = marking(m);
        move |state: &linewright_nets::tnces::TimedState| *state.marking() == m
    };
    let loaded =
        graph.arcs_from(StateId::INITIAL).iter().find(|arc| matches!(arc.label, TimedLabel::Step(_))).unwrap().to;
    let at_2 = graph.span(loaded, is(&[1, 0, 0, 1])).unwrap();
    assert_eq!(at_2, TimeBound { earliest: 3, latest: Latest::After(3) });
    let empty = graph.span(loaded, is(&[1, 0, 1, 0])).unwrap();
    assert_eq!(empty.earliest, 6);
    assert!(matches!(empty.latest, Latest::Never(_)), "pieces may come for ever");
    let full = graph.span(StateId::INITIAL, is(&[0, 1, 0, 1])).unwrap();
    assert_eq!(full.earliest, 3);
    assert!(matches!(full.latest, Latest::Never(_)), "pieces may stay away for ever");
    let diagram = graph.fastest(loaded, is(&[1, 0, 1, 0])).unwrap();
    let moments: Vec<u64> = diagram.iter().filter(|(_, arc)| arc.label.delay() == 0).map(|&(time, _)| time).collect();
    assert_eq!(moments, [3, 6]);
}

/// Two modules of Figure 5 (L362): "when transition t1 of Module 1 is fired, automatically transition t1 of Module 2 is
/// also fired", if its input places have tokens; if not, Module 1 goes on alone.
#[test]
fn a_firing_forces_what_is_enabled_and_does_not_wait_for_what_is_not() {
    let mut b = NetBuilder::new("figure 5");
    let [a, x, y] = [("m1.p1", 2), ("m2.p1", 1), ("m2.p2", 0)].map(|(name, n)| b.place(name, n));
    let [t1, t2] = ["m1.t1", "m2.t1"].map(|name| b.transition(name));
    b.input(t1, a, 1).input(t2, x, 1).output(t2, y, 1);
    let mut b = TncesBuilder::new(b.build().unwrap());
    b.event(t1, t2);
    let graph = b.build().unwrap().untimed_space(10).unwrap();
    assert_eq!(graph.states(), [marking(&[2, 1, 0]), marking(&[1, 0, 1]), marking(&[0, 0, 1])]);
    let steps: Vec<_> = graph.arcs().iter().map(|arc| graph.fired(arc).to_vec()).collect();
    assert_eq!(steps, [vec![t1, t2], vec![t1]]);
}

/// One token, two forced transitions that need it: two maximal steps.
#[test]
fn forced_transitions_in_conflict_make_several_steps() {
    let mut b = NetBuilder::new("conflict");
    let p = b.place("p", 1);
    let [go, left, right] = ["go", "left", "right"].map(|name| b.transition(name));
    b.input(left, p, 1).input(right, p, 1);
    let mut b = TncesBuilder::new(b.build().unwrap());
    b.event(go, left).event(go, right).external(go);
    let system = b.build().unwrap();
    let player = TncesPlayer::new(&system, Policy::Soonest);
    assert_eq!(player.steps(), [[go, left].into(), [go, right].into()] as [Box<[TransitionId]>; 2]);
}

fn one_step(interval: Interval, semantics: Semantics) -> (Tnces, TransitionId) {
    let mut b = NetBuilder::new("one");
    let p = b.place("p", 1);
    let t = b.transition("t");
    b.input(t, p, 1);
    let mut b = TncesBuilder::new(b.build().unwrap());
    b.interval(t, p, interval).semantics(semantics);
    (b.build().unwrap(), t)
}

/// [2, 5] in the four readings of "when": at 2; from 2 to 5; from 2 to 5 or never.
#[test]
fn what_happens_between_dr_and_dl_and_after_it() {
    use linewright_nets::tnces::{Deadline, FiringPolicy};
    let span = |firing, deadline| {
        let (system, _) = one_step(Interval::between(2, 5), Semantics { firing, deadline, ..Semantics::default() });
        let graph: StateGraph<_> = system.timed_space(100).unwrap();
        graph.span(StateId::INITIAL, |state| state.marking().total() == 0).unwrap()
    };
    assert_eq!(span(FiringPolicy::Earliest, Deadline::Must), TimeBound { earliest: 2, latest: Latest::After(2) });
    assert_eq!(span(FiringPolicy::Earliest, Deadline::Expires), TimeBound { earliest: 2, latest: Latest::After(2) });
    assert_eq!(span(FiringPolicy::Window, Deadline::Must), TimeBound { earliest: 2, latest: Latest::After(5) });
    let lost = span(FiringPolicy::Window, Deadline::Expires);
    assert_eq!(lost.earliest, 2);
    assert!(matches!(lost.latest, Latest::Never(_)), "the token can become too old");
}

#[test]
fn the_player_says_why_not() {
    use linewright_nets::tnces::{Deadline, FiringPolicy};
    let semantics = Semantics { firing: FiringPolicy::Window, deadline: Deadline::Expires, ..Semantics::default() };
    let (system, t) = one_step(Interval::between(2, 5), semantics);
    let mut player = TncesPlayer::new(&system, Policy::WhenDue);
    let refused = |player: &mut TncesPlayer<_>| player.fire(t).unwrap_err().to_string();
    assert_eq!(refused(&mut player), "transition `t` can fire from time 2 on; it is 0");
    player.advance(6, 10).unwrap();
    assert_eq!(refused(&mut player), "transition `t` could have fired before time 6; its tokens are too old now");

    let (system, t) = one_step(Interval::ANY, Semantics::default());
    let mut player = TncesPlayer::new(&system, Policy::Soonest);
    assert_eq!(player.advance(0, 0).unwrap_err(), Restless::Limit { time: 0, fired: Vec::new() });
    assert_eq!(player.advance(0, 1).unwrap().len(), 1);
    assert_eq!(
        player.fire(t).unwrap_err().to_string(),
        "transition `t` cannot fire: place `p` has 0 of the 1 tokens needed"
    );
}

/// Without a limit of its own a net that grows is undecided, not wrong.
#[test]
fn what_does_not_end_is_undecided() {
    let mut b = NetBuilder::new("spring");
    let (pool, t) = (b.place("pool", 0), b.transition("t"));
    b.output(t, pool, 1);
    let net: Net = b.build().unwrap();
    let system = TncesBuilder::new(net).build().unwrap();
    let message = "undecided after 10 states: there are more than allowed";
    assert_eq!(system.untimed_space(10).unwrap_err().to_string(), message);
    assert_eq!(system.timed_space(10).unwrap_err().to_string(), message);
    assert_eq!(system.timed_space(0).unwrap_err().states, 0);
    let mut player = TncesPlayer::new(&system, Policy::Soonest);
    assert!(matches!(player.advance(5, 7), Err(Restless::Limit { time: 0, fired }) if fired.len() == 7));
    assert_eq!(player.marking().tokens(PlaceId(0)), 7);
}

/// Start-up, then a cycle, and cycles that share a state (the shapes of L884 and L888).
#[test]
fn shapes_of_state_graphs() {
    // start → a → b → a, and of a second round c: a → c → a.
    let graph = |edges: &[(usize, usize)], places: usize| {
        let mut b = NetBuilder::new("shape");
        let p: Vec<_> = (0..places).map(|i| b.place(format!("p{i}"), u32::from(i == 0))).collect();
        for (i, &(from, to)) in edges.iter().enumerate() {
            let t = b.transition(format!("t{i}"));
            b.input(t, p[from], 1).output(t, p[to], 1);
        }
        let net = b.build().unwrap();
        let arcs: Vec<_> = net.transitions().map(|t| (t, net.preset(t)[0].0)).collect();
        let mut b = TncesBuilder::new(net);
        arcs.into_iter().for_each(|(t, p)| _ = b.interval(t, p, Interval::exactly(2)));
        b.build().unwrap()
    };
    let single = graph(&[(0, 1), (1, 2), (2, 1)], 3);
    let timed = single.timed_space(100).unwrap();
    let shape = timed.shape();
    // A wait and a step for each transition.
    assert_eq!((shape.transient.len(), shape.loops.len()), (2, 1));
    assert_eq!((shape.loops[0].states.len(), shape.loops[0].period, shape.loops[0].is_final), (4, Some(4), true));
    assert_eq!(timed.cycles_through(shape.loops[0].states[0]), Some(1));

    let testing = graph(&[(0, 1), (1, 2), (1, 3), (2, 4), (2, 5), (3, 4), (3, 5), (4, 1), (5, 1)], 6);
    let untimed = testing.untimed_space(100).unwrap();
    assert_eq!(untimed.shape().loops[0].period, None);
    assert_eq!(untimed.cycles_through(StateId(1)), Some(4));
    assert_eq!(untimed.cycles_through(StateId(2)), None, "a cycle through the other colour avoids it");
    assert_eq!(untimed.standstill(), Some(StateId(1)), "without time every cycle takes none");
    assert_eq!(testing.timed_space(100).unwrap().standstill(), None);
}

/// A cylinder at rest that is switched on takes its 900 ms (L512, L731) only where they count from the condition.
#[test]
fn a_mechanism_at_rest_moves_late_or_at_once_as_the_clock_is_read() {
    let arrival = |clock, rest| {
        let mut b = NetBuilder::new("cylinder");
        let [off, on, back, front] =
            [("off", 1), ("on", 0), ("back", 1), ("front", 0)].map(|(name, n)| b.place(name, n));
        let [switch, extend] = ["switch", "extend"].map(|name| b.transition(name));
        b.input(switch, off, 1).output(switch, on, 1).input(extend, back, 1).output(extend, front, 1);
        let mut b = TncesBuilder::new(b.build().unwrap());
        b.external(switch).condition(extend, on, 1).interval(extend, back, Interval::exactly(900));
        b.semantics(Semantics { clock, ..Semantics::default() });
        let system = b.build().unwrap();
        let mut player = TncesPlayer::new(&system, Policy::Soonest);
        assert_eq!(player.advance(rest, 10).unwrap(), []);
        player.fire(switch).unwrap();
        player.advance(10_000, 10).unwrap()[0].time
    };
    assert_eq!(CLOCKS.map(|clock| arrival(clock, 500)), [900, 900, 1_400]);
    assert_eq!(CLOCKS.map(|clock| arrival(clock, 2_000)), [2_000, 2_000, 2_900]);
}
