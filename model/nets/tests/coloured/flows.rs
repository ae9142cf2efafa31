//! Coloured flows against the incidence matrix of the unfolding, and decisions and steps against their definitions.

use linewright_nets::coloured::decide::ModeConflict;
use linewright_nets::coloured::flow::{FlowError, NotFlow, PlaceFlow, TransitionFlow};
use linewright_nets::coloured::{
    BasicId, ColouredBuilder, ColouredNet, Colours, Comparison, Domain, Guard, NetMode, compare, component, explore,
    id, proj, unfold,
};
use linewright_random::Random;

use super::slow::{Fun, Raw, function, tuples};

/// The weights of a random place-flow: for some places a function into a common domain, some of them negative.
fn weights(random: &mut Random, raw: &Raw, target: &[usize]) -> Vec<(usize, Fun)> {
    let mut found = Vec::new();
    for (place, domain) in raw.places.iter().enumerate() {
        if let Some(fun) = function(random, domain, target, &raw.sizes).filter(|_| !random.one_in(4)) {
            found.push((place, if random.one_in(4) { Fun::Times(-1, Box::new(fun)) } else { fun }));
        }
    }
    found
}

/// A coloured place-flow is one iff, for every colour of the common domain, its weights are a place invariant of the
/// unfolding; and its value is then the same in every reachable marking.
#[test]
fn a_place_flow_is_one_of_the_unfolding() {
    let mut random = Random::new(1590);
    let (mut holds, mut broken, mut by_modes) = (0, 0, 0);
    for _ in 0..4000 {
        let raw = Raw::random(&mut random);
        let net = raw.build();
        let target: Vec<usize> = (0..random.below(2)).map(|_| random.below(raw.sizes.len())).collect();
        let weights = weights(&mut random, &raw, &target);
        let sizes: Vec<u32> = target.iter().map(|&basic| raw.sizes[basic]).collect();
        let domain = Domain::Product(target.iter().map(|&b| BasicId(b as u32)).collect());
        let real = weights.iter().map(|(place, fun)| (linewright_nets::PlaceId(*place as u32), fun.real()));
        let flow = PlaceFlow::new(&net, domain, real).unwrap();

        let unfolded = unfold(&net, Colours::All, 10_000).unwrap();
        let incidence = unfolded.net().incidence();
        let holds_for = |colour: &Vec<u32>| {
            let weight = |p| {
                let cell = unfolded.cell(&net, p);
                let sizes: Vec<u32> = raw.places[cell.place.index()].iter().map(|&basic| raw.sizes[basic]).collect();
                let tones = &tuples(&sizes)[cell.colour as usize];
                let of = weights.iter().find(|(place, _)| *place == cell.place.index());
                of.map_or(0, |(_, fun)| fun.apply(tones, &sizes).0.get(colour).copied().unwrap_or(0))
            };
            let weights: Vec<i64> = unfolded.net().places().map(weight).collect();
            incidence.place_invariant(&weights).is_ok()
        };
        let expected = tuples(&sizes).iter().all(holds_for);
        assert_eq!(flow.check(&net, usize::MAX).is_ok(), expected, "{net}{weights:?}");
        by_modes += usize::from(expected && flow.check(&net, 0).is_err());
        if expected {
            holds += usize::from(!weights.is_empty());
            if let Ok(reached) = explore(&net, 100) {
                let value = flow.value(&net, &net.initial_marking());
                reached.numbers().for_each(|state| assert_eq!(flow.value(&net, reached.marking(state)), value));
            }
        } else {
            broken += 1;
        }
    }
    assert!(holds > 100 && broken > 1000 && by_modes > 0, "{holds} {broken} {by_modes}");
}

/// A mode that a guard excludes cannot break a flow, and only a search of modes shows it.
#[test]
fn a_guard_can_make_a_flow() {
    for guarded in [false, true] {
        let mut b = ColouredBuilder::new("pass on");
        let a = b.basic("A", 3);
        let (p, q, t) = (b.place("p", a), b.place("q", a), b.transition("t", [a, a]));
        b.input(t, p, proj([1])).output(t, q, proj([2]));
        if guarded {
            b.guard(t, Guard::all([compare(component(1), Comparison::Equal, component(2))]));
        }
        let net = b.build().unwrap();
        let flow = PlaceFlow::new(&net, a, [(p, id()), (q, id())]).unwrap();
        assert_eq!(flow.check(&net, 2), Err(if guarded { NotFlow::Undecided { modes: 2 } } else { changed(&net) }));
        assert_eq!(flow.check(&net, 3).is_ok(), guarded);
    }
}

fn changed(net: &ColouredNet) -> NotFlow {
    let id = net.mode_named("t<1,2>").unwrap();
    NotFlow::Changed { mode: "t<1,2>".to_owned(), id, colour: "<1>".to_owned(), change: -1 }
}

#[test]
fn a_weighting_that_makes_no_sense_is_refused() {
    let mut b = ColouredBuilder::new("two");
    let (a, c) = (b.basic("A", 3), b.basic("C", 2));
    let (p, q) = (b.place("p", [a, c]), b.place("q", c));
    let net = b.build().unwrap();
    let weights = [(p, proj([1])), (p, proj([1])), (q, id()), (q, proj([2])), (linewright_nets::PlaceId(5), id())];
    let problems = PlaceFlow::new(&net, a, weights).unwrap_err();
    let messages: Vec<_> = problems.iter().map(ToString::to_string).collect();
    assert_eq!(
        messages,
        [
            "the flow weighs place `p` twice; add the functions up",
            "the flow weighs place `q` by `id`, which leads to C, and not to A",
            "the flow weighs place `q` by `proj(2)`: `proj(2)` names component 2, but what it is applied to is of C",
            "the flow weighs place #5, but the net has 2 places",
        ]
    );
    assert_eq!(PlaceFlow::new(&net, BasicId(2), []).unwrap_err(), [FlowError::Target]);
}

/// A bag of modes is a transition-flow iff its counts are a transition invariant of the unfolding. Bags are taken from
/// closed walks, so that many are.
#[test]
fn a_transition_flow_is_one_of_the_unfolding() {
    let mut random = Random::new(1609);
    let (mut closed, mut open) = (0, 0);
    for _ in 0..2000 {
        let net = Raw::random(&mut random).build();
        let Ok(reached) = explore(&net, 100) else { continue };
        let unfolded = unfold(&net, Colours::All, 10_000).unwrap();
        let mut marking = net.initial_marking();
        let mut modes: Vec<NetMode> = Vec::new();
        for _ in 0..8 {
            let here = reached.find(&marking).unwrap();
            let Some(step) = Some(reached.steps_from(here)).filter(|s| !s.is_empty()).map(|s| *random.pick(s)) else {
                break;
            };
            marking = reached.marking(step.to).clone();
            modes.push(step.transition);
            let flow = TransitionFlow::new(modes.iter().map(|&mode| (mode, 1)));
            let incidence = unfolded.net().incidence();
            let entry = |place, mode| incidence.entry(place, unfolded.transition_of(mode).unwrap());
            let expected = unfolded.net().places().all(|p| modes.iter().map(|&mode| entry(p, mode)).sum::<i64>() == 0);
            assert_eq!(flow.check(&net).is_ok(), expected);
            assert_eq!(expected, marking == net.initial_marking(), "what changes nothing leads back");
            assert_eq!(flow.forbidden(&net), []);
            if expected { closed += 1 } else { open += 1 }
        }
    }
    assert!(closed > 300 && open > 300, "{closed} {open}");
}

/// Conflicts follow their definition (L2777-2782), and modes that can fire together can fire in any order.
#[test]
fn conflicts_and_joint_firing_follow_their_definitions() {
    let mut random = Random::new(2777);
    let (mut torn, mut together) = (0, 0);
    for _ in 0..2000 {
        let net = Raw::random(&mut random).build();
        let marking = net.initial_marking();
        let enabled = net.enabled(&marking);
        let conflicts = net.conflicts(&marking);
        for &winner in &enabled {
            for &loser in &enabled {
                let after = fired(&net, &marking, &[winner]).unwrap();
                let disables = winner != loser && !net.enabled(&after).contains(&loser);
                assert_eq!(conflicts.contains(&ModeConflict { winner, loser }), disables);
                torn += usize::from(disables);
                if net.is_enabled_together(&marking, &[winner, loser]) {
                    let mut both = marking.clone();
                    net.fire_together(&mut both, &[winner, loser]).unwrap();
                    assert_eq!(fired(&net, &marking, &[winner, loser]), Some(both.clone()));
                    assert_eq!(fired(&net, &marking, &[loser, winner]), Some(both));
                    together += 1;
                } else {
                    let mut same = marking.clone();
                    assert!(net.fire_together(&mut same, &[winner, loser]).is_err());
                    assert_eq!(same, marking, "a refusal changes nothing");
                }
            }
        }
    }
    assert!(torn > 300 && together > 300, "{torn} {together}");
}

fn fired(
    net: &ColouredNet,
    marking: &linewright_nets::coloured::ColouredMarking,
    modes: &[NetMode],
) -> Option<linewright_nets::coloured::ColouredMarking> {
    let mut marking = marking.clone();
    modes.iter().all(|&mode| net.fire(&mut marking, mode).is_ok()).then_some(marking)
}
