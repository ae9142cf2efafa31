//! No part is lost and none is made twice, counted by a ledger that uses the net and the records alone.

use std::collections::BTreeMap;

use linewright_coordinator_cell::{
    ActivityFailure, ActivityPhase, ActivityStep, CellKind, Fifo, FiringId, ModeId, OngoingActivity, PartId, PartPlace,
    Record,
};
use linewright_line::Tick;

use super::plans::Compiled;
use super::printed::{Variant, compiled, kind};
use super::workcell::{self, Workcell};
use super::world::{World, options};
use linewright_random::Random as Dice;

/// Place of a part by the ledger.
#[derive(Clone, Debug, PartialEq)]
enum Is {
    On(String),
    In(FiringId),
    Gone,
}

/// Follows parts by names of places, from the coloured net.
struct Ledger<'a> {
    it: &'a Compiled,
    is_part: &'a dyn Fn(&str) -> bool,
    parts: BTreeMap<PartId, Is>,
    firings: BTreeMap<FiringId, (ModeId, Option<PartId>)>,
    made: usize,
    left: usize,
}

impl<'a> Ledger<'a> {
    fn new(it: &'a Compiled, is_part: &'a dyn Fn(&str) -> bool) -> Self {
        let mut new = Ledger { it, is_part, parts: BTreeMap::new(), firings: BTreeMap::new(), made: 0, left: 0 };
        let start = it.net.initial_marking();
        for &(cell, count) in start.entries() {
            let name = it.net.cell_name(cell);
            for _ in 0..if is_part(&name) { count } else { 0 } {
                new.made += 1;
                new.parts.insert(PartId(new.made as u64), Is::On(name.clone()));
            }
        }
        new
    }

    /// Place that a mode takes its part from, or puts it.
    fn place(&self, mode: ModeId, side: usize) -> Option<String> {
        let mode = self.it.net.mode_named(self.it.table.mode_name(mode)).unwrap();
        let moved = self.it.net.places().flat_map(|place| {
            let moves = self.it.net.moves(mode, place);
            moves[side].iter().map(|(tones, _)| self.it.net.cell_of(place, tones).unwrap()).collect::<Vec<_>>()
        });
        moved.map(|cell| self.it.net.cell_name(cell)).find(|name| (self.is_part)(name))
    }

    fn take(&mut self, mode: ModeId, part: Option<PartId>, to: Is) {
        match (self.place(mode, 0), part) {
            (None, None) => (),
            (None, Some(part)) => {
                self.made += 1;
                assert_eq!(self.parts.insert(part, to), None, "{part} is made twice");
            }
            (Some(from), Some(part)) => assert_eq!(self.parts.insert(part, to), Some(Is::On(from)), "{part}"),
            (Some(from), None) => panic!("nothing is taken from {from}"),
        }
    }

    fn give(&mut self, mode: ModeId, part: Option<PartId>) {
        match (self.place(mode, 1), part) {
            (None, None) => (),
            (Some(to), Some(part)) => _ = self.parts.insert(part, Is::On(to)),
            (None, Some(part)) => {
                self.left += 1;
                self.parts.insert(part, Is::Gone);
            }
            (Some(to), None) => panic!("nothing is put on {to}"),
        }
    }

    fn enter(&mut self, record: &Record) {
        match record.fact.activity_step() {
            Some(ActivityStep::Started { firing, mode, part, orders: _ }) => {
                self.take(mode, part, Is::In(firing));
                assert_eq!(self.firings.insert(firing, (mode, part)), None, "{firing} starts twice");
            }
            Some(ActivityStep::Ended { firing }) => {
                let (mode, part) = self.firings.remove(&firing).expect("what ends has started");
                self.give(mode, part);
            }
            Some(ActivityStep::Fired { mode, part }) => {
                self.take(mode, part, Is::Gone);
                self.give(mode, part);
            }
            Some(ActivityStep::Raised { .. } | ActivityStep::Closed { .. }) | None => (),
        }
    }
}

/// Plays a world to its end, and compares the ledger with the state after each record.
fn audited(world: &mut World, is_part: &dyn Fn(&str) -> bool) -> (usize, usize) {
    world.run(&mut Fifo, Tick::from_millis(3_600_000));
    let mut ledger = Ledger::new(&world.it, is_part);
    let mut state = linewright_coordinator_cell::PlayerState::new(world.it.table.clone());
    for record in &world.log {
        ledger.enter(record);
        state.apply(record).unwrap();
        let inside = ledger.parts.iter().filter(|(_, is)| **is != Is::Gone);
        let theirs = state.parts().map(|part| {
            let is = match part.place {
                PartPlace::On { cell, .. } => Is::On(world.it.table.cell_name(cell).to_owned()),
                PartPlace::In(firing) => Is::In(firing),
            };
            (part.id, is)
        });
        assert!(inside.map(|(&id, is)| (id, is.clone())).eq(theirs));
        // Every cell of parts has exactly the parts that the ledger has there.
        for cell in world.it.table.cells() {
            let name = world.it.table.cell_name(cell);
            let here = ledger.parts.iter().filter(|(_, is)| matches!(is, Is::On(on) if on == name)).count() as u64;
            match world.it.table.kind(cell) {
                CellKind::Parts(_) => {
                    assert_eq!((state.marking().count(cell), here), (here, state.marking().parts(cell).len() as u64))
                }
                CellKind::Tokens => assert_eq!((here, state.marking().parts(cell).len()), (0, 0)),
            }
        }
        assert_eq!(state.left(), ledger.left as u64);
        assert_eq!(ledger.made, state.parts().len() + ledger.left);
    }
    (ledger.made, ledger.left)
}

#[test]
fn no_part_of_the_printed_cell_is_lost_or_doubled() {
    for (seed, waiting) in (0..).zip([[1, 1, 1], [3, 0, 2], [0, 4, 4]]) {
        let it = compiled(&Variant { waiting, ..Variant::default() });
        let mut world = World::with(it, 3, options(seed, 8, vec![40, 90]));
        let made = audited(&mut world, &|name| kind(name) != CellKind::Tokens);
        assert_eq!(made, (waiting.iter().sum::<u32>() as usize, 0));
    }
}

#[test]
fn no_part_of_a_workcell_is_lost_or_doubled() {
    for seed in 0..12 {
        let cell = Workcell::random(&mut Dice::new(seed));
        let (stations, parts) = (cell.stations(), cell.parts() as usize);
        let options = options(seed, 8, vec![30, 31, 100]);
        let mut world = World::with(workcell::compiled(&cell), stations, options);
        let is_part = |name: &str| ["stored", "loaded", "ready"].iter().any(|place| name.starts_with(place));
        assert_eq!(audited(&mut world, &is_part), (parts, parts), "all parts have come, and all have left");
    }
}

/// Stations fail, and whatever fails keeps its part; what is left of the cell goes on. How many parts were kept so.
#[test]
fn no_part_is_lost_where_stations_fail() {
    let mut kept = 0;
    for seed in 0..20 {
        let cell = Workcell::random(&mut Dice::new(seed));
        let mut world = World::with(workcell::compiled(&cell), cell.stations(), options(seed, 0, vec![50]));
        world.stations.iter_mut().for_each(|station| station.failing = 8);
        let is_part = |name: &str| ["stored", "loaded", "ready"].iter().any(|place| name.starts_with(place));
        let (made, left) = audited(&mut world, &is_part);
        let failed = |firing: &OngoingActivity| {
            matches!(firing.phase, ActivityPhase::Failed(ActivityFailure::Order { .. })) && firing.part.is_some()
        };
        assert!(world.state().firings().all(failed));
        assert_eq!(made - left, world.state().parts().len());
        kept += world.state().firings().len();
    }
    assert!(kept > 10, "{kept}");
}

/// With each part every step of its plan is done once: loaded, processed, unloaded.
#[test]
fn every_step_of_every_plan_is_done_once() {
    for seed in 0..12 {
        let cell = Workcell::random(&mut Dice::new(seed));
        let mut world = World::new(workcell::compiled(&cell), cell.stations(), seed);
        world.run(&mut Fifo, Tick::from_millis(3_600_000));
        let (_, left, histories) = workcell::production(&world);
        assert_eq!((left, histories.len()), (u64::from(cell.parts()), cell.parts() as usize));
        let mut steps = 0;
        for history in histories {
            // Loading and unloading are two orders each: to a robot, and to a machine.
            for step in history.chunks(5) {
                assert_eq!(step, ["load", "load", "process", "unload", "unload"]);
                steps += 1;
            }
        }
        assert_eq!(steps, cell.steps());
    }
}
