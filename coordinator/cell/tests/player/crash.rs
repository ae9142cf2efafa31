//! The coordinator is killed after every step of a run, and the production is the same.
//!
//! *The same* means: as many finished parts of each kind, everything where it belongs, and every task done as often with
//! each part. Not at the same times, and not in the same order: without a coordinator, what runs goes on.

use std::collections::BTreeMap;

use linewright_coordinator_cell::{Fifo, PartId, TaskRefusal};
use linewright_line::Tick;
use linewright_nets::NetBuilder;
use linewright_nets::coloured::{Clause, ColouredBuilder, Guard, colour, id, proj};

use super::plans::{Compiled, PARTS, TOKENS, ordered};
use super::workcell::{self, Workcell};
use super::world::{World, options};
use linewright_random::Random as Dice;

/// The cell of seed 000 in activities: loading is t1 to t3, unloading is t5 to t7.
pub fn merged(waiting: [u32; 3]) -> Compiled {
    let mut b = ColouredBuilder::new("cell");
    let m = b.named_basic("M", ["m1", "m2"]);
    let r = b.named_basic("R", ["r1"]);
    let p = b.named_basic("P", ["p1", "p2", "p3"]);
    let (free, robot, input, output) =
        (b.place("free", m), b.place("robot", r), b.place("input", p), b.place("output", p));
    let [loaded, ready] = ["loaded", "ready"].map(|name| b.place(name, [m, p]));
    b.tokens(free, &[1], 1).tokens(free, &[2], 1).tokens(robot, &[1], 1);
    (1..).zip(waiting).for_each(|(kind, count)| _ = b.tokens(input, &[kind], count));
    let [load, unload] = ["load", "unload"].map(|name| b.transition(name, [m, r, p]));
    let work = b.transition("work", [m, p]);
    b.input(load, free, proj([1])).input(load, robot, proj([2])).input(load, input, proj([3]));
    b.output(load, robot, proj([2])).output(load, loaded, proj([1, 3]));
    b.input(work, loaded, id()).output(work, ready, id());
    b.input(unload, ready, proj([1, 3])).input(unload, robot, proj([2]));
    b.output(unload, free, proj([1])).output(unload, robot, proj([2])).output(unload, output, proj([3]));
    let plan =
        |part| Guard::any([(1, 1), (2, 2), (2, 3)].map(|(on, kind)| Clause::all([colour(1, on), colour(part, kind)])));
    b.guard(load, plan(3)).guard(unload, plan(3)).guard(work, plan(2));
    Compiled::new(
        b.build().unwrap(),
        |name| if name.starts_with("free") || name.starts_with("robot") { TOKENS } else { PARTS },
        |name| {
            let target = if name.contains("m1") { 1 } else { 2 };
            match name.split_once('<').unwrap().0 {
                "work" => ordered("work", &[target], 60_000),
                carried => ordered(carried, &[0, target], 60_000),
            }
        },
    )
}

/// Result: the marking, and how often each station did what with each part.
type Production = (Vec<u64>, BTreeMap<(usize, String, Option<PartId>), usize>);

fn production(world: &World) -> Production {
    let mut done = BTreeMap::new();
    for (index, station) in world.stations.iter().enumerate() {
        let mut keys: Vec<_> = station.done.iter().map(|done| done.key).collect();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), station.done.len(), "station {index} has done a key twice");
        let acts = station.done.iter();
        acts.for_each(|act| *done.entry((index, act.task.to_string(), act.part)).or_default() += 1);
    }
    (world.state().marking().counts().to_vec(), done)
}

const LONG: Tick = Tick::from_millis(3_600_000);

/// Runs to the end, and then again with the coordinator killed at each of its steps; how many steps that were.
fn killed_everywhere(make: impl Fn(Vec<usize>) -> World) -> usize {
    let mut calm = make(Vec::new());
    calm.run(&mut Fifo, LONG);
    let expected = production(&calm);
    assert_eq!(calm.lives, 1);
    for at in 0..calm.steps {
        let mut world = make(vec![at]);
        world.run(&mut Fifo, LONG);
        assert_eq!(world.lives, 2, "killed at {at}");
        assert_eq!(world.state().firings().len(), 0, "killed at {at}: {:?}", world.state().firings().next());
        assert_eq!(production(&world), expected, "killed at {at}");
    }
    calm.steps
}

#[test]
fn the_printed_cell_survives_a_crash_at_every_step() {
    let make = |crash_at| World::with(merged([2, 2, 1]), 3, options(4, 0, crash_at));
    let steps = killed_everywhere(make);
    // 15 activities that start and end; 25 orders that are sent, taken on and done.
    assert!(steps >= 15 * 2 + 25 * 3, "{steps}");
    let mut world = make(Vec::new());
    world.run(&mut Fifo, LONG);
    let state = world.state();
    assert_eq!([1, 2, 3].map(|kind| state.marking().count(world.it.cell(&format!("output<p{kind}>")))), [2, 2, 1]);
    assert_eq!(world.stations.iter().map(|station| station.done.len()).sum::<usize>(), 5 * (2 + 1 + 2));
}

#[test]
fn it_survives_them_with_messages_lost_and_doubled() {
    let mut doubled = 0;
    for seed in 0..3 {
        killed_everywhere(|crash_at| World::with(merged([1, 1, 1]), 3, options(seed, 4, crash_at)));
        let mut world = World::with(merged([2, 2, 2]), 3, options(seed, 4, Vec::new()));
        world.run(&mut Fifo, LONG);
        doubled += world.stations.iter().map(|station| station.doubled).sum::<usize>();
    }
    assert!(doubled > 10, "no station was told anything twice: {doubled}");
}

#[test]
fn it_survives_being_killed_again_and_again() {
    let mut dice = Dice::new(33);
    for seed in 0..40 {
        let make = |crash_at| World::with(merged([2, 2, 1]), 3, options(seed, 5, crash_at));
        let mut calm = make(Vec::new());
        calm.run(&mut Fifo, LONG);
        let mut at = 0;
        let crash_at = (0..10)
            .map(|_| {
                at += 1 + dice.below(30);
                at
            })
            .collect();
        let mut world = make(crash_at);
        world.run(&mut Fifo, LONG);
        assert!(world.lives > 4, "{}", world.lives);
        assert_eq!(production(&world), production(&calm), "{seed}");
        assert_eq!(world.state().firings().len(), 0);
    }
}

/// One station that may have several orders at once, each for a part of its own.
fn bench(parts: u32, hands: u32) -> Compiled {
    let mut b = NetBuilder::new("bench");
    let [stored, hand, out] = [("stored", parts), ("hands", hands), ("out", 0)].map(|(name, n)| b.place(name, n));
    for way in 0..hands {
        let fetch = b.transition(format!("fetch {way}"));
        b.input(fetch, stored, 1).input(fetch, hand, 1).output(fetch, hand, 1).output(fetch, out, 1);
    }
    let net = ColouredBuilder::from_net(&b.build().unwrap()).build().unwrap();
    let kind = |name: &str| if name == "hands" { TOKENS } else { PARTS };
    Compiled::new(net, kind, |_| ordered("fetch", &[0], 600_000))
}

/// A station gets its orders one after the other, the oldest first, also where several activities wait for it: one that is
/// overtaken by a later one would be refused as old.
#[test]
fn orders_reach_a_station_in_their_order_whatever_the_network_does() {
    for seed in 0..30 {
        let mut world = World::with(bench(8, 3), 1, options(seed, 5, vec![20, 45]));
        world.run(&mut Fifo, LONG);
        let station = &world.stations[0];
        assert!(station.done.is_sorted_by_key(|done| done.key.id));
        assert_eq!((station.done.len(), world.state().firings().len()), (8, 0), "{:?}", world.state().firings().next());
        // While it is busy with one, it will not have another, and is asked again.
        assert!(station.refused.contains(&TaskRefusal::Busy) && !station.refused.contains(&TaskRefusal::Old));
    }
}

/// Workcells by chance: parts with plans of several steps, machines, a robot, a store; parts enter and leave.
#[test]
fn workcells_survive_a_crash_at_every_step() {
    for seed in 0..6 {
        let make = |crash_at| {
            let cell = Workcell::random(&mut Dice::new(seed));
            let stations = cell.stations();
            let bad_luck = if seed % 2 == 0 { 0 } else { 6 };
            World::with(workcell::compiled(&cell), stations, options(seed, bad_luck, crash_at))
        };
        let mut calm = make(Vec::new());
        calm.run(&mut Fifo, LONG);
        assert!(calm.state().left() > 0, "nothing was produced");
        let expected = workcell::production(&calm);
        for at in 0..calm.steps {
            let mut world = make(vec![at]);
            world.run(&mut Fifo, LONG);
            assert_eq!(world.lives, 2, "seed {seed}, killed at {at}");
            assert_eq!(workcell::production(&world), expected, "seed {seed}, killed at {at}");
        }
    }
}
