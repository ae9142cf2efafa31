//! Against the slow and obvious exploration, on thousands of nets and every way to store them.

use linewright_random::Random;

use super::bitmap::BitmapLayout;
use super::encoding::MarkingEncoding;
use super::table::MarkingTable;
use super::testnets::any;
use super::*;
use crate::reach::{self, Reachability, StateId, explore};
use crate::{FireError, Marking, TransitionId};

/// Nets with more states are compared only in that they are undecided.
const ENOUGH: usize = 150;

fn limits(states: u64) -> ExplorationLimits {
    ExplorationLimits { states, ..ExplorationLimits::default() }
}

type Decided = Result<NetFacts, ExplorationUndecided>;

/// The net decided every way that there is, each with its name.
fn every_way(net: &Net, limits: &ExplorationLimits) -> Vec<(&'static str, Decided)> {
    let encoding = MarkingEncoding::of(net);
    let plain = MarkingEncoding::plain(net);
    let mut ways = vec![
        ("by itself", decide(net, limits)),
        ("table", on_table::decide(net, &encoding, limits)),
        ("table without sums", on_table::decide(net, &plain, limits)),
    ];
    for (name, least) in [("two digits per word", 32), ("three digits per word", 21)] {
        let decided = MarkingTable::with_bits(net, &plain, limits, least);
        ways.push((name, decided.and_then(|table| on_table::decide_in(table, net, &plain))));
    }
    for (name, bits, threads) in
        [("bitmap", 64, 1), ("two threads", 6, 2), ("narrow bitmap", 1, 1), ("three threads", 1, 3)]
    {
        if let Some(layout) = BitmapLayout::with_bits(&encoding, bits).filter(|layout| layout.words < 10_000) {
            let limits = ExplorationLimits { threads, ..*limits };
            ways.push((name, on_bitmap::decide(net, &encoding, &layout, &limits)));
        }
    }
    ways
}

/// Facts found by the obvious way, with those it does not return itself.
struct ReferenceResult {
    explored: Reachability,
    /// Per state, which states it leads to.
    futures: Vec<Vec<bool>>,
}

impl ReferenceResult {
    fn of(explored: Reachability) -> Self {
        let count = explored.states().len();
        let future = |start: usize| {
            let mut seen = vec![false; count];
            let mut stack = vec![start];
            seen[start] = true;
            while let Some(state) = stack.pop() {
                for step in explored.steps_from(StateId(state as u32)) {
                    if !std::mem::replace(&mut seen[step.to.index()], true) {
                        stack.push(step.to.index());
                    }
                }
            }
            seen
        };
        let futures = (0..count).map(future).collect();
        ReferenceResult { explored, futures }
    }

    fn number(&self, marking: &Marking) -> usize {
        self.explored.states().iter().position(|known| known == marking).expect("the marking is reachable")
    }

    /// States from which every state of their future leads back.
    fn terminal(&self) -> Vec<usize> {
        let back = |state: usize| (0..self.futures.len()).all(|to| !self.futures[state][to] || self.futures[to][state]);
        (0..self.futures.len()).filter(|&state| back(state)).collect()
    }

    fn compare(&self, net: &Net, facts: &NetFacts) {
        let explored = &self.explored;
        assert_eq!(facts.states, explored.states().len() as u64);
        assert_eq!(facts.arcs, explored.steps().len() as u64);
        let bounds: Vec<u32> = net.places().map(|place| explored.bound_of(place)).collect();
        assert_eq!(facts.bounds, bounds);
        assert_eq!(facts.bound(), explored.bound());
        let deadlocks: Vec<StateId> = explored.deadlocks().collect();
        assert_eq!(facts.deadlocks, deadlocks.len() as u64);
        assert_eq!(facts.deadlock.is_some(), !deadlocks.is_empty());
        if let Some(found) = &facts.deadlock {
            let state = StateId(self.number(&found.marking) as u32);
            assert!(deadlocks.contains(&state));
            self.compare_path(net, found);
        }
        for t in net.transitions() {
            assert_eq!(facts.fires[t.index()], explored.steps().iter().any(|step| step.transition == t));
            assert_eq!(facts.is_transition_live(t), explored.is_transition_live(t).is_ok());
            if let Some(marking) = &facts.lost[t.index()] {
                let future = &self.futures[self.number(marking)];
                assert!(explored.steps().iter().all(|step| step.transition != t || !future[step.from.index()]));
            }
        }
        self.compare_components(facts);
    }

    fn compare_components(&self, facts: &NetFacts) {
        assert_eq!(facts.is_reversible(), self.explored.is_reversible().is_ok());
        if let Some(marking) = &facts.no_return {
            assert!(!self.futures[self.number(marking)][0]);
        }
        let terminal = self.terminal();
        let firsts = terminal.iter().filter(|&&s| terminal.iter().all(|&t| t >= s || !self.futures[s][t])).count();
        assert_eq!(facts.terminal_components, firsts as u64);
        assert_eq!(facts.home.is_some(), firsts == 1);
        if let Some(home) = &facts.home {
            assert_eq!(home.states, terminal.len() as u64);
            assert!(terminal.contains(&self.number(&home.example)));
        }
    }

    /// The way leads there, and is as short as the one that breadth first search finds.
    fn compare_path(&self, net: &Net, found: &WitnessMarking) {
        let mut played = net.initial_marking();
        found.path.iter().for_each(|&t| net.fire(&mut played, t).expect("the path can be played"));
        assert_eq!(played, found.marking);
        let state = StateId(self.number(&found.marking) as u32);
        assert_eq!(found.path.len(), self.explored.path_to(state).len());
    }
}

fn nets(seed: u64, count: usize) -> impl Iterator<Item = Net> {
    let mut random = Random::new(seed);
    (0..count).map(move |_| any(&mut random))
}

#[test]
fn every_fact_is_what_the_obvious_exploration_finds() {
    let (mut decided, mut larger, mut bitmaps) = (0, 0, 0);
    for net in nets(1, 6000) {
        match explore(&net, ENOUGH) {
            Ok(explored) => {
                let truth = ReferenceResult::of(explored);
                for (way, facts) in every_way(&net, &limits(ENOUGH as u64)) {
                    let facts = facts.unwrap_or_else(|error| panic!("{way}: {error}\n{net}"));
                    let compared = std::panic::catch_unwind(|| truth.compare(&net, &facts));
                    assert!(compared.is_ok(), "{way}\n{net}");
                    bitmaps += usize::from(matches!(facts.storage, Storage::Bitmap { .. }));
                }
                decided += 1;
            }
            Err(reach::ReachUndecided { cause: reach::ReachLimit::Limit, .. }) => {
                let expected = ExplorationUndecided {
                    states: ENOUGH as u64,
                    cause: ExplorationLimit::States { limit: ENOUGH as u64 },
                };
                for (way, facts) in every_way(&net, &limits(ENOUGH as u64)) {
                    assert_eq!(facts.as_ref(), Err(&expected), "{way}\n{net}");
                }
                larger += 1;
            }
            Err(error) => panic!("{error}"),
        }
    }
    // The nets are worth testing with.
    assert!(decided > 3000 && larger > 300 && bitmaps > 5000, "{decided} {larger} {bitmaps}");
}

#[test]
fn a_limit_is_the_number_of_states_that_is_still_decided() {
    for net in nets(2, 300) {
        let Ok(explored) = explore(&net, 40) else { continue };
        let states = explored.states().len() as u64;
        for limit in 0..states + 2 {
            for (way, facts) in every_way(&net, &limits(limit)) {
                let expected = ExplorationUndecided { states: limit, cause: ExplorationLimit::States { limit } };
                match facts {
                    Ok(facts) => assert!(limit >= states && facts.states == states, "{way}\n{net}"),
                    // Nothing ends otherwise, and never when the states are enough.
                    Err(error) => assert!(limit < states && (limit == 0 || error == expected), "{way} {error}\n{net}"),
                }
            }
        }
    }
}

#[test]
fn too_few_bytes_are_said_not_exceeded() {
    for net in nets(3, 300) {
        let Ok(explored) = explore(&net, ENOUGH) else { continue };
        for bytes in [0, 100, 1000, 2000, 5000, 20_000, 100_000] {
            for (way, facts) in every_way(&net, &ExplorationLimits { bytes, ..limits(1000) }) {
                match facts {
                    Ok(facts) => {
                        assert_eq!(facts.states, explored.states().len() as u64, "{way}\n{net}");
                        assert!(facts.bytes <= bytes, "{way}\n{net}");
                    }
                    Err(ExplorationUndecided { cause: ExplorationLimit::Bytes { needs, limit }, .. }) => {
                        assert!(limit == bytes && needs > bytes, "{way}\n{net}");
                    }
                    Err(error) => panic!("{way}: {error}\n{net}"),
                }
            }
        }
    }
}

#[test]
fn what_is_found_is_found_by_a_shortest_way() {
    let mut random = Random::new(4);
    for net in nets(5, 1500) {
        let Ok(explored) = explore(&net, ENOUGH) else { continue };
        let truth = ReferenceResult::of(explored);
        let wanted = &truth.explored.states()[random.below(truth.futures.len())];
        let found = find_marking(&net, &limits(1000), wanted).unwrap().expect("it is reachable");
        assert_eq!(found.marking, *wanted);
        truth.compare_path(&net, &found);
        // A marking that may not be reachable.
        let other = Marking::from_tokens(net.places().map(|_| random.below(4) as u32));
        let reachable = truth.explored.states().contains(&other);
        assert_eq!(find_marking(&net, &limits(1000), &other).unwrap().is_some(), reachable, "{net}");
        // The first state with a property.
        let sum = |marking: &Marking| marking.total() % 3 == 2;
        let found = find(&net, &limits(1000), |view| sum(&view.to_marking())).unwrap();
        let first = truth.explored.states().iter().position(sum);
        let lengths = (found.map(|f| f.path.len()), first.map(|s| truth.explored.path_to(StateId(s as u32)).len()));
        assert_eq!(lengths.0, lengths.1, "{net}");
    }
}

#[test]
fn a_walk_shows_the_graph_of_the_obvious_exploration() {
    for net in nets(7, 1000) {
        let Ok(explored) = explore(&net, ENOUGH) else { continue };
        let (mut states, mut steps) = (Vec::new(), Vec::new());
        walk(&net, &limits(ENOUGH as u64), |event| match event {
            GraphEvent::State(state, view) => {
                assert_eq!(state.index(), states.len());
                states.push(view.to_marking());
            }
            GraphEvent::Arc { transition, to } => {
                let from = StateId(states.len() as u32 - 1);
                steps.push(reach::ReachArc { from, transition, to });
            }
        })
        .unwrap();
        assert_eq!(states, explored.states());
        assert_eq!(steps, explored.steps());
    }
}

#[test]
fn the_facts_do_not_depend_on_threads() {
    let mut compared = 0;
    for net in nets(8, 2000) {
        let encoding = MarkingEncoding::of(&net);
        let Some(layout) = BitmapLayout::with_bits(&encoding, 4).filter(|layout| (8..10_000).contains(&layout.words))
        else {
            continue;
        };
        let facts =
            |threads| on_bitmap::decide(&net, &encoding, &layout, &ExplorationLimits { threads, ..limits(10_000) });
        assert_eq!(facts(1), facts(2), "{net}");
        assert_eq!(facts(1), facts(5), "{net}");
        compared += 1;
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn a_place_that_overflows_is_named() {
    let mut b = crate::NetBuilder::new("flood");
    let (pool, spring) = (b.place("pool", 1), b.transition("spring"));
    b.output(spring, pool, u32::MAX);
    let net = b.build().unwrap();
    let error = decide(&net, &limits(10)).unwrap_err();
    let mut marking = net.initial_marking();
    let expected: FireError = net.fire(&mut marking, TransitionId(0)).unwrap_err();
    assert_eq!(error, ExplorationUndecided { states: 1, cause: ExplorationLimit::Overflow(expected) });
}

#[test]
fn weights_of_32_bits_are_compared_without_overflow() {
    const MANY: u32 = u32::MAX;
    // `made` turns into MANY of `bits`, so either follows from the other; `never` needs MANY of `made`.
    for (makes, asks) in [(MANY, MANY), (1 << 31, MANY), (1 << 20, MANY), (1000, MANY), (MANY, 2), (3, 2)] {
        let mut b = crate::NetBuilder::new("heavy");
        let [made, bits, once] = [("made", 0), ("bits", 0), ("once", 1)].map(|(name, n)| b.place(name, n));
        let [make, drop, never] = ["make", "drop", "never"].map(|name| b.transition(name));
        b.input(make, once, 1).output(make, made, 1).output(make, bits, makes);
        b.input(drop, once, 1);
        b.input(never, made, asks).output(never, made, asks);
        let net = b.build().unwrap();
        let truth = ReferenceResult::of(explore(&net, 10).unwrap());
        assert_eq!(truth.explored.deadlocks().count(), 2);
        for (_, facts) in every_way(&net, &limits(10)) {
            truth.compare(&net, &facts.unwrap());
        }
    }
}

#[test]
fn a_digit_widens_as_often_as_it_must() {
    // A counter that nothing bounds until 2²⁰ − 1 is drained by halves.
    let mut b = crate::NetBuilder::new("doubling");
    let [a, other, phase_a, phase_b] = [("a", 1), ("b", 0), ("to b", 1), ("to a", 0)].map(|(n, m)| b.place(n, m));
    let rounds = b.place("rounds", 6);
    let [double, back, turn, again] = ["double", "back", "turn", "again"].map(|name| b.transition(name));
    b.input(double, a, 1).input(double, phase_a, 1).output(double, phase_a, 1).output(double, other, 2);
    b.input(back, other, 1).input(back, phase_b, 1).output(back, phase_b, 1).output(back, a, 1);
    b.input(turn, phase_a, 1).output(turn, phase_b, 1);
    b.input(again, phase_b, 1).output(again, phase_a, 1).input(again, rounds, 1);
    let net = b.build().unwrap();
    let truth = explore(&net, 100_000).unwrap();
    for (way, facts) in every_way(&net, &limits(100_000)) {
        let facts = facts.unwrap();
        assert_eq!((facts.states, facts.arcs), (truth.states().len() as u64, truth.steps().len() as u64), "{way}");
        assert_eq!(facts.bound(), truth.bound(), "{way}");
        assert!(facts.bound() >= 64, "{way}");
    }
}
