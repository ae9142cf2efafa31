//! Both shipped cells are killed at every record and every message, and go on from the bytes of their logs.
//!
//! *The same production* means: as many parts have left, each has had exactly the work of its plan, in its order, and no
//! station has done an order twice; by the stations' own ledgers, which the coordinator never sees. Not at the same times:
//! without a coordinator, what runs goes on.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use linewright_coordinator_cell::compile::{self, dispatcher, schedule_follower};
use linewright_coordinator_cell::production::{DispatchConfiguration, ProductionOrderRequest};
use linewright_coordinator_cell::{
    ActivityFailure, ActivityPhase, CellTable, Dispatcher, OrderFailure, PlayerState, ProductionId, Record,
};
use linewright_coordinator_node::cell::CellLog;
use linewright_line::Tick;
use linewright_simulation::Rng;
use linewright_simulation::cell::{CellSim, CellSimOptions, RecordStore, StationSpeed};

use super::shipped::{self, Shipped, directory, production, shipped};

const LONG: Tick = Tick::from_millis(24 * 3_600_000);

/// End of a coordinator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Death {
    /// Its process is killed: what was written is there.
    Killed,
    /// The power goes: what was synced is there, and of what was written behind that any number of bytes.
    PowerCut,
}

/// A log on disk.
pub struct OnDisk {
    path: PathBuf,
    /// None while it is not open.
    log: Option<CellLog>,
    death: Death,
    /// As much of the file is there whatever happens.
    synced: (PathBuf, u64),
    /// A snapshot takes the place of so many records.
    snapshot_after: u64,
    since: u64,
}

impl OnDisk {
    pub fn new(dir: &Path, table: &Arc<CellTable>, death: Death, snapshot_after: u64) -> Self {
        let path = dir.join("cell.log");
        let log = CellLog::open(&path, "cell", table).expect("opens").log;
        OnDisk { path, synced: log.file(), log: Some(log), death, snapshot_after, since: 0 }
    }

    /// Whether a snapshot is due.
    pub fn is_long(&self) -> bool {
        self.since >= self.snapshot_after
    }

    fn log(&mut self) -> &mut CellLog {
        self.log.as_mut().expect("it is open")
    }
}

impl RecordStore for OnDisk {
    fn append(&mut self, record: &Record) {
        self.log().append(std::slice::from_ref(record)).expect("appends");
        self.since += 1;
    }

    fn sync(&mut self) {
        // A file that is not cut off has all that was written.
        if self.death == Death::PowerCut {
            self.log().sync().expect("syncs");
            self.synced = self.log().file();
        }
    }

    fn restart(&mut self, table: &Arc<CellTable>, rng: &mut Rng) -> PlayerState {
        let (file, written) = self.log().file();
        self.log = None;
        let (name, synced) = &self.synced;
        if self.death == Death::PowerCut && *name == file {
            let kept = rng.within(*synced, written);
            std::fs::File::options().write(true).open(&file).and_then(|file| file.set_len(kept)).expect("is cut off");
        }
        let found = CellLog::open(&self.path, "cell", table).expect("opens");
        self.synced = found.log.file();
        self.log = Some(found.log);
        found.state
    }

    fn settled(&mut self, state: &PlayerState) {
        if self.is_long() {
            self.log().begin_anew(state).expect("begins anew");
            self.synced = self.log().file();
            self.since = 0;
        }
    }
}

pub fn options(seed: u64, bad_luck: u64, crash_at: Vec<usize>) -> CellSimOptions {
    let millis = Duration::from_millis;
    CellSimOptions {
        seed,
        bad_luck,
        crash_at,
        pace: StationSpeed::Nominal { spread: 0.2 },
        delay: (millis(1), millis(20)),
        period: millis(100),
        replays: false,
    }
}

/// Plays a production to its end.
fn play(of: &Shipped, death: Death, options: CellSimOptions, snapshot_after: u64) -> CellSim {
    let dir = directory();
    let store = OnDisk::new(dir.path(), &of.table, death, snapshot_after);
    let mut sim = CellSim::with_store(of.table.clone(), of.stations, options, Box::new(store));
    sim.run(&mut dispatcher(&of.cell, &of.table), LONG);
    assert_eq!((&sim.events[..], sim.state().firings().next()), (&[][..], None));
    assert_eq!((sim.state().left(), sim.state().parts().len()), (u64::from(of.parts), 0));
    sim
}

/// Kills the coordinator of a production at each of its steps; how many there are.
fn killed_at_every_step(of: &Shipped, told_apart: bool, bad_luck: u64, death: Death, snapshot_after: u64) -> usize {
    let calm = play(of, death, options(3, bad_luck, Vec::new()), snapshot_after);
    let expected = production(&calm, told_apart);
    assert_eq!((calm.lives, expected.len()), (1, of.parts as usize));
    for at in 0..calm.steps {
        let sim = play(of, death, options(3, bad_luck, vec![at]), snapshot_after);
        assert_eq!(sim.lives, 2, "at {at}");
        assert_eq!(production(&sim, told_apart), expected, "at {at}");
    }
    calm.steps
}

#[test]
fn the_assembly_cell_produces_the_same_whichever_step_it_is_killed_at() {
    let of = shipped("assembly-cell", &[2, 2, 1]);
    for (death, bad_luck, snapshot_after) in
        [(Death::Killed, 0, 1_000_000), (Death::PowerCut, 0, 11), (Death::PowerCut, 8, 1_000_000)]
    {
        let steps = killed_at_every_step(&of, true, bad_luck, death, snapshot_after);
        // Five activities with each part start and end; 5 orders with a part 1, 3 with any other, are sent, taken on and done.
        assert!(steps >= 5 * 5 * 2 + (2 * 5 + 3 * 3) * 3, "{steps}");
    }
}

/// Two parts of each kind; three of each are in the next test, at steps by chance.
#[test]
fn workcell_c1_produces_the_same_whichever_step_it_is_killed_at() {
    let of = shipped("workcell-c1", &[2, 2]);
    for (death, bad_luck, snapshot_after) in [(Death::Killed, 0, 13), (Death::PowerCut, 8, 1_000_000)] {
        let steps = killed_at_every_step(&of, false, bad_luck, death, snapshot_after);
        assert!(steps >= 4 * 8 * 2 + 4 * 10 * 3, "{steps}");
    }
    // By the plans: A is turned and ground, B ground and drilled, each in its order.
    let sim = play(&of, Death::Killed, options(5, 0, Vec::new()), 100);
    let work = |programs: [u8; 2]| programs.map(|program| format!("machine program {program}"));
    let done = production(&sim, false);
    for (part, programs) in done.iter().zip([[1, 2], [1, 2], [3, 4], [3, 4]]) {
        let machined: Vec<&String> = part.iter().filter(|act| act.starts_with("machine")).collect();
        assert!(machined.iter().copied().eq(&work(programs)), "{part:?}");
        assert_eq!(part.len(), 2 * 5, "each is loaded and clamped, machined, unloaded and released: {part:?}");
    }
}

/// Killed ten times, at any steps, with lost and doubled messages.
#[test]
fn both_cells_survive_being_killed_again_and_again() {
    let mut rng = Rng::new(8);
    for (name, parts, told_apart) in [("assembly-cell", &[2, 2, 1][..], true), ("workcell-c1", &[3, 3], false)] {
        let of = shipped(name, parts);
        let expected = production(&play(&of, Death::Killed, options(0, 0, Vec::new()), 1_000_000), told_apart);
        for seed in 0..20 {
            let death = if seed % 2 == 0 { Death::Killed } else { Death::PowerCut };
            let mut at = 0;
            let crash_at = (0..10).map(|_| {
                at += 1 + rng.below(40) as usize;
                at
            });
            let options = options(seed, 6, crash_at.collect());
            let sim = play(&of, death, options, 20);
            assert!(sim.lives > 4, "{}", sim.lives);
            assert_eq!(production(&sim, told_apart), expected, "{name}, seed {seed}");
        }
    }
}

fn ordered(orders: &[(&str, u32)]) -> Vec<ProductionOrderRequest> {
    let request = |(key, &(product, quantity)): (u128, &(&str, u32))| ProductionOrderRequest {
        key,
        name: format!("order {key}"),
        product: product.to_owned(),
        quantity,
        ..ProductionOrderRequest::default()
    };
    (1..).zip(orders).map(request).collect()
}

/// Production orders are made to their end, each part once, whichever step the coordinator is killed at: the request is
/// repeated until there is a reply, and the dispatcher begins from the log.
#[test]
fn production_orders_are_made_once_whichever_step_the_coordinator_is_killed_at() {
    let of = shipped::with_production_orders("assembly-cell", 5);
    let requests = ordered(&[("1", 2), ("2", 1), ("3", 1), ("2", 1)]);
    let ids: Vec<_> = (1..=4).map(ProductionId).collect();
    let made = |crash_at: Vec<usize>, planned: bool, snapshot_after: u64| {
        let dir = directory();
        let store = OnDisk::new(dir.path(), &of.table, Death::PowerCut, snapshot_after);
        let mut sim = CellSim::with_store(of.table.clone(), of.stations, options(3, 9, crash_at), Box::new(store));
        sim.asked = vec![requests.clone()];
        let by_rules = |state: &PlayerState| -> Box<dyn Dispatcher> {
            Box::new(DispatchConfiguration::new(dispatcher(&of.cell, &of.table), state.production().clone()))
        };
        let by_plan =
            |state: &PlayerState| -> Box<dyn Dispatcher> { Box::new(schedule_follower(&of.cell, &of.made, state)) };
        sim.run_by(if planned { &by_plan } else { &by_rules }, LONG);
        assert_eq!(sim.told, [Ok(ids.clone())], "it is told once, even if it was asked twice");
        assert_eq!((sim.state().left(), sim.state().parts().len(), sim.state().firings().len()), (5, 0, 0));
        let orders = sim.state().production().orders();
        assert_eq!(orders.filter(|order| order.ended.is_some() && order.surplus + order.lost == 0).count(), 4);
        sim
    };
    let calm = made(Vec::new(), false, 1_000_000);
    let expected = production(&calm, true);
    for at in 0..calm.steps {
        let sim = made(vec![at], false, if at % 2 == 0 { 7 } else { 1_000_000 });
        assert_eq!((sim.lives, production(&sim, true)), (2, expected.clone()), "killed at {at}");
    }
    let sim = made((0..calm.steps).step_by(20).collect(), true, 30);
    assert_eq!(production(&sim, true), expected);
    assert!(sim.lives > 4, "{}", sim.lives);
}

/// Where messages are slow and are seldom repeated, an order can reach its station so late that its limit runs out. Then its
/// activity has failed, even if the station does end it; nothing else ever stays unfinished.
#[test]
fn where_messages_are_slow_only_limits_leave_something_unfinished() {
    let mut rng = Rng::new(8);
    let pace = compile::OrderTiming { repeat_interval: Duration::from_millis(500), ..shipped::PACE };
    let mut late = 0;
    for (name, parts) in [("assembly-cell", &[2, 2, 1][..]), ("workcell-c1", &[3, 3])] {
        let of = shipped::paced(name, parts, pace);
        for seed in 0..60 {
            let mut at = 0;
            let crash_at = (0..10).map(|_| {
                at += 1 + rng.below(40) as usize;
                at
            });
            let slow = (Duration::from_millis(1), Duration::from_millis(50));
            let options = CellSimOptions { delay: slow, ..options(seed, 6, crash_at.collect()) };
            let dir = directory();
            let store = OnDisk::new(dir.path(), &of.table, Death::Killed, 20);
            let mut sim = CellSim::with_store(of.table.clone(), of.stations, options, Box::new(store));
            sim.run(&mut dispatcher(&of.cell, &of.table), LONG);
            production(&sim, true);
            for firing in sim.state().firings() {
                let ran_out = |cause| matches!(cause, ActivityFailure::Order { failure: OrderFailure::TimedOut, .. });
                assert!(
                    matches!(firing.phase, ActivityPhase::Failed(cause) if ran_out(cause)),
                    "{name}, seed {seed}: {firing:?}"
                );
                late += 1;
            }
        }
    }
    assert!(late > 0, "it happens");
}
