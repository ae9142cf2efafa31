//! Records are complete: a replayed state is the state; a record that does not fit changes nothing.

use linewright_coordinator_cell::{
    ActivityFailure, Coordination, Fifo, FiringId, ModeId, OrderFailure, OrderKey, PartId, PlayerOutbox, PlayerState,
    Record, RecordKind,
};
use linewright_line::Tick;
use linewright_simulation::cell::CellSimOptions;

use super::crash::merged;
use super::printed::{Variant, compiled};
use super::workcell::{self, Workcell};
use super::world::{World, options};
use linewright_random::Random as Dice;

const LONG: Tick = Tick::from_millis(3_600_000);

/// After every step the records replayed are the state, through crashes and lost messages.
#[test]
fn replaying_the_records_gives_the_state_at_every_step() {
    let options = |seed| CellSimOptions { replays: true, ..options(seed, 7, vec![25, 60]) };
    let variant = Variant { waiting: [2, 2, 2], ..Variant::default() };
    let printed = |seed| World::with(compiled(&variant), 3, options(seed));
    let random = |seed| {
        let cell = Workcell::random(&mut Dice::new(seed));
        let stations = cell.stations();
        World::with(workcell::compiled(&cell), stations, options(seed))
    };
    for seed in 0..4 {
        for mut world in [printed(seed), random(seed + 100)] {
            world.run(&mut Fifo, LONG);
            assert!(world.lives > 1 && world.log.len() > 50, "{} {}", world.lives, world.log.len());
        }
    }
}

/// The state after each record of a run, applied one by one, is what replaying so many of them gives.
#[test]
fn every_prefix_of_the_records_replays_to_the_state_it_had() {
    let mut world = World::new(compiled(&Variant { waiting: [2, 2, 2], ..Variant::default() }), 3, 5);
    world.run(&mut Fifo, LONG);
    let mut state = PlayerState::new(world.it.table.clone());
    for (count, record) in world.log.iter().enumerate() {
        assert_eq!(PlayerState::replay(world.it.table.clone(), &world.log[..count]).unwrap(), state);
        state.apply(record).unwrap();
        assert_eq!((state.sequence(), state.now()), (count as u64 + 1, record.at));
    }
    assert_eq!(&state, world.state());
    assert!(world.log.len() > 100, "{}", world.log.len());
}

/// A random record; about half of the numbers exist.
fn any_fact(dice: &mut Dice, state: &PlayerState) -> RecordKind {
    let firings: Vec<_> = state.firings().collect();
    let orders: Vec<_> = firings.iter().flat_map(|firing| &firing.orders).map(|order| order.key).collect();
    let firing =
        if firings.is_empty() || dice.one_in(2) { FiringId(dice.below(12) as u64) } else { dice.pick(&firings).id };
    let key = if orders.is_empty() || dice.one_in(2) {
        OrderKey { epoch: dice.below(3) as u64, id: dice.below(12) as u64 }
    } else {
        *dice.pick(&orders)
    };
    let mode = ModeId(dice.below(state.table().mode_count() + 1) as u32);
    let part = if dice.one_in(3) { None } else { Some(PartId(dice.below(8) as u64)) };
    match dice.below(9) {
        0 => RecordKind::Epoch { epoch: dice.below(4) as u64 },
        1 => RecordKind::Decided { question: dice.below(4) as u64, started: vec![], held: vec![] },
        2 => RecordKind::Started { firing, mode, part, orders: vec![key; dice.below(3)] },
        3 => RecordKind::Acknowledged { key },
        4 => RecordKind::OrderEnded { key },
        5 => RecordKind::OrderFailed { key, failure: OrderFailure::TimedOut },
        6 => RecordKind::Raised { firing, cause: ActivityFailure::TimedOut },
        7 => RecordKind::Ended { firing },
        _ => RecordKind::Fired { mode, part },
    }
}

/// Foreign records never panic; those that do not fit leave the state as it was.
#[test]
fn records_that_do_not_fit_are_refused_and_change_nothing() {
    let mut dice = Dice::new(8);
    let (mut fitted, mut refused) = (0, 0);
    for seed in 0..60 {
        let mut world = World::new(merged([2, 2, 1]), 3, seed);
        world.run(&mut Fifo, Tick::from_millis(300 * seed));
        let mut state = world.state().clone();
        for _ in 0..300 {
            let record = Record { at: state.now(), fact: any_fact(&mut dice, &state) };
            let before = state.clone();
            match state.apply(&record) {
                Ok(()) => fitted += 1,
                Err(misfit) => {
                    assert_eq!((misfit.sequence, &state), (before.sequence() + 1, &before), "{record:?}");
                    refused += 1;
                }
            }
        }
    }
    assert!(fitted > 300 && refused > 10_000, "{fitted} {refused}");
    let mut state = PlayerState::new(merged([1, 0, 0]).table);
    state.apply(&Record { at: Tick::from_millis(5), fact: RecordKind::Epoch { epoch: 1 } }).unwrap();
    let early = state.apply(&Record { at: Tick::from_millis(4), fact: RecordKind::Epoch { epoch: 2 } }).unwrap_err();
    assert_eq!(early.to_string(), "record 2 does not fit: it is of 0.004000 s, after one of 0.005000 s");
}

#[test]
fn a_life_has_an_epoch_above_all_before() {
    let mut out = PlayerOutbox::default();
    let begin = |state, epoch, out: &mut PlayerOutbox| Coordination::begin(state, Tick::ZERO, epoch, out);
    let first = begin(PlayerState::new(merged([1, 0, 0]).table), 4, &mut out).unwrap();
    let refused = begin(first.state().clone(), 4, &mut out).unwrap_err();
    assert_eq!(refused.to_string(), "epoch 4 is not newer than epoch 4 of the log");
    assert!(begin(first.state().clone(), 5, &mut out).is_ok());
}
