//! The flexible production cell of seed 000 (see [`linewright_testkit::published_cell`]) against its printed figures.

use linewright_nets::StateId;
use linewright_nets::coloured::decide::{ClauseId, Decisions};
use linewright_nets::coloured::{ColouredNet, Colours, explore, unfold};
use linewright_testkit::coloured::{mode, names, play};
use linewright_testkit::published_cell::{PublishedCellVariant, cell};

fn waiting(waiting: [u32; 3]) -> ColouredNet {
    cell(&PublishedCellVariant { waiting, ..PublishedCellVariant::default() })
}

/// L1490-1536: |T| = 7, |P| = 10, m₀(p1) = m1 + m2, m₀(p2) = r1, the rest 0. (L1500-1506 prints t5 twice and then t6.)
#[test]
fn the_net_is_as_printed() {
    let net = waiting([0; 3]);
    assert_eq!((net.transition_count(), net.place_count()), (7, 10));
    assert_eq!(net.describe(&net.initial_marking()), "p1<m1>, p1<m2>, p2<r1>");
    let modes = net.modes(net.transition_named("t5").unwrap());
    assert_eq!(names(&net, modes), ["t5<m1,r1,p1>", "t5<m2,r1,p2>", "t5<m2,r1,p3>"]);
    assert_eq!(net.enabled(&net.initial_marking()), []);
}

/// The state of Fig. 41: robot 2 has finished a part 1, the human is free, parts 2 and 3 wait.
fn conflict_state() -> (ColouredNet, linewright_nets::coloured::ColouredMarking) {
    let net = waiting([1, 1, 1]);
    let mut marking = net.initial_marking();
    play(&net, &mut marking, &["t1<m1,r1,p1>", "t2<m1,r1,p1>", "t3<m1,r1,p1>", "t4<m1,p1>"]);
    (net, marking)
}

fn clause(net: &ColouredNet, transition: &str, clause: usize) -> ClauseId {
    ClauseId { transition: net.transition_named(transition).unwrap(), clause: clause - 1 }
}

/// L2738-2740: enabled are exactly t1 in (m2,r1,p2) and (m2,r1,p3), and t5 in (m1,r1,p1). L2746-2755: each pair of them
/// is in conflict. L2922: the vc of these, and of no other clause, is 1.
#[test]
fn the_conflict_state_is_the_printed_one() {
    let (net, marking) = conflict_state();
    let enabled = ["t1<m2,r1,p2>", "t1<m2,r1,p3>", "t5<m1,r1,p1>"];
    assert_eq!(names(&net, net.enabled(&marking)), enabled);
    let conflicts: Vec<_> = net.conflicts(&marking).iter().map(|pair| names(&net, [pair.winner, pair.loser])).collect();
    let pairs = enabled.iter().flat_map(|a| enabled.iter().filter(move |b| *b != a).map(move |b| [*a, *b]));
    assert!(conflicts.iter().eq(pairs.collect::<Vec<_>>().iter()), "{conflicts:?}");
    assert_eq!(net.requests(&marking), [clause(&net, "t1", 2), clause(&net, "t1", 3), clause(&net, "t5", 1)]);
    let t1 = net.transition_named("t1").unwrap();
    let gamma: Vec<_> = net.occurrence_modes(&marking, t1).map(|(_, can)| can).collect();
    assert_eq!(gamma, [false, true, true], "γ₁, γ₂ and γ₃ of t1 (definition 34)");
}

/// L2924-2944: decision (a) is bdv₃ ∧ G&₃(t1), decision (b) is bdv₁ ∧ G&₁(t5). One mode is left each time.
#[test]
fn a_decision_leaves_one_mode() {
    let (net, marking) = conflict_state();
    let left = |decisions: &Decisions| names(&net, net.enabled_under(&marking, decisions));
    assert_eq!(left(&Decisions::these([clause(&net, "t1", 3)])), ["t1<m2,r1,p3>"]);
    assert_eq!(left(&Decisions::these([clause(&net, "t5", 1)])), ["t5<m1,r1,p1>"]);
    assert_eq!(left(&Decisions::none()), [""; 0]);
    // A decision for what the tokens do not allow allows nothing.
    assert_eq!(left(&Decisions::these([clause(&net, "t1", 1)])), [""; 0]);
}

/// L2736: robot 1 loads the human with a part 2 while robot 2 works on a part 1: t2 (m2∧p2) ∥ t4 (m1∧p1).
#[test]
fn loading_and_working_are_concurrent() {
    let net = waiting([1, 1, 0]);
    let mut marking = net.initial_marking();
    play(&net, &mut marking, &["t1<m1,r1,p1>", "t2<m1,r1,p1>", "t3<m1,r1,p1>", "t1<m2,r1,p2>"]);
    let both = [mode(&net, "t2<m2,r1,p2>"), mode(&net, "t4<m1,p1>")];
    assert_eq!(net.enabled(&marking), both);
    assert!(net.is_enabled_together(&marking, &both));
    assert_eq!(net.conflicts(&marking), []);
    net.fire_together(&mut marking, &both).unwrap();
    assert_eq!(net.describe(&marking), "p4<m2,r1,p2>, p6<m1,p1>");

    // What competes for the robot is enabled one by one, but not together.
    let (net, marking) = conflict_state();
    let both = [mode(&net, "t1<m2,r1,p2>"), mode(&net, "t5<m1,r1,p1>")];
    assert!(both.iter().all(|&mode| net.is_enabled(&marking, mode)) && !net.is_enabled_together(&marking, &both));
    let refused = net.fire_together(&mut marking.clone(), &both).unwrap_err();
    let expected = "t1<m2,r1,p2> with t5<m1,r1,p1> cannot fire: `p2<r1>` has 1 of the 2 tokens needed";
    assert_eq!(refused.to_string(), expected);
}

/// L1972-1974: t3 with part 3 takes ω* from p4, and gives r1 to p2 and (m2, p3) to p5.
#[test]
fn what_t3_moves_is_as_printed() {
    let net = waiting([0; 3]);
    let t3 = mode(&net, "t3<m2,r1,p3>");
    let touched: Vec<_> = net.places().filter(|&p| net.moves(t3, p) != [vec![], vec![]]).collect();
    let place = |name| net.place_named(name).unwrap();
    assert_eq!(touched, [place("p2"), place("p4"), place("p5")]);
    assert_eq!(net.moves(t3, place("p4")), [vec![(vec![2, 1, 3], 1)], vec![]]);
    assert_eq!(net.moves(t3, place("p2")), [vec![], vec![(vec![1], 1)]]);
    assert_eq!(net.moves(t3, place("p5")), [vec![], vec![(vec![2, 3], 1)]]);
}

/// Robot 2 busy with a part 1, the human has finished, robot 1 has grasped a part 1 (L1432-1439).
fn is_deadlock_scenario(net: &ColouredNet, marking: &linewright_nets::coloured::ColouredMarking) -> bool {
    let has = |place: &str, tones: &[u32]| net.count(marking, net.place_named(place).unwrap(), tones) > Some(0);
    let robot_2_busy = has("p5", &[1, 1]) || has("p6", &[1, 1]);
    let human_finished = has("p6", &[2, 2]) || has("p6", &[2, 3]);
    let robot_1_holds = has("p3", &[1, 1, 1]) || has("p4", &[1, 1, 1]);
    robot_2_busy && human_finished && robot_1_holds
}

/// With the reservation by t1 the scenario cannot be reached, and nothing else gets stuck; without it, both happen. The
/// parts outside are a bounded stand-in for an endless supply.
#[test]
fn the_reservation_is_what_prevents_the_deadlock() {
    let variant = PublishedCellVariant { outside: [2, 2, 1], ..PublishedCellVariant::default() };
    let net = cell(&variant);
    let safe = explore(&net, 1_000_000).unwrap();
    assert!(!safe.numbers().any(|state| is_deadlock_scenario(&net, safe.marking(state))));
    assert_eq!((safe.deadlocks().count(), safe.is_reversible()), (0, Ok(())));
    // Everything that colours allow to happen is live; t2 and others also have modes outside the work plan.
    let used = unfold(&net, Colours::Reachable, 10_000).unwrap();
    assert_eq!(used.net().transition_count(), 7 * 3 + 2 * 3);
    assert!(used.net().transitions().all(|t| safe.is_transition_live(used.mode(t)).is_ok()));
    // "Each of the above presented resources has capacity for handling only one part at time" (L1430).
    let m: Vec<_> = ["p3", "p4", "p7", "p8"].map(|p| safe.bound_of(&net, net.place_named(p).unwrap())).into();
    assert_eq!(m, [1; 4]);
    assert!((0..net.cell_count()).all(|cell| net.cell(cell).place.0 >= 8 || safe.bound_of_cell(cell) <= 1));

    let net = cell(&PublishedCellVariant { unreserved: true, ..variant });
    let unsafe_ = explore(&net, 1_000_000).unwrap();
    let scenario: Vec<StateId> =
        unsafe_.numbers().filter(|&state| is_deadlock_scenario(&net, unsafe_.marking(state))).collect();
    assert!(!scenario.is_empty());
    // Robot 2 can still finish and parts can still arrive, but nothing else ever happens again.
    let stuck = unsafe_.deadlocks().collect::<Vec<_>>();
    assert!(stuck.iter().any(|state| scenario.contains(state)));
    let t1 = mode(&net, "t1<m2,r1,p3>");
    assert!(unsafe_.is_transition_live(t1).is_err());
    let way = unsafe_.path_to(scenario[0]);
    let mut marking = net.initial_marking();
    way.iter().for_each(|&mode| net.fire(&mut marking, mode).unwrap());
    assert!(is_deadlock_scenario(&net, &marking), "the way to the first one can be played");
}

/// The same by the ordinary net: equal numbers of states, steps and deadlocks.
#[test]
fn the_unfolded_cell_says_the_same() {
    for unreserved in [false, true] {
        let net = cell(&PublishedCellVariant { outside: [1, 1, 1], unreserved, ..PublishedCellVariant::default() });
        let direct = explore(&net, 100_000).unwrap();
        for colours in [Colours::All, Colours::Reachable] {
            let unfolded = unfold(&net, colours, 10_000).unwrap();
            let ordinary = linewright_nets::explore(unfolded.net(), 100_000).unwrap();
            assert_eq!(ordinary.states().len(), direct.states().len());
            assert_eq!(ordinary.steps().len(), direct.steps().len());
            assert_eq!(ordinary.deadlocks().collect::<Vec<_>>(), direct.deadlocks().collect::<Vec<_>>());
        }
        // Only three of the six pairs of a machine and a part are in the work plan.
        let used = unfold(&net, Colours::Reachable, 10_000).unwrap();
        let p5 = used.net().places().filter(|&p| used.net().place_name(p).starts_with("p5")).count();
        assert_eq!(p5, 3);
    }
}
