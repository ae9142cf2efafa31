//! The dynamic LIFO storage, seed 000, Fig. 14, L1265-1336.
//!
//! Printed: the domains, the places and transitions, m₀, the guard l1 = n on t1 and t5 (L1336), and what t1 to t4 and t6
//! take (L1714 to L1778). Rebuilt: what t2, t3, t4, t5 and t6 give, and the functions of t4; they follow from the
//! meanings of the places and from the printed invariants, which are checked here.

use std::ops::RangeInclusive;

use linewright_nets::coloured::flow::{NotFlow, PlaceFlow, TransitionFlow};
use linewright_nets::coloured::{
    ColouredBuilder, ColouredNet, Colours, Domain, Guard, NetMode, abs, colour, explore, id, not_colour, pred, proj,
    ring, succ, unfold,
};

use super::{names, play};

/// The storage with `n` positions for parts of `m` kinds, the first `stored` (all of kind 1) of them taken.
///
/// As printed, the ring lets an item on position 1 go on "down" to position n. `repaired` adds the guards l1 ≠ 1 on t3
/// and l1 ≠ n on t6, without which the storage is not free of conflicts as Axiom 6 (L1806) has it.
fn lifo(n: u32, m: u32, stored: u32, repaired: bool) -> ColouredNet {
    marked(n, m, stored, stored + 1..=n, repaired)
}

/// The same with p2 as given.
fn marked(n: u32, m: u32, stored: u32, free_positions: RangeInclusive<u32>, repaired: bool) -> ColouredNet {
    let mut b = ColouredBuilder::new("LIFO");
    let l1 = b.basic("L1", n);
    let part = b.basic("P", m);
    let next = b.place("p1", l1);
    let free = b.place("p2", l1);
    let [busy, pushed, pulled] = ["p3", "p4", "p5"].map(|name| b.place(name, [l1, part]));
    let mutex = b.place("p6", Domain::Uncoloured);
    b.tokens(next, &[stored % n + 1], 1).tokens(mutex, &[], 1);
    free_positions.for_each(|position| _ = b.tokens(free, &[position], 1));
    (1..=stored).for_each(|position| _ = b.tokens(busy, &[position, 1], 1));

    let [t1, t2, t3, t4, t5, t6] =
        ["t1", "t2", "t3", "t4", "t5", "t6"].map(|name| b.transition(name, Domain::Universal));
    let after = || proj([1]).of(succ(1, 1));
    b.input(t1, free, proj([1])).input(t1, mutex, abs()).output(t1, pushed, id());
    b.input(t2, next, proj([1])).input(t2, pushed, id());
    b.output(t2, busy, id()).output(t2, next, after()).output(t2, mutex, abs());
    b.input(t3, pushed, id()).input(t3, free, proj([1]).of(pred(1, 1)));
    b.output(t3, pushed, pred(1, 1)).output(t3, free, proj([1]));
    b.input(t4, busy, id()).input(t4, mutex, abs()).input(t4, next, after());
    b.output(t4, pulled, id()).output(t4, next, proj([1]));
    b.input(t5, pulled, id()).output(t5, free, proj([1])).output(t5, mutex, abs());
    b.input(t6, pulled, id()).input(t6, free, after());
    b.output(t6, pulled, succ(1, 1)).output(t6, free, proj([1]));
    b.guard(t1, Guard::all([colour(1, n)])).guard(t5, Guard::all([colour(1, n)]));
    if repaired {
        b.guard(t3, Guard::all([not_colour(1, 1)])).guard(t6, Guard::all([not_colour(1, n)]));
    }
    b.build().unwrap()
}

fn sizes() -> impl Iterator<Item = (u32, u32)> {
    (2..=5).flat_map(|n| (1..=3).map(move |m| (n, m)))
}

fn at(net: &ColouredNet, transition: &str, position: u32, part: u32) -> NetMode {
    net.mode(net.transition_named(transition).unwrap(), &[position, part]).unwrap()
}

/// L1282-1330: |P| = |T| = 6 and m₀.
#[test]
fn the_net_is_as_printed() {
    let net = lifo(4, 2, 0, false);
    assert_eq!((net.place_count(), net.transition_count()), (6, 6));
    assert_eq!(net.describe(&net.initial_marking()), "p1<1>, p2<1>, p2<2>, p2<3>, p2<4>, p6");
    // Proposition 8 (L1810): t1 and t5 have only the colours of position n.
    for t in ["t1", "t5"] {
        let modes = net.modes(net.transition_named(t).unwrap());
        assert_eq!(names(&net, modes), [format!("{t}<4,1>"), format!("{t}<4,2>")]);
    }
}

/// The four printed place invariants. PI2 and PI4 are printed with `id` where the sum needs colours of one domain; the
/// proofs of propositions 3 and 5 read them as proj(1) and abs, and so does this. PI1 needs proj(1) around it too.
fn invariants(net: &ColouredNet) -> [PlaceFlow; 4] {
    let l1 = net.place_domain(net.place_named("p1").unwrap())[0];
    let p = |name| net.place_named(name).unwrap();
    let pi1 = [(p("p1"), proj([1])), (p("p3"), -proj([1]).of(succ(1, 1) - id()))];
    let pi2 = ["p2", "p3", "p4", "p5"].map(|name| (p(name), proj([1])));
    let pi3 = [(p("p1"), proj([1]).of(ring(1)))];
    let pi4 = ["p4", "p5", "p6"].map(|name| (p(name), abs()));
    [
        PlaceFlow::new(net, l1, pi1).unwrap(),
        PlaceFlow::new(net, l1, pi2).unwrap(),
        PlaceFlow::new(net, l1, pi3).unwrap(),
        PlaceFlow::new(net, Domain::Uncoloured, pi4).unwrap(),
    ]
}

/// L1603-1606: PI1 = <1>, PI2 = Σ<i>, PI3 = Σ<i>, PI4 = <•>; by functions, and in every reachable marking.
#[test]
fn the_printed_place_invariants_hold() {
    for (n, m) in sizes() {
        for repaired in [false, true] {
            let net = lifo(n, m, 0, repaired);
            let all: Vec<_> = (1..=n).map(|position| (vec![position], 1)).collect();
            let values = [vec![(vec![1], 1)], all.clone(), all, vec![(vec![], 1)]];
            let reached = explore(&net, 10_000).unwrap();
            for (flow, value) in invariants(&net).iter().zip(values) {
                assert_eq!(flow.check(&net, 0), Ok(()), "no mode has to be looked at");
                for state in reached.numbers() {
                    assert_eq!(flow.value(&net, reached.marking(state)), value);
                }
            }
        }
    }
}

/// Corollary 1 (L1788) prints p2 = Σ over 1 to n−(x+1) for the first x positions loaded, which PI2 refutes; from x+1 on
/// it is right.
#[test]
fn a_partly_loaded_storage_keeps_the_invariants() {
    for (n, m) in sizes() {
        for stored in 0..=n {
            let net = lifo(n, m, stored, true);
            let [pi1, pi2, ..] = invariants(&net);
            assert_eq!(pi1.value(&net, &net.initial_marking()), [(vec![1], 1)], "{stored} of {n}");
            assert_eq!(pi2.value(&net, &net.initial_marking()).len(), n as usize);
        }
    }
    let printed = marked(4, 1, 2, 1..=4 - (2 + 1), true);
    let [_, pi2, ..] = invariants(&printed);
    let sum = pi2.value(&printed, &printed.initial_marking());
    assert_eq!(sum, [(vec![1], 2), (vec![2], 1)], "position 1 is taken and free, 3 and 4 are neither");
}

/// L1607: tf1 = [<n,p> id R id <n,p> R]. With the whole ring in t3 and t6 it is null only for id = position n; L1832 has
/// the positions that are passed, and is null for every x.
#[test]
fn the_first_transition_flow_is_null_as_generalised() {
    for (n, m) in sizes() {
        let net = lifo(n, m, 0, false);
        for part in 1..=m {
            let flow = |at_end: u32, down: Vec<u32>, up: Vec<u32>| {
                let fixed = [("t1", n), ("t2", at_end), ("t4", at_end), ("t5", n)];
                let fixed = fixed.map(|(t, position)| (at(&net, t, position, part), 1));
                let down = down.into_iter().map(|position| (at(&net, "t3", position, part), 1));
                let up = up.into_iter().map(|position| (at(&net, "t6", position, part), 1));
                TransitionFlow::new(fixed.into_iter().chain(down).chain(up))
            };
            for x in 0..n {
                let passed = flow(x + 1, (x + 2..=n).collect(), (x + 1..n).collect());
                assert_eq!(passed.check(&net), Ok(()));
                assert_eq!(passed.forbidden(&lifo(n, m, 0, true)), []);
                let whole = flow(x + 1, (1..=n).collect(), (1..=n).collect());
                assert_eq!(whole.check(&net).is_ok(), x + 1 == n, "n={n} x={x}");
            }
        }
    }
}

/// L1608-1609, TI2 and TI3: the whole ring of t3 alone, and of t6 alone, is null. These turns pass from position 1 to n,
/// which is what the repaired guards exclude; the text itself claims "one, and only one" flow (L1808).
#[test]
fn the_second_and_third_transition_flow_are_turns_of_the_ring() {
    for (n, m) in sizes() {
        let (printed, repaired) = (lifo(n, m, 0, false), lifo(n, m, 0, true));
        for (t, wrong) in [("t3", 1), ("t6", n)] {
            for part in 1..=m {
                let turn = TransitionFlow::new((1..=n).map(|position| (at(&printed, t, position, part), 1)));
                assert_eq!(turn.check(&printed), Ok(()));
                assert_eq!(turn.forbidden(&printed), []);
                assert_eq!(turn.forbidden(&repaired), [at(&repaired, t, wrong, part)]);
            }
        }
    }
}

/// The minimal semiflows of the repaired net are those of L1832, one for each position and part. The net as printed has
/// these, the two turns for each part, and ways around the ring that the text does not mention.
#[test]
fn the_minimal_flows_of_the_repaired_net_are_the_generalised_ones() {
    for (n, m) in [(2, 1), (3, 2), (4, 1)] {
        let minimal = |net: &ColouredNet| {
            let unfolded = unfold(net, Colours::All, 10_000).unwrap();
            let found = TransitionFlow::minimal(&unfolded, &Default::default()).unwrap();
            assert!(found.iter().all(|flow| flow.check(net).is_ok() && flow.forbidden(net).is_empty()));
            found
        };
        let net = lifo(n, m, 0, true);
        let repaired = minimal(&net);
        assert_eq!(repaired.len() as u32, n * m);
        for flow in &repaired {
            let (down, up) = (net.transition_named("t3").unwrap(), net.transition_named("t6").unwrap());
            let steps = |t| flow.modes().filter(|(mode, _)| mode.transition == t).count();
            assert_eq!(steps(down), steps(up), "as far up as down");
            assert_eq!(flow.modes().count(), 4 + steps(down) + steps(up));
        }
        let printed = minimal(&lifo(n, m, 0, false));
        assert!(repaired.iter().all(|flow| printed.contains(flow)));
        assert_eq!(printed.iter().filter(|flow| flow.transitions().len() == 1).count() as u32, 2 * m);
    }
}

/// L1712-1714: empty, only t1 with colour n is enabled. L1804 and L1832: push and pull lead back to M₀.
#[test]
fn push_and_pull_lead_back() {
    for (n, m) in sizes() {
        let net = lifo(n, m, 0, false);
        let expected: Vec<_> = (1..=m).map(|part| format!("t1<{n},{part}>")).collect();
        assert_eq!(names(&net, net.enabled(&net.initial_marking())), expected);

        for x in 0..n {
            for repaired in [false, true] {
                let net = lifo(n, m, x, repaired);
                let mut marking = net.initial_marking();
                let mut sequence = vec![format!("t1<{n},{m}>")];
                sequence.extend((x + 2..=n).rev().map(|position| format!("t3<{position},{m}>")));
                sequence.extend([format!("t2<{},{m}>", x + 1), format!("t4<{},{m}>", x + 1)]);
                sequence.extend((x + 1..n).map(|position| format!("t6<{position},{m}>")));
                sequence.push(format!("t5<{n},{m}>"));
                assert_eq!(sequence.len(), 4 + 2 * (n - x - 1) as usize);
                play(&net, &mut marking, &sequence.iter().map(String::as_str).collect::<Vec<_>>());
                assert_eq!(marking, net.initial_marking());
            }
        }
    }
}

/// Proposition 7 (L1692) and the conclusions (L1846): bounded, no deadlock, reversible. The number of states is counted
/// here by hand: m^x ways to have x items at rest; and with an item on its way to the position x+1 or from it, m^(x+1)
/// ways, n−x positions, two directions.
#[test]
fn the_repaired_storage_is_live_and_reversible() {
    for (n, m) in sizes() {
        let net = lifo(n, m, 0, true);
        let reached = explore(&net, 10_000).unwrap();
        let rest: u32 = (0..=n).map(|x| m.pow(x)).sum();
        let moving: u32 = (0..n).map(|x| 2 * m.pow(x + 1) * (n - x)).sum();
        assert_eq!(reached.states().len(), (rest + moving) as usize);
        assert_eq!((reached.deadlocks().count(), reached.is_reversible()), (0, Ok(())));
        // Position x+1 is reached by pushing for every x < n, so all modes that the guards leave are live.
        assert!(reached.is_live());
    }
}

/// Axiom 6 (L1806) requires resource models without conflicts. Repaired, there remain the choice between push and pull,
/// which the text admits (L1732), and that of the part to push. As printed, t3 competes with t2, and t6 with t5.
#[test]
fn the_repair_leaves_only_the_choice_of_what_to_do_next() {
    let pairs = |net: &ColouredNet| {
        let reached = explore(net, 10_000).unwrap();
        let conflicts = reached.numbers().flat_map(|state| net.conflicts(reached.marking(state)));
        let name = |mode: NetMode| net.transition(mode.transition).name.to_string();
        let mut found: Vec<_> = conflicts.map(|pair| (name(pair.winner), name(pair.loser))).collect();
        found.sort();
        found.dedup();
        found.iter().map(|(winner, loser)| format!("{winner}-{loser}")).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(pairs(&lifo(3, 2, 0, true)), "t1-t1 t1-t4 t4-t1");
    assert_eq!(pairs(&lifo(3, 2, 0, false)), "t1-t1 t1-t4 t2-t3 t3-t2 t4-t1 t5-t6 t6-t5");
}

/// A weighting that is no flow is refused with the mode that shows it.
#[test]
fn a_wrong_invariant_is_refused() {
    let net = lifo(3, 1, 0, true);
    let l1 = net.basics().iter().position(|basic| basic.name() == "L1").unwrap() as u32;
    let weights = ["p2", "p3", "p4"].map(|name| (net.place_named(name).unwrap(), proj([1])));
    let flow = PlaceFlow::new(&net, linewright_nets::coloured::BasicId(l1), weights).unwrap();
    let refused = flow.check(&net, 100).unwrap_err();
    assert_eq!(refused.to_string(), "t4<1,1> changes the sum by -1 at <1>");
    assert_eq!(flow.check(&net, 0), Err(NotFlow::Undecided { modes: 0 }));
}
