//! The two shipped cells, from their descriptions to finished parts.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use linewright_cell::net::Supply;
use linewright_coordinator_cell::compile::{CompiledCell, OrderTiming, Unplayable, compile_cell, dispatcher};
use linewright_coordinator_cell::dispatch::Fairness;
use linewright_coordinator_cell::texts;
use linewright_coordinator_cell::{
    ActivityTiming, DispatchDecision, Dispatcher, Fifo, HeldCandidate, HoldReason, PlayerOutbox, PlayerState, Question,
    RecordKind, TaskParameterValue,
};
use linewright_line::Tick;

use crate::player::plans::Compiled;
use crate::player::printed::Script;
use crate::player::world::World;

pub const C1: &str = include_str!("../../../launch-config/lines/workcell-c1/cell.toml");
const ASSEMBLY: &str = include_str!("../../../launch-config/lines/assembly-cell/cell.toml");
const PACE: OrderTiming = OrderTiming { repeat_interval: Duration::from_millis(200), grace: Duration::from_secs(1) };

pub fn made(text: &str, supply: Supply<'_>) -> CompiledCell {
    let cell = linewright_cell::parse("cell.toml", text, None).unwrap_or_else(|problems| panic!("{problems:#}")).cell;
    compile_cell(&cell, None, supply, PACE).unwrap_or_else(|why| panic!("{why}"))
}

pub fn world(made: CompiledCell, stations: usize, seed: u64) -> World {
    let it = Compiled { net: made.net.net().clone(), long: made.long, table: Arc::new(made.table) };
    World::new(it, stations, seed)
}

/// A3, seed 000, L2738-2740: robot 2 has finished a part 1, the human is free, parts 2 and 3 wait; possible are exactly t1
/// with part 2 and with part 3, and t5 with part 1.
#[test]
fn the_conflict_of_figure_41_arises_in_the_described_cell() {
    let starts = ["arrive<1.new>", "arrive<2.new>", "arrive<3.new>", "load robot_2<1.new>", "robot_2.process<1.new>"];
    let mut script = Script { starts: starts.to_vec(), ..Script::default() };
    let mut world = world(made(ASSEMBLY, Supply::Closed(&[1, 1, 1])), 3, 1);
    world.run(&mut script, Tick::from_millis(120_000));
    assert_eq!(script.starts, [""; 0], "all of it was played");
    assert_eq!(script.asked, ["load human<2.new>", "load human<3.new>", "unload robot_2<1.done>"]);
}

/// A4, seed 000, L2924-2944, by the rules of the description: nothing is planned, so the shortest goes first. The unloading
/// takes 3 s; loading the human 2 s, which then works for 5 s on part 2, for 4 s on part 3 (L2029-2035).
#[test]
fn the_described_cell_decides_its_conflict_by_its_own_rules() {
    let starts = ["arrive<1.new>", "arrive<2.new>", "arrive<3.new>", "load robot_2<1.new>", "robot_2.process<1.new>"];
    let mut script = Script { starts: starts.to_vec(), ..Script::default() };
    let mut world = world(made(ASSEMBLY, Supply::Closed(&[1, 1, 1])), 3, 1);
    world.run(&mut script, Tick::from_millis(60_000));
    let cell = linewright_cell::parse("cell.toml", ASSEMBLY, None).expect("it is sound").cell;
    let mut by_rules = dispatcher(&cell, &world.it.table);
    // What was scripted has taken longer than parts should wait.
    by_rules.fairness = Fairness::OFF;
    let mut out = PlayerOutbox::default();
    let now = world.now;
    world.coordination.reconsider();
    world.coordination.step(now, &[], &mut by_rules, &mut out);
    let RecordKind::Decided { started, held, .. } = &out.records[0].fact else { panic!("{:?}", out.records) };
    let said = texts::decision(&world.it.table, started, held);
    assert_eq!(started.len(), 1);
    assert!(said[0].starts_with("`unload robot_2` with part "), "{said:?}");
    assert!(said[1].contains("by shortest-processing-time (takes 3 s; the other takes 7 s)"), "{said:?}");
    assert!(said[2].contains("by shortest-processing-time (takes 3 s; the other takes 6 s)"), "{said:?}");
}

/// Lets so many parts of each type in, and leaves the rest to the first come.
struct LetIn {
    left: BTreeMap<&'static str, usize>,
}

impl Dispatcher for LetIn {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        let mut answer = Fifo.decide(question);
        let table = question.state.table();
        answer.start.retain(|start| {
            let name = table.mode_name(question.candidates[start.candidate].mode);
            let Some(left) = self.left.get_mut(name) else { return true };
            let may = *left > 0;
            if may {
                *left -= 1;
            } else {
                answer.held.push(HeldCandidate {
                    candidate: start.candidate,
                    reason: HoldReason::NotYet(Tick::NEVER),
                    until: None,
                });
            }
            may
        });
        answer
    }
}

/// Five parts go through workcell C1, with lost and doubled messages: each is loaded, worked on and unloaded as often as
/// in its plan, and all leave.
#[test]
fn all_parts_that_enter_workcell_c1_leave_it_finished() {
    for seed in 0..5 {
        let made = made(C1, Supply::Open);
        let mut world = world(made, 4, seed);
        world.options.bad_luck = 30;
        world.options.replays = true;
        let mut dispatcher = LetIn { left: [("enter<A.new>", 3), ("enter<B.new>", 2)].into() };
        world.run(&mut dispatcher, Tick::from_millis(600_000));
        assert_eq!((world.state().left(), world.state().parts().len()), (5, 0), "seed {seed}");
        // Stations as they are named: m1, m2, m3, robot. Two loads and two unloads for each part; every machine clamps,
        // works and releases for each step.
        let done: Vec<usize> = world.stations.iter().map(|station| station.done.len()).collect();
        assert_eq!(done[3], 5 * 4, "seed {seed}");
        assert_eq!(done[0] + done[1] + done[2], 5 * 2 * 3, "seed {seed}");
        // M3 grinds all five; M1 can only turn A, M2 has the drilling of B at least.
        assert!(done[2] == 5 * 3 && done[0] <= 3 * 3 && done[1] >= 2 * 3, "seed {seed}: {done:?}");
    }
}

/// The robot is sent the slot: that of the part in the store, or a free one. No slot has two parts, and a part is fetched
/// from where it was put.
#[test]
fn each_part_has_a_slot_of_its_own_in_the_store() {
    for seed in 0..5 {
        let mut world = world(made(C1, Supply::Open), 4, seed);
        world.options.bad_luck = 30;
        world.options.replays = true;
        let mut dispatcher = LetIn { left: [("enter<A.new>", 4), ("enter<B.new>", 3)].into() };
        world.run(&mut dispatcher, Tick::from_millis(900_000));
        assert_eq!(world.state().left(), 7, "seed {seed}");
        let told = |done: &linewright_simulation::cell::BegunTask| match &done.parameters[..] {
            [(name, slot)] if &**name == "slot" => (done.task.starts_with("unload"), done.part.unwrap(), *slot),
            other => panic!("{other:?}"),
        };
        let robot: Vec<_> = world.stations[3].done.iter().map(told).collect();
        assert_eq!(robot.len(), 7 * 4);
        let mut last = BTreeMap::new();
        for &(stores, part, slot) in &robot {
            assert!((1..=6).contains(&slot), "{slot}");
            let put = last.insert(part, slot);
            // The robot is not sent where a part was put that came in by hand.
            assert!(stores || put.is_none_or(|put| put == slot), "{part} was put into {put:?} and fetched from {slot}");
        }
        let mut used: Vec<i32> = robot.iter().map(|&(.., slot)| slot).collect();
        used.sort_unstable();
        used.dedup();
        assert!(used.len() > 2, "several are in it at once");
        each_gets_the_lowest_free_slot(&world);
    }
}

/// In every state on the way, and in the same state read from a snapshot.
fn each_gets_the_lowest_free_slot(world: &World) {
    let slots = |state: &PlayerState| -> Vec<u32> {
        state.parts().flat_map(|part| [part.position, part.target]).flatten().collect()
    };
    let table = &world.it.table;
    let mut state = PlayerState::new(table.clone());
    for record in &world.log {
        let taken = slots(&state);
        let before: BTreeMap<_, _> = state.parts().map(|part| (part.id, part.target)).collect();
        let mut restored = PlayerState::restore(table.clone(), state.snapshot()).expect("its own snapshot");
        for of in [&mut state, &mut restored] {
            of.apply(record).expect("its own record");
            for part in of.parts().filter(|part| part.target.is_some() && before.get(&part.id) != Some(&part.target)) {
                let lowest = (1..).find(|slot| !taken.contains(slot));
                assert_eq!(part.target, lowest, "{taken:?}: {record:?}");
            }
        }
        assert_eq!(restored.snapshot(), state.snapshot(), "{record:?}");
    }
}

/// A slot that does not exist, or that has a part already, is none of a snapshot.
#[test]
fn a_snapshot_with_two_parts_in_a_slot_or_one_in_none_is_refused() {
    let mut world = world(made(C1, Supply::Open), 4, 1);
    let mut dispatcher = LetIn { left: [("enter<A.new>", 4), ("enter<B.new>", 3)].into() };
    world.run(&mut dispatcher, Tick::from_millis(900_000));
    let table = &world.it.table;
    let mut state = PlayerState::new(table.clone());
    let is_full = |state: &PlayerState| state.parts().filter(|part| part.position.is_some()).count() > 1;
    let until = world.log.iter().find(|record| {
        state.apply(record).expect("its own record");
        is_full(&state)
    });
    assert!(until.is_some(), "two parts are in the store");
    let text = serde_json::to_string(&state.snapshot()).expect("a text");
    let restored =
        |text: &str| PlayerState::restore(table.clone(), serde_json::from_str(text).expect("a snapshot")).is_ok();
    assert!(restored(&text) && text.contains("\"position\":2"), "{text}");
    for other in ["0", "1"] {
        assert!(!restored(&text.replace("\"position\":2", &format!("\"position\":{other}"))), "{other}");
    }
}

/// In a stack the position is the level: nothing is above the part that is fetched.
#[test]
fn in_a_lifo_buffer_orders_name_the_level() {
    let stack = C1.replacen("random-access-store", "lifo-buffer", 1);
    for seed in 0..5 {
        let mut world = world(made(&stack, Supply::Batch(&[2, 1])), 4, seed);
        world.run(&mut Fifo, Tick::from_millis(900_000));
        assert_eq!(world.state().left(), 3, "seed {seed}");
        let (mut lies, mut moves) = (BTreeMap::new(), BTreeMap::new());
        for done in &world.stations[3].done {
            let (part, level) = (done.part.expect("it has one"), done.parameters[0].1);
            let moved = moves.entry(part).and_modify(|moved| *moved += 1).or_insert(1);
            if done.task.starts_with("unload") {
                // After the second step it may leave at any time, and no robot takes part in that.
                lies.extend((*moved < 4).then_some((part, level)));
            } else if let Some(lay) = lies.remove(&part) {
                assert_eq!(lay, level, "seed {seed}: {part}");
            }
            assert!((1..=3).contains(&level) && lies.values().all(|&other| other <= level), "seed {seed}: {lies:?}");
        }
    }
}

/// The times and limits of a mode are those of its stage.
#[test]
fn modes_have_the_times_of_their_stages() {
    let made = made(C1, Supply::Open);
    let of = |name: &str| {
        let mode = made.table.modes().find(|&mode| made.table.mode_name(mode) == name);
        made.table.activity(mode.unwrap_or_else(|| panic!("no mode {name}")))
    };
    let second = Duration::from_secs;
    let work = of("M2.process<A.new>");
    assert_eq!(work.kind, ActivityTiming::Decided { time: second(55), limit: None });
    assert_eq!((work.orders.len(), work.orders[0].limit), (1, second(110)));
    assert_eq!(work.orders[0].parameters, [("program".into(), TaskParameterValue::Number(1))]);
    assert_eq!(of("M2.process<B.grind>").orders[0].parameters, [("program".into(), TaskParameterValue::Number(4))]);
    let load = of("load M3<B.new>");
    assert_eq!(load.orders.iter().map(|order| order.limit).collect::<Vec<_>>(), [second(24), second(26)]);
    assert_eq!(of("enter<A.new>").kind, ActivityTiming::Decided { time: Duration::ZERO, limit: None });
    assert!(made.table.modes().all(|mode| made.table.activity(mode).servers == 1));
}

#[test]
fn what_cannot_be_played_says_why() {
    let text = C1.replace("reserve = true", "reserve = false");
    let cell = linewright_cell::parse("cell.toml", &text, None).expect("it can be described").cell;
    let refused = compile_cell(&cell, None, Supply::Open, PACE);
    assert!(matches!(refused, Err(Unplayable::Unreserved)));
    let line = linewright_testkit::built::transfer_line();
    let cell = linewright_cell::parse("cell.toml", C1, None).expect("it is sound").cell;
    let refused = compile_cell(&cell, Some(&line), Supply::Open, PACE).map(|_| ()).unwrap_err();
    assert_eq!(refused.to_string(), "the line has no station `m1`");
}
