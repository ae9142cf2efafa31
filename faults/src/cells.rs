//! Flexible cells under faults: the real token player and dispatcher, with pretended stations, from a seed.
//!
//! The coordinator is killed between any two of its records and messages, or its host loses power and with it whatever was
//! written since the last synchronisation; messages get lost, come twice, late and in another order; stations fall silent,
//! stand, fail, or lose their memory. An operator looks at what is there and answers the alarms.
//!
//! At the end: every production order is made, each part once, by the stations' own ledgers; no order of a task was done twice;
//! what was answered to a request is so.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use linewright_cell::Cell;
use linewright_cell::net::Supply;
use linewright_coordinator_cell::compile::{OrderTiming, compile_cell, dispatcher};
use linewright_coordinator_cell::exception::AlarmSubject;
use linewright_coordinator_cell::production::{DispatchConfiguration, ProductionOrderRequest};
use linewright_coordinator_cell::{
    AlarmId, CellTable, Dispatcher, OrderKey, PartId, PlayerInput, PlayerState, ProductionId, ProtocolRules, Record,
};
use linewright_line::Tick;
use linewright_simulation::Rng;
use linewright_simulation::cell::{CellSim, CellSimOptions, RecordStore, SimulatedOperator, StationSpeed};

const C1: &str = include_str!("../../launch-config/lines/workcell-c1/cell.toml");
const ASSEMBLY: &str = include_str!("../../launch-config/lines/assembly-cell/cell.toml");
const PACE: OrderTiming = OrderTiming { repeat_interval: Duration::from_millis(200), grace: Duration::from_secs(1) };
/// The operator looks so often.
const LOOKS: Duration = Duration::from_millis(250);
/// An impatient operator answers an alarm so often before a station is led to a rest.
const AT_ONCE: u32 = 12;
/// A production takes a tenth of that without faults.
const LONG: Tick = Tick::from_millis(3_600_000);
/// Steps of the coordinator within which it is killed: about those of a production.
const STEPS: u64 = 160;

/// A broken rule of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellMutant {
    /// A synchronised record is not on the disk.
    SyncedRecordsLost,
    /// Nothing is synchronised before it is sent or answered.
    NotSynchronised,
    /// The memory id in station reports is ignored: a station that lost its order store counts as one that has kept it.
    ForgottenUnseen,
    /// An alarm is raised, and answered, before the stations stand.
    AlarmAnsweredEarly,
    /// A request that is repeated is another one.
    RepeatedRequestIsNew,
}

/// Broken rules of cells, with the first seed that finds each.
pub const CELL_MUTANTS: &[(CellMutant, u64)] = &[
    (CellMutant::SyncedRecordsLost, 0),
    (CellMutant::NotSynchronised, 0),
    (CellMutant::ForgottenUnseen, 744),
    (CellMutant::AlarmAnsweredEarly, 336),
    (CellMutant::RepeatedRequestIsNew, 0),
];

/// A fault of a station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StationTrouble {
    /// Nothing reaches it, nothing comes from it.
    Away,
    /// Its order does not end.
    Stuck,
    /// Its order fails.
    Fails,
    /// It stands, and goes on.
    Stands,
    /// It has lost its memory.
    Forgets,
}

/// What happens in a run.
#[derive(Clone, Debug)]
struct CellPlan {
    is_assembly: bool,
    options: CellSimOptions,
    /// When, which station, for how long.
    troubles: Vec<(Tick, usize, Duration, StationTrouble)>,
    /// Alarms are answered as soon as they are raised, by what is there then; people lead stations to a rest only later.
    is_impatient: bool,
    /// When the requests are sent once more, as by a requester whose answer was lost.
    asks_again: Option<Tick>,
}

impl CellPlan {
    fn of(seed: u64) -> Self {
        let mut rng = Rng::named(seed, "cell plan");
        let millis = Duration::from_millis;
        let mut at = 0;
        let crashes = rng.within(1, 8);
        let crash_at = (0..crashes).map(|_| {
            at += 1 + rng.below(2 * STEPS / crashes) as usize;
            at
        });
        let crash_at = crash_at.collect();
        let options = CellSimOptions {
            seed,
            pace: StationSpeed::Nominal { spread: 0.2 },
            delay: (millis(1), millis(20)),
            bad_luck: *rng.pick(&[0, 4, 8, 20]),
            period: millis(100),
            crash_at,
            replays: false,
        };
        let count = if rng.chance(500) { rng.within(1, 4) } else { 0 };
        let troubles = (0..count).map(|_| {
            let kinds = [
                StationTrouble::Away,
                StationTrouble::Stuck,
                StationTrouble::Fails,
                StationTrouble::Stands,
                StationTrouble::Forgets,
            ];
            let time = Tick::from_micros(rng.within(1_000_000, 60_000_000));
            let lasts = Duration::from_micros(rng.within(100_000, 12_000_000));
            (time, rng.below(16) as usize, lasts, *rng.pick(&kinds))
        });
        let troubles = troubles.collect();
        let asks_again = rng.chance(300).then(|| Tick::from_micros(rng.within(100_000, 30_000_000)));
        let is_impatient = rng.chance(400);
        CellPlan { is_assembly: seed.is_multiple_of(2), options, troubles, is_impatient, asks_again }
    }

    fn is_calm(&self) -> bool {
        self.troubles.is_empty()
    }
}

/// A cell with its production.
struct CellWork {
    cell: Cell,
    table: Arc<CellTable>,
    requests: Vec<ProductionOrderRequest>,
    parts: u64,
}

impl CellWork {
    fn of(is_assembly: bool) -> Option<Self> {
        let (text, supply, parts) =
            if is_assembly { (ASSEMBLY, Supply::Open, 5) } else { (C1, Supply::Batch(&[2, 2]), 4) };
        let cell = linewright_cell::parse("cell.toml", text, None).ok()?.cell;
        let table = compile_cell(&cell, None, supply, PACE).ok()?.table;
        let mut handling = table.handling().clone();
        (handling.lost_after, handling.secure) = (Some(Duration::from_secs(3)), Duration::from_secs(10));
        let table = Arc::new(table.with_handling(handling));
        let request = |(key, (product, quantity)): (u128, (&str, u32))| ProductionOrderRequest {
            key,
            name: format!("order {key}"),
            product: product.to_owned(),
            quantity,
            ..ProductionOrderRequest::default()
        };
        let orders = [("1", 2), ("2", 1), ("3", 1), ("2", 1)];
        let requests = if is_assembly { (1..).zip(orders).map(request).collect() } else { Vec::new() };
        Some(CellWork { cell, table, requests, parts })
    }
}

/// The log of a cell, on a disk that keeps for certain what was synchronised.
struct CutLog {
    records: Vec<Record>,
    synced: usize,
    mutant: Option<CellMutant>,
}

impl RecordStore for CutLog {
    fn append(&mut self, record: &Record) {
        self.records.push(record.clone());
    }

    fn sync(&mut self) {
        if self.mutant != Some(CellMutant::NotSynchronised) {
            self.synced = self.records.len();
        }
    }

    fn restart(&mut self, table: &Arc<CellTable>, rng: &mut Rng) -> PlayerState {
        // The process is killed, or its host loses power with what was not synchronised.
        if rng.chance(600) {
            let certain = match self.mutant {
                Some(CellMutant::SyncedRecordsLost) => self.synced.saturating_sub(6),
                _ => self.synced,
            };
            let kept = rng.within(certain as u64, self.records.len() as u64) as usize;
            self.records.truncate(kept);
        }
        self.synced = self.records.len();
        PlayerState::replay(table.clone(), &self.records).unwrap_or_else(|_| PlayerState::new(table.clone()))
    }
}

/// What has become of a seed of a cell.
#[derive(Clone, Debug)]
pub struct PlayedCell {
    pub finding: Option<String>,
    /// Steps of the coordinator, over all its lives.
    pub steps: usize,
    pub lives: usize,
    pub end: Tick,
}

/// Plays a seed of a cell.
pub fn play_cell(seed: u64, mutant: Option<CellMutant>) -> PlayedCell {
    let plan = CellPlan::of(seed);
    let (mut sim, told) = run(&plan, mutant);
    let finding = judge(&plan, &mut sim, told);
    PlayedCell { finding, steps: sim.steps, lives: sim.lives, end: sim.now }
}

/// Runs to the end of the production, or until time is up. Gives the answers to the first request as they were given.
fn run(plan: &CellPlan, mutant: Option<CellMutant>) -> (CellSim, Vec<Vec<ProductionId>>) {
    let work = CellWork::of(plan.is_assembly).unwrap_or_else(|| unreachable!("the shipped cells are sound"));
    let stations = work.cell.controllers.len();
    let store = CutLog { records: Vec::new(), synced: 0, mutant };
    let mut sim = CellSim::with_store(work.table.clone(), stations, plan.options.clone(), Box::new(store));
    sim.senses = !plan.is_calm();
    if !work.requests.is_empty() {
        sim.asked = vec![work.requests.clone()];
    }
    let made = |state: &PlayerState| -> Box<dyn Dispatcher> {
        let by_rules = dispatcher(&work.cell, &work.table);
        match work.requests.is_empty() {
            true => Box::new(by_rules),
            false => Box::new(DispatchConfiguration::new(by_rules, state.production().clone())),
        }
    };
    let mut operator = SimulatedOperator::default();
    let mut answered = BTreeMap::new();
    let mut asks_again = plan.asks_again.filter(|_| !work.requests.is_empty());
    let mut begun = vec![false; plan.troubles.len()];
    let mut ended = begun.clone();
    let is_done = |sim: &CellSim| {
        let orders = sim.state().production().orders();
        let all_over = orders.len() >= work.requests.len() && orders.into_iter().all(|order| order.ended.is_some());
        let gone = sim.state().left() + sim.state().exceptions().scrapped();
        let made = if work.requests.is_empty() { gone >= work.parts } else { all_over };
        made && sim.state().parts().len() == 0 && sim.asked.is_empty() && sim.state().firings().len() == 0
    };
    while sim.now < LONG && !(is_done(&sim) && asks_again.is_none()) {
        break_rules(&mut sim, mutant);
        let now = sim.now;
        for (at, &(time, station, lasts, trouble)) in plan.troubles.iter().enumerate() {
            let station = station % stations;
            if !begun[at] && time <= now {
                begun[at] = true;
                begin(&mut sim, station, trouble, mutant);
            } else if begun[at] && !ended[at] && time + lasts <= now {
                ended[at] = true;
                end(&mut sim, station, trouble);
            }
        }
        if asks_again.is_some_and(|at| at <= now) && sim.asked.is_empty() {
            asks_again = None;
            let mut again = work.requests.clone();
            if mutant == Some(CellMutant::RepeatedRequestIsNew) {
                for request in &mut again {
                    request.key += 100;
                    request.name.push_str(" again");
                }
            }
            sim.asked = vec![again];
        }
        let until = now + LOOKS;
        sim.run_by(&made, until);
        // It ends early where nothing has happened for long, as while a station is away, which may be back by now.
        let mut by = made(sim.state());
        sim.run_on(&mut *by, until);
        sim.now = sim.now.max(until);
        if !plan.is_calm() {
            let mut by = made(sim.state());
            if !(plan.is_impatient && answer_at_once(&mut sim, &mut *by, &mut answered)) {
                operator.look(&mut sim, &mut *by);
            }
        }
    }
    let told = sim.told.iter().filter_map(|told| told.as_ref().ok().cloned()).collect();
    (sim, told)
}

/// Answers alarms by where the part is now, whatever its stations do; false once each has had its answers, and needs more.
fn answer_at_once(sim: &mut CellSim, by: &mut dyn Dispatcher, answered: &mut BTreeMap<AlarmId, u32>) -> bool {
    let alarms: Vec<(AlarmId, AlarmSubject)> =
        sim.state().exceptions().alarms().map(|alarm| (alarm.id, alarm.about)).collect();
    let mut any = false;
    for (alarm, about) in alarms {
        let AlarmSubject::Firing(firing) = about else { continue };
        let count = answered.entry(alarm).or_default();
        *count += 1;
        if *count > AT_ONCE {
            continue;
        }
        any = true;
        let Some(found) = sim.truth.found(&sim.table, firing) else { continue };
        let word =
            sim.coordination.rulings(alarm).iter().find(|said| said.part == found.part).map(|said| said.word.clone());
        if let Some(word) = word {
            sim.say(by, &[PlayerInput::Answer { alarm, word: &word }]);
        }
    }
    any
}

fn break_rules(sim: &mut CellSim, mutant: Option<CellMutant>) {
    let all = ProtocolRules::default();
    let rules = match mutant {
        Some(CellMutant::AlarmAnsweredEarly) => ProtocolRules { stands_first: false, ..all },
        _ => return,
    };
    sim.coordination = sim.coordination.clone().with_rules(rules);
}

fn begin(sim: &mut CellSim, at: usize, trouble: StationTrouble, mutant: Option<CellMutant>) {
    let now = sim.now;
    let station = &mut sim.stations[at];
    match trouble {
        StationTrouble::Away => station.is_away = true,
        StationTrouble::Stuck => station.is_stuck = true,
        StationTrouble::Fails => station.fails_with = Some(7),
        StationTrouble::Stands => station.stand(now),
        StationTrouble::Forgets if mutant == Some(CellMutant::ForgottenUnseen) => station.forget_unseen(),
        StationTrouble::Forgets => station.forget(),
    }
}

fn end(sim: &mut CellSim, at: usize, trouble: StationTrouble) {
    let now = sim.now;
    let station = &mut sim.stations[at];
    match trouble {
        StationTrouble::Away => station.is_away = false,
        StationTrouble::Stuck => station.is_stuck = false,
        StationTrouble::Stands => station.go_on(now),
        StationTrouble::Fails | StationTrouble::Forgets => {}
    }
}

fn judge(plan: &CellPlan, sim: &mut CellSim, told: Vec<Vec<ProductionId>>) -> Option<String> {
    let keys = sim.stations.iter().flat_map(|station| station.done.iter().map(|done| done.key));
    let mut seen = BTreeSet::new();
    if let Some(key) = keys.into_iter().find(|&key| !seen.insert(key)) {
        return Some(format!("the order {key} was done twice"));
    }
    if let Some(first) = told.first()
        && let Some(other) = told.iter().find(|other| *other != first)
    {
        return Some(format!("the same request is answered {first:?}, and {other:?} later"));
    }
    let state = sim.state();
    let work = CellWork::of(plan.is_assembly)?;
    let known = |id: &&ProductionId| state.production().order(**id).is_none();
    if let Some(id) = told.iter().flatten().find(known) {
        return Some(format!("production order {id:?} was acknowledged, and is forgotten"));
    }
    let scrapped = state.exceptions().scrapped();
    let left = state.left();
    let open: Vec<String> = state
        .production()
        .orders()
        .filter(|order| order.ended.is_none())
        .map(|order| order.request.name.clone())
        .collect();
    if !open.is_empty() || state.parts().len() > 0 || (work.requests.is_empty() && left + scrapped < work.parts) {
        let parts = state.parts().len();
        let alarms: Vec<String> = state.exceptions().alarms().map(|alarm| format!("{:?}", alarm.about)).collect();
        return Some(format!(
            "not completed: {left} parts left, {parts} in the cell, open: {open:?}, alarms: {alarms:?}"
        ));
    }
    if !work.requests.is_empty() && state.production().orders().len() != work.requests.len() {
        return Some(format!("{} production orders of {}", state.production().orders().len(), work.requests.len()));
    }
    if left > work.parts || (plan.is_calm() && left != work.parts) {
        return Some(format!("{left} parts were made of {}", work.parts));
    }
    let really = sim.truth.parts().len();
    if really > 0 {
        return Some(format!("{really} parts are still in the cell, which counts none"));
    }
    if plan.is_calm() {
        let calm = CellPlan {
            options: CellSimOptions { crash_at: Vec::new(), bad_luck: 0, ..plan.options.clone() },
            asks_again: None,
            ..plan.clone()
        };
        let (expected, _) = run(&calm, None);
        let (expected, made) = (production(&expected, plan.is_assembly), production(sim, plan.is_assembly));
        if expected != made {
            return Some(format!("not the same production: {made:?} instead of {expected:?}"));
        }
    }
    None
}

/// Work really done on each part, in order. Which machine does a step that several can do depends on when: machines are told
/// apart only where no two do the same.
fn production(sim: &CellSim, are_told_apart: bool) -> Vec<Vec<String>> {
    let mut of_part: BTreeMap<Option<PartId>, BTreeMap<OrderKey, String>> = BTreeMap::new();
    for (index, station) in sim.stations.iter().enumerate() {
        for done in &station.done {
            let same = done.parameters.iter().filter(|(name, _)| &**name != "slot");
            let with: String = same.map(|(name, value)| format!(" {name} {value}")).collect();
            let first = done.task.split(' ').next().unwrap_or_default();
            let act = if are_told_apart { format!("{index}: {}{with}", done.task) } else { format!("{first}{with}") };
            of_part.entry(done.part).or_default().insert(done.key, act);
        }
    }
    let mut all: Vec<Vec<String>> = of_part.into_values().map(|acts| acts.into_values().collect()).collect();
    all.sort();
    all
}
