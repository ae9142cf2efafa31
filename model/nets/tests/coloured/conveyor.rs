//! The linear conveyor, seed 000, §7.4, L3790: first in, first out, three positions, three kinds of objects.
//!
//! The net (Fig. 83) is lost. Printed are the sizes alone; this is the obvious net for them, checked to be what its name
//! means.

use std::collections::{BTreeSet, VecDeque};

use linewright_nets::coloured::{
    ColouredBuilder, ColouredNet, Colours, Domain, Guard, colour, explore, id, not_colour, proj, succ, unfold,
};

fn conveyor(positions: u32, kinds: u32) -> ColouredNet {
    let mut b = ColouredBuilder::new("FIFO Buffer");
    let (at, kind) = (b.basic("MODUL", positions), b.basic("PART", kinds));
    let (free, carried) = (b.place("free", at), b.place("carried", [at, kind]));
    (1..=positions).for_each(|position| _ = b.tokens(free, &[position], 1));
    let [load, forward, unload] = ["load", "forward", "unload"].map(|name| b.transition(name, Domain::Universal));
    b.input(load, free, proj([1])).output(load, carried, id()).guard(load, Guard::all([colour(1, 1)]));
    b.input(forward, carried, id()).input(forward, free, proj([1]).of(succ(1, 1)));
    b.output(forward, carried, succ(1, 1)).output(forward, free, proj([1]));
    b.guard(forward, Guard::all([not_colour(1, positions)]));
    b.input(unload, carried, id()).output(unload, free, proj([1])).guard(unload, Guard::all([colour(1, positions)]));
    b.build().unwrap()
}

/// Each position is empty or has one of the kinds: (3 + 1)³ states, all of which occur.
#[test]
fn three_positions_and_three_kinds_make_64_states() {
    let net = conveyor(3, 3);
    let reached = explore(&net, 1000).unwrap();
    assert_eq!(reached.states().len(), 64);
    assert_eq!((reached.is_live(), reached.is_reversible()), (true, Ok(())));
    let unfolded = unfold(&net, Colours::Reachable, 1000).unwrap();
    assert_eq!(linewright_nets::explore(unfolded.net(), 1000).unwrap().steps().len(), reached.steps().len());
}

/// Beside each state, what was loaded and not yet unloaded, in order: it must always be the front that comes out. The
/// pairs of a state and such a queue are explored; if the order could be broken, some pair would show it.
#[test]
fn what_comes_first_leaves_first() {
    let net = conveyor(3, 3);
    let [load, unload] = ["load", "unload"].map(|name| net.transition_named(name).unwrap());
    let mut seen = BTreeSet::from([(net.initial_marking(), VecDeque::new())]);
    let mut open: Vec<_> = seen.iter().cloned().collect();
    while let Some((marking, queue)) = open.pop() {
        for mode in net.enabled(&marking) {
            let (mut after, mut queue, kind) = (marking.clone(), queue.clone(), net.mode_tones(mode)[1]);
            net.fire(&mut after, mode).unwrap();
            if mode.transition == load {
                queue.push_back(kind);
            } else if mode.transition == unload {
                assert_eq!(queue.pop_front(), Some(kind));
            }
            if seen.insert((after.clone(), queue.clone())) {
                open.push((after, queue));
            }
        }
    }
    assert_eq!(seen.len(), 64, "the queue follows from the state");
}
