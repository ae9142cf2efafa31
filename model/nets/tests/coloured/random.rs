//! Thousands of random coloured nets: direct play against the slow twin, and against the unfolding.

use std::collections::{BTreeMap, BTreeSet};

use linewright_nets::coloured::{
    ColouredBuilder, ColouredMarking, ColouredNet, ColouredReachability, Colours, NetMode, UnfoldError, Unfolding,
    explore, unfold,
};
use linewright_nets::{NetBuilder, PlaceId, ReachLimit, Reachability, StateId};
use linewright_random::Random;

use super::slow::{Fun, Raw, Tuple, function, tuples};

/// Most random nets have fewer states; those with more must be undecided in both.
const LIMIT: usize = 300;

/// A marking as the slow twin has it.
fn slow(net: &ColouredNet, marking: &ColouredMarking) -> BTreeMap<(usize, Tuple), i64> {
    let place = |p: PlaceId| net.tokens_on(marking, p).map(move |(tones, n)| ((p.index(), tones), i64::from(n)));
    net.places().flat_map(place).collect()
}

/// Tokens that a mode takes and gives, by the slow twin.
fn effect(net: &ColouredNet, mode: NetMode) -> [BTreeMap<(usize, Tuple), i64>; 2] {
    let [mut takes, mut gives] = [BTreeMap::new(), BTreeMap::new()];
    for p in net.places() {
        let [taken, given] = net.moves(mode, p);
        takes.extend(taken.into_iter().map(|(tones, n)| ((p.index(), tones), i64::from(n))));
        gives.extend(given.into_iter().map(|(tones, n)| ((p.index(), tones), i64::from(n))));
    }
    [takes, gives]
}

/// The enabled modes of every visited marking, and what firing them does, are what walking over all colours finds.
#[test]
fn enabled_modes_and_firing_are_what_walking_over_all_colours_finds() {
    let mut random = Random::new(14);
    let (mut checked, mut fired) = (0, 0);
    for _ in 0..3000 {
        let raw = Raw::random(&mut random);
        let net = raw.build();
        assert_eq!(slow(&net, &net.initial_marking()), raw.start());
        let mut marking = net.initial_marking();
        for _ in 0..6 {
            let before = slow(&net, &marking);
            let mut all = Vec::new();
            for t in net.transitions() {
                let mut fast = BTreeSet::new();
                for mode in net.enabled_modes(&marking, t) {
                    assert!(net.is_enabled(&marking, mode));
                    let mut after = marking.clone();
                    net.fire(&mut after, mode).unwrap();
                    assert!(fast.insert((net.mode_tones(mode), effect(&net, mode), slow(&net, &after))), "met twice");
                    all.push(mode);
                }
                // A universal domain is cut down to what is used; the twin walks over the rest too, to no effect.
                let kept: Vec<usize> = kept(&raw, &net, t.index());
                let expected: BTreeSet<_> = raw
                    .successors(&before, t.index())
                    .into_iter()
                    .map(|((mode, takes, gives), after)| {
                        (kept.iter().map(|&k| mode[k]).collect::<Vec<_>>(), [takes, gives], after)
                    })
                    .collect();
                assert_eq!(fast, expected, "{raw:?}");
                let off = net.modes(t).filter(|mode| !all.contains(mode)).count();
                let gamma = net.occurrence_modes(&marking, t).filter(|(_, can)| !can).count();
                assert_eq!(off, gamma);
                checked += 1;
            }
            if all.is_empty() {
                break;
            }
            let mode = *random.pick(&all);
            net.fire(&mut marking, mode).unwrap();
            fired += 1;
        }
    }
    assert!(checked > 10_000 && fired > 5_000, "{checked} {fired}");
}

/// Components of the declared domain that a transition has kept. A universal domain has each basic domain once.
fn kept(raw: &Raw, net: &ColouredNet, transition: usize) -> Vec<usize> {
    let has = net.transition_domain(linewright_nets::TransitionId(transition as u32));
    if raw.transitions[transition].domain.is_some() {
        return (0..has.len()).collect();
    }
    has.iter().map(|basic| basic.index()).collect()
}

fn agree(net: &ColouredNet, direct: &ColouredReachability, unfolded: &Unfolding, ordinary: &Reachability) {
    assert_eq!(direct.states().len(), ordinary.states().len(), "{net}");
    for (state, marking) in direct.numbers().zip(ordinary.states()) {
        assert_eq!(&unfolded.marking(direct.marking(state)).unwrap(), marking);
        assert_eq!(&unfolded.coloured(marking), direct.marking(state));
        assert_eq!(direct.find(direct.marking(state)), Some(state));
    }
    let steps = ordinary.steps().iter().map(|step| (step.from, unfolded.mode(step.transition), step.to));
    assert!(direct.steps().iter().map(|step| (step.from, step.transition, step.to)).eq(steps), "{net}");
    assert!(direct.deadlocks().eq(ordinary.deadlocks()));
    assert_eq!(direct.is_reversible().is_ok(), ordinary.is_reversible().is_ok());
    for p in unfolded.net().places() {
        let cell = unfolded.cell(net, p);
        let number = net.cell_of(cell.place, &tones(net, cell.place, cell.colour)).unwrap();
        assert_eq!(net.cell(number), cell);
        assert_eq!(unfolded.place_of(number), Some(p));
        assert_eq!(unfolded.net().place_name(p), net.cell_name(number));
        assert_eq!(direct.bound_of_cell(number), ordinary.bound_of(p));
    }
    for t in unfolded.net().transitions() {
        let mode = unfolded.mode(t);
        assert_eq!(net.mode_named(unfolded.net().transition_name(t)), Some(mode));
        assert_eq!(direct.is_transition_live(mode).is_ok(), ordinary.is_transition_live(t).is_ok());
    }
    let states: Vec<StateId> = direct.numbers().collect();
    let last = states[states.len() - 1];
    let mut marking = net.initial_marking();
    direct.path_to(last).into_iter().for_each(|mode| net.fire(&mut marking, mode).unwrap());
    assert_eq!(direct.find(&marking), Some(last));
}

fn tones(net: &ColouredNet, place: PlaceId, colour: u32) -> Tuple {
    let sizes: Vec<u32> = net.place_domain(place).iter().map(|basic| net.basics()[basic.index()].size()).collect();
    tuples(&sizes).swap_remove(colour as usize)
}

/// States, steps, deadlocks, bounds and live modes are those of the ordinary net, with all colours and with those that
/// can occur; and what is undecided for the one is undecided for the other, after as many states.
#[test]
fn exploring_directly_and_exploring_the_unfolding_agree() {
    let mut random = Random::new(788);
    let (mut decided, mut undecided, mut dropped) = (0, 0, 0);
    for _ in 0..4000 {
        let net = Raw::random(&mut random).build();
        let direct = explore(&net, LIMIT);
        let all = unfold(&net, Colours::All, 10_000).unwrap();
        let used = match unfold(&net, Colours::Reachable, 10_000) {
            Ok(used) => used,
            Err(why) => {
                assert_eq!(why, UnfoldError::Nothing);
                assert_eq!(direct.unwrap().steps(), [], "{net}");
                continue;
            }
        };
        assert_eq!(all.net().place_count(), net.cell_count() as usize);
        dropped += usize::from(used.net().transition_count() < all.net().transition_count());
        for unfolded in [&all, &used] {
            match (&direct, linewright_nets::explore(unfolded.net(), LIMIT)) {
                (Ok(direct), Ok(ordinary)) => agree(&net, direct, unfolded, &ordinary),
                (Err(direct), Err(ordinary)) => {
                    assert_eq!(direct.states, ordinary.states);
                    assert_eq!(direct.cause == ReachLimit::Limit, ordinary.cause == ReachLimit::Limit);
                }
                (direct, ordinary) => panic!("{net}: {direct:?} {ordinary:?}"),
            }
        }
        match direct {
            Ok(direct) => {
                decided += usize::from(direct.states().len() > 1);
                // What was dropped can indeed never fire.
                let gone = net.transitions().flat_map(|t| net.modes(t)).filter(|&m| used.transition_of(m).is_none());
                gone.for_each(|mode| assert!(direct.steps().iter().all(|step| step.transition != mode)));
            }
            Err(_) => undecided += 1,
        }
    }
    assert!(decided > 700 && undecided > 300 && dropped > 1000, "{decided} {undecided} {dropped}");
}

/// Random functions, with compositions and sums, against the step-by-step evaluation on tuples.
#[test]
fn functions_are_what_step_by_step_evaluation_gives() {
    let mut random = Random::new(823);
    let mut moved = 0;
    for _ in 0..4000 {
        let sizes: Vec<u32> = (0..3).map(|_| 1 + random.below(4) as u32).collect();
        let [from, middle, to] =
            [3, 3, 3].map(|most| (0..random.below(most + 1)).map(|_| random.below(3)).collect::<Vec<_>>());
        let Some(first) = function(&mut random, &from, &middle, &sizes) else { continue };
        let Some(last) = function(&mut random, &middle, &to, &sizes) else { continue };
        let fun = Fun::After(Box::new(last), Box::new(first));

        let mut b = ColouredBuilder::new("function");
        let basics: Vec<_> = (0..).zip(&sizes).map(|(i, &size)| b.basic(format!("B{i}"), size)).collect();
        let product = |domain: &[usize]| domain.iter().map(|&basic| basics[basic]).collect::<Vec<_>>();
        let (p, t) = (b.place("p", product(&to)), b.transition("t", product(&from)));
        b.output(t, p, fun.real());
        let net = b.build().unwrap();
        let sizes_of: Vec<u32> = from.iter().map(|&basic| sizes[basic]).collect();
        for tuple in tuples(&sizes_of) {
            let [_, gives] = net.moves(net.mode(t, &tuple).unwrap(), p);
            let expected = fun.apply(&tuple, &sizes_of).0;
            assert!(gives.iter().map(|(t, n)| (t, i64::from(*n))).eq(expected.iter().map(|(t, n)| (t, *n))), "{fun:?}");
            moved += 1;
        }
    }
    assert!(moved > 5_000, "{moved}");
}

/// succ and pred by the same number undo each other, for every colour, in either order; x turns of a ring of x are none.
#[test]
fn successor_and_predecessor_are_inverse() {
    let mut random = Random::new(809);
    for _ in 0..1000 {
        let sizes: Vec<u32> = (0..1 + random.below(3)).map(|_| 1 + random.below(5) as u32).collect();
        let k = 1 + random.below(sizes.len()) as u32;
        let by = random.below(12) as u32;
        let turn = sizes[k as usize - 1];
        let mut b = ColouredBuilder::new("inverse");
        let basics: Vec<_> = (0..).zip(&sizes).map(|(i, &size)| b.basic(format!("B{i}"), size)).collect();
        let p: Vec<_> = (0..4).map(|i| b.place(format!("p{i}"), basics.clone())).collect();
        let t = b.transition("t", basics);
        let (succ, pred) = (Fun::Succ(k, by), Fun::Pred(k, by));
        let after = |last: &Fun, first: &Fun| Fun::After(Box::new(last.clone()), Box::new(first.clone())).real();
        b.output(t, p[0], after(&succ, &pred)).output(t, p[1], after(&pred, &succ));
        b.output(t, p[2], Fun::Succ(k, by * turn).real()).output(t, p[3], succ.real());
        let net = b.build().unwrap();
        for tuple in tuples(&sizes) {
            let mode = net.mode(t, &tuple).unwrap();
            (0..3).for_each(|i| assert_eq!(net.moves(mode, p[i])[1], [(tuple.clone(), 1)]));
            // Definition 18 (L805-813), as it must be meant: ω + a if that is at most n, else ω + a − n.
            let mut next = tuple.clone();
            let tone = tuple[k as usize - 1] + by % turn;
            next[k as usize - 1] = if tone <= turn { tone } else { tone - turn };
            assert_eq!(net.moves(mode, p[3])[1], [(next, 1)]);
        }
    }
}

/// A net with nothing but <•> unfolds to the net it was made from: names, arcs, weights and marking.
#[test]
fn an_uncoloured_net_unfolds_to_itself() {
    let mut random = Random::new(815);
    for _ in 0..1000 {
        let mut b = NetBuilder::new("ordinary");
        let p: Vec<_> = (0..1 + random.below(5)).map(|i| b.place(format!("p{i}"), random.below(4) as u32)).collect();
        for i in 0..random.below(6) {
            let t = b.transition(format!("t{i}"));
            for &p in &p {
                if random.one_in(3) {
                    b.input(t, p, 1 + random.below(3) as u32);
                }
                if random.one_in(3) {
                    b.output(t, p, 1 + random.below(3) as u32);
                }
            }
        }
        let net = b.build().unwrap();
        let coloured = ColouredBuilder::from_net(&net).build().unwrap();
        let unfolded = unfold(&coloured, Colours::All, 1000).unwrap();
        assert_eq!(unfolded.net().to_string(), net.to_string());
        assert_eq!(unfolded.net().initial_marking(), net.initial_marking());
        match (explore(&coloured, 200), linewright_nets::explore(&net, 200)) {
            (Ok(direct), Ok(ordinary)) => agree(&coloured, &direct, &unfolded, &ordinary),
            (Err(direct), Err(ordinary)) => assert_eq!(direct.states, ordinary.states),
            (direct, ordinary) => panic!("{direct:?} {ordinary:?}"),
        }
    }
}
