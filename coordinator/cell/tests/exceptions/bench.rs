//! A described cell, played, with faults and answers.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use linewright_cell::Cell;
use linewright_cell::net::Supply;
use linewright_coordinator_cell::compile::{OrderTiming, compile_cell};
use linewright_coordinator_cell::exception::{Alarm, ExceptionStep, StationUnavailable};
use linewright_coordinator_cell::{
    CellId, CellTable, Fifo, ModeId, OngoingActivity, PartId, PlayerInput, PlayerState, Presence, RecordKind,
    ResourceId,
};
use linewright_line::{Line, RestId, StationId, Tick};
use linewright_simulation::cell::{CellSim, CellSimOptions, StationSpeed as Takes};

const PACE: OrderTiming = OrderTiming { repeat_interval: Duration::from_millis(200), grace: Duration::from_secs(1) };
/// A station with an order is lost after this time without a report.
pub const LOST_AFTER: Duration = Duration::from_secs(3);
/// So long stations have to come to rest.
pub const SECURE: Duration = Duration::from_secs(10);

pub fn workcell() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../launch-config/lines/workcell-c1/cell.toml");
    std::fs::read_to_string(path).expect("it is there")
}

/// The line of that cell, with a change in its description.
pub fn workcell_line(changed: impl Fn(String) -> String) -> Line {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../launch-config/lines/workcell-c1/line.toml");
    let line = changed(std::fs::read_to_string(path).expect("it is there"));
    linewright_line::parse("line.toml", &line).expect("it is sound").line
}

/// A cell that is to make so many parts of each type.
pub fn table(text: &str, parts: &[u32]) -> (Cell, Arc<CellTable>) {
    table_of(text, None, parts)
}

fn table_of(text: &str, line: Option<&Line>, parts: &[u32]) -> (Cell, Arc<CellTable>) {
    let cell = linewright_cell::parse("cell.toml", text, line).expect("it is sound").cell;
    let table = compile_cell(&cell, line, Supply::Batch(parts), PACE).expect("it can be played").table;
    let mut handling = table.handling().clone();
    (handling.lost_after, handling.secure) = (Some(LOST_AFTER), SECURE);
    (cell, Arc::new(table.with_handling(handling)))
}

pub fn options(seed: u64) -> CellSimOptions {
    let millis = Duration::from_millis;
    CellSimOptions {
        seed,
        pace: Takes::Nominal { spread: 0.0 },
        delay: (millis(1), millis(20)),
        period: millis(100),
        replays: true,
        ..CellSimOptions::default()
    }
}

/// A cell, played.
pub struct CellBench {
    pub table: Arc<CellTable>,
    pub sim: CellSim,
    seen: usize,
}

impl CellBench {
    pub fn new(text: &str, parts: &[u32]) -> Self {
        Self::of(table(text, parts))
    }

    /// C1 with its line, so that it is known where its stations rest.
    pub fn c1_of_its_line(parts: &[u32]) -> Self {
        Self::c1_of_line(|line| line, parts)
    }

    /// The same with a change in the line's description.
    pub fn c1_of_line(changed: impl Fn(String) -> String, parts: &[u32]) -> Self {
        Self::beside(&workcell(), &workcell_line(changed), parts)
    }

    /// A cell that is known with its line.
    pub fn beside(text: &str, line: &Line, parts: &[u32]) -> Self {
        let mut bench = Self::of(table_of(text, Some(line), parts));
        // All stations are heard at once, so M1 is loaded first.
        bench.sim.options.delay = (Duration::from_millis(1), Duration::from_millis(1));
        bench
    }

    /// What stations say now is heard, also while nothing else happens.
    pub fn hear(&mut self) {
        let later = self.sim.now + Duration::from_secs(2);
        self.sim.run_on(&mut Fifo, later);
    }

    fn of((cell, table): (Cell, Arc<CellTable>)) -> Self {
        let mut sim = CellSim::new(table.clone(), cell.controllers.len(), options(1));
        sim.senses = true;
        CellBench { table, sim, seen: 0 }
    }

    pub fn c1(parts: &[u32]) -> Self {
        Self::new(&workcell(), parts)
    }

    /// Until so many seconds have gone.
    pub fn until(&mut self, seconds: f64) {
        self.sim.run(&mut Fifo, Tick::from_micros((seconds * 1e6) as u64));
    }

    pub fn seconds_later(&mut self, seconds: f64) {
        let now = self.sim.now.as_secs_f64();
        self.until(now + seconds);
    }

    /// Plays until a part rests in M1 after an activity, because a station is moved by hand, and takes it away; the
    /// difference is found when M1 is to be counted on again. Gives the part, and the marking before.
    pub fn taken_away(&mut self, activity: &str, idle: &str, at: &str) -> (PartId, Vec<u64>) {
        self.taken_away_at(activity, idle, at, None)
    }

    /// The same; meanwhile the station has come to this rest.
    pub fn taken_away_at(&mut self, activity: &str, idle: &str, at: &str, rest: Option<RestId>) -> (PartId, Vec<u64>) {
        self.until_that(|bench| bench.firing(activity).is_some());
        self.at(idle).rest = rest.or(self.at(idle).rest);
        self.at(idle).unable = Some(StationUnavailable::ByHand);
        self.until_that(|bench| bench.count(at) > 0);
        let part = self.state().parts().next().expect("it is inside").id;
        let (m1, before) = (self.resource("M1"), self.state().marking().counts().to_vec());
        self.say(PlayerInput::Resource { resource: m1, up: false });
        self.sim.truth.put(part, None);
        self.works(idle);
        self.say(PlayerInput::Resource { resource: m1, up: true });
        (part, before)
    }

    /// A station is moved by hand no longer, and reports that.
    pub fn works(&mut self, idle: &str) {
        self.at(idle).unable = None;
        self.seconds_later(2.0);
    }

    /// Step by step until something holds; for an hour at most.
    pub fn until_that(&mut self, what: impl Fn(&CellBench) -> bool) {
        for _ in 0..36_000 {
            if what(self) {
                return;
            }
            let next = self.sim.now + Duration::from_millis(100);
            self.sim.run(&mut Fifo, next);
        }
        panic!("it does not come to that: {:#?}", self.steps());
    }

    pub fn say(&mut self, what: PlayerInput<'_>) {
        self.sim.say(&mut Fifo, &[what]);
    }

    /// Answers the present alarm.
    pub fn answer(&mut self, word: &str) {
        let alarm = self.alarm().id;
        self.say(PlayerInput::Answer { alarm, word });
    }

    pub fn state(&self) -> &PlayerState {
        self.sim.state()
    }

    pub fn station(&self, name: &str) -> StationId {
        let known = &self.table.handling().stations;
        known.iter().find(|(_, of)| **of == *name).map(|(id, _)| *id).expect("there is such a station")
    }

    pub fn at(&mut self, name: &str) -> &mut linewright_simulation::cell::SimulatedStation {
        let index = self.station(name).index();
        &mut self.sim.stations[index]
    }

    pub fn resource(&self, name: &str) -> ResourceId {
        self.table.handling().resource_named(name).expect("there is such a resource")
    }

    pub fn mode(&self, name: &str) -> ModeId {
        self.table.modes().find(|&mode| self.table.mode_name(mode) == name).expect("there is such a mode")
    }

    pub fn cell(&self, name: &str) -> CellId {
        self.table.cells().find(|&cell| self.table.cell_name(cell) == name).expect("there is such a cell")
    }

    pub fn count(&self, name: &str) -> u64 {
        self.state().marking().count(self.cell(name))
    }

    /// The activity of that mode that is in progress.
    pub fn firing(&self, mode: &str) -> Option<&OngoingActivity> {
        let mode = self.mode(mode);
        self.state().firings().find(|firing| firing.mode == mode)
    }

    /// The only alarm that stands.
    pub fn alarm(&self) -> &Alarm {
        let alarms: Vec<_> = self.state().exceptions().alarms().collect();
        assert_eq!(alarms.len(), 1, "{alarms:#?}");
        alarms[0]
    }

    /// The text of the only alarm that stands, as things are now.
    pub fn alarm_now(&self) -> String {
        self.sim.coordination.alarm_text(self.sim.now, self.alarm())
    }

    /// The steps of exceptions so far.
    pub fn steps(&self) -> Vec<&ExceptionStep> {
        let facts = self.sim.log.iter().map(|record| &record.fact);
        facts.filter_map(|fact| if let RecordKind::Exception(step) = fact { Some(step) } else { None }).collect()
    }

    /// Records since the last call.
    pub fn news(&mut self) -> Vec<RecordKind> {
        let facts = self.sim.log[self.seen..].iter().map(|record| record.fact.clone()).collect();
        self.seen = self.sim.log.len();
        facts
    }

    pub fn presence(&self, name: &str) -> Presence {
        self.sim.stations[self.station(name).index()].presence
    }
}
