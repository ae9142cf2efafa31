//! The token player and the real controllers of two task-driven stations: they are joined by messages alone, which may be
//! lost, doubled and late. Each task is done once for each activity, whatever is restarted.
//!
//! A robot loads and unloads one machine from a store. They see each other by their switches: the machine clamps when the
//! robot holds a part there, and the robot lets go when the machine has clamped (seed 001, L214-222).

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use linewright_cell::net::Supply;
use linewright_coordinator_cell::compile::{OrderTiming, compile_cell};
use linewright_coordinator_cell::{
    ActivityPhase, CellMessage, Coordination, Fifo, OrderKey as Key, OrderMessage, PlayerInput as Told,
    PlayerOutbox as Says, PlayerState, Record, RecordKind, TaskReply as Answer, TaskReport,
};
use linewright_coordinator_shell::orders;
use linewright_line::net::{Block, ControlMode, StationPlace};
use linewright_line::{Line, MotionSignals, OperationModule, StationId, Tick, parse};
use linewright_orders::LeaveWay;
use linewright_proof::generate::Random;
use linewright_station_logic::{
    Controller, HappeningKind, ModeOrder, NO_DELAY, Restore, StationInput, StationOutbox, TaskCommand,
};

const LINE: &str = include_str!("../../model/line/tests/descriptions/task_driven.toml");
const CELL: &str = r#"
name = "served"
[cell]
wip_max = 2
reserve = true
safety = 4
[dispatch]
rules = ["fifo"]
patience_s = 600
[[resource]]
name = "ST"
prototype = "random-access-store"
capacity = 2
[[resource]]
name = "M1"
prototype = "machine"
capacity = 1
station = "m1"
[[resource]]
name = "R"
prototype = "robot"
station = "robot"
[[sync]]
name = "load M1"
actions = ["ST.retrieve", "R.pick-and-place", "M1.load"]
time_s = 6
orders = [{ station = "robot", task = "load m1", parameters = { slot = 1 } }, { station = "m1", task = "clamp" }]
[[sync]]
name = "unload M1"
actions = ["M1.unload", "R.pick-and-place", "ST.store"]
time_s = 5
orders = [{ station = "robot", task = "unload m1", parameters = { slot = 2 } }, { station = "m1", task = "release" }]
[[sync]]
name = "enter"
actions = ["outside.in", "ST.store"]
[[sync]]
name = "leave"
actions = ["ST.retrieve", "outside.out"]
[[action]]
of = "M1.process"
orders = [{ station = "m1", task = "machine", parameters = { program = "step.program" } }]
[[part]]
name = "A"
[[part.step]]
name = "mill"
on = [{ resource = "M1", time_s = 4, program = 5 }]
"#;

const STEP: Duration = Duration::from_millis(10);

/// One station: its controller, its mechanism, and what it has kept.
struct Served {
    controller: Controller,
    out: StationOutbox,
    image: u128,
    /// The motion under way, and when it arrives.
    motion: Option<(StationPlace, Tick)>,
    /// The tasks it has done, by name; read by the test alone.
    done: Vec<String>,
}

enum Flying {
    Order(OrderMessage),
    Secure(StationId, Key, LeaveWay),
    Answer(StationId, Key, Answer),
    State(StationId, u64, TaskReport),
}

struct World {
    line: Line,
    coordination: Coordination,
    log: Vec<Record>,
    stations: Vec<Served>,
    now: Tick,
    flying: BTreeMap<(Tick, u64), Flying>,
    sent: u64,
    newest: [u64; 2],
    random: Random,
    /// One message in so many is lost, and as many are doubled; none with 0.
    bad_luck: u32,
    lives: u64,
    doubled: usize,
}

fn signals(line: &Line, station: StationId, place: StationPlace) -> MotionSignals {
    let operation = line.operation((station, place.op));
    match (&operation.module, place.block) {
        (OperationModule::Reversible { recovery, .. }, Block::Recovery) => *recovery,
        (OperationModule::Reversible { .. } | OperationModule::Irreversible { .. }, _) => operation.normal,
    }
}

impl Served {
    fn new(line: &Line, station: StationId, boot_id: u64, restore: Restore, image: u128) -> Self {
        let controller = Controller::new(line, station, boot_id, restore).expect("it compiles");
        Served { controller, out: StationOutbox::default(), image, motion: None, done: Vec::new() }
    }

    /// One scan: mechanism, image, mode, step.
    fn scan(&mut self, line: &Line, now: Tick) {
        let station = self.controller.station();
        if let Some((place, _)) = self.motion.take_if(|(_, at)| *at <= now) {
            self.image |= 1 << signals(line, station, place).complete.0;
        }
        let order = ModeOrder::of(1, 1, ControlMode::Auto, line.timing.lease);
        self.controller.handle(now, StationInput::Order(order));
        let bits = self.image;
        self.controller.handle(now, StationInput::Inputs { bits, valid: true, until: Tick::NEVER, under: NO_DELAY });
        self.step(line, now);
        let place = self.controller.marking().next().expect("one token");
        if place.is_operating() && self.motion.is_none_or(|(moving, _)| moving != place) {
            // It leaves where it stood.
            let axis = line.operation((station, place.op)).motion.axis;
            for (op, operation) in line.station(station).op_ids().zip(&line.station(station).operations) {
                if operation.motion.axis == axis {
                    for place in [StationPlace::operating(op), StationPlace::undoing(op)] {
                        self.image &= !(1 << signals(line, station, place).complete.0);
                    }
                }
            }
            self.motion = Some((place, now + line.operation((station, place.op)).duration));
        }
    }

    fn step(&mut self, line: &Line, now: Tick) {
        self.controller.step(now, &mut self.out);
        for event in self.out.events.drain(..) {
            if let HappeningKind::OrderDone(task) = event.what {
                self.done.push(line.station(self.controller.station()).task(task).name.clone());
            }
        }
    }
}

impl World {
    fn new(parts: u32, seed: u64, bad_luck: u32) -> Self {
        let line = parse("line.toml", LINE).unwrap_or_else(|problems| panic!("{problems:#}")).line;
        let cell =
            linewright_cell::parse("cell.toml", CELL, Some(&line)).unwrap_or_else(|problems| panic!("{problems:#}"));
        let pace = OrderTiming { repeat_interval: Duration::from_millis(200), grace: Duration::from_secs(1) };
        let made =
            compile_cell(&cell.cell, Some(&line), Supply::Closed(&[parts]), pace).unwrap_or_else(|why| panic!("{why}"));
        let mut out = Says::default();
        let state = PlayerState::new(Arc::new(made.table));
        let coordination = Coordination::begin(state, Tick::ZERO, 1, &mut out).expect("the first life");
        let at_home = |names: [&str; 2], station: u16| {
            let inputs = &line.station(StationId(station)).inputs;
            names
                .iter()
                .fold(0u128, |bits, name| bits | 1 << inputs.iter().position(|input| input == name).expect("there"))
        };
        let stations = vec![
            Served::new(&line, StationId(0), 7, Restore::Fresh, at_home(["C_0", "L_0"], 0)),
            Served::new(&line, StationId(1), 8, Restore::Fresh, at_home(["A_0", "G_0"], 1)),
        ];
        World {
            line,
            coordination,
            log: out.records,
            stations,
            now: Tick::from_millis(1),
            flying: BTreeMap::new(),
            sent: 0,
            newest: [0; 2],
            random: Random::new(seed),
            bad_luck,
            lives: 1,
            doubled: 0,
        }
    }

    fn bit(&self, station: u16, input: &str) -> u128 {
        let inputs = &self.line.station(StationId(station)).inputs;
        1 << inputs.iter().position(|name| name == input).unwrap_or_else(|| panic!("no input {input}"))
    }

    /// The switches of the one are sensors of the other.
    fn see(&mut self) {
        let links = [(1, "A_100", 0, "part_present"), (0, "C_60", 1, "m1_closed")];
        for (from, switch, to, sensor) in links {
            let on = self.stations[usize::from(from)].image & self.bit(from, switch) != 0;
            let sensor = self.bit(to, sensor);
            let image = &mut self.stations[usize::from(to)].image;
            *image = if on { *image | sensor } else { *image & !sensor };
        }
    }

    fn one_in(&mut self, cases: u32) -> bool {
        cases > 0 && self.random.below(cases as usize) == 0
    }

    fn fly(&mut self, what: impl Fn() -> Flying) {
        let times = if self.one_in(self.bad_luck) { 0 } else { 1 + usize::from(self.one_in(self.bad_luck)) };
        for _ in 0..times {
            self.sent += 1;
            let delay = if self.one_in(self.bad_luck) { 600 } else { 1 + self.random.below(20) as u64 };
            self.flying.insert((self.now + Duration::from_millis(delay), self.sent), what());
        }
    }

    /// A moment passes; whether activities may start.
    fn tick(&mut self, starts: bool) {
        self.now = self.now + STEP;
        self.see();
        for station in &mut self.stations {
            station.scan(&self.line, self.now);
        }
        if self.now.as_micros() % 100_000 < STEP.as_micros() as u64 {
            for (id, station) in [0u16, 1].into_iter().zip(0..) {
                let report = self.stations[station as usize].controller.report().order.expect("it is task-driven");
                let number = self.sent + 1;
                self.fly(|| Flying::State(StationId(id), number, orders::heard(&report)));
            }
        }
        let mut arrived = Vec::new();
        while let Some(entry) = self.flying.first_entry().filter(|entry| entry.key().0 <= self.now) {
            match entry.remove() {
                Flying::Order(message) => self.deliver(&message),
                Flying::Secure(station, key, way) => self.secure(station, key, way),
                Flying::Answer(station, key, answer) => arrived.push((station, Err((key, answer)))),
                Flying::State(station, number, heard) if number > self.newest[station.index()] => {
                    self.newest[station.index()] = number;
                    arrived.push((station, Ok(heard)));
                }
                Flying::State(..) => {}
            }
        }
        let mut inputs = vec![Told::Starts(starts)];
        inputs.extend(arrived.iter().map(|(station, what)| match what {
            Ok(heard) => Told::Station(*station, heard),
            Err((key, answer)) => Told::Reply(*station, *key, *answer),
        }));
        let mut out = Says::default();
        self.coordination.step(self.now, &inputs, &mut Fifo, &mut out);
        assert_eq!(out.events, [], "at {}", self.now);
        self.log.append(&mut out.records);
        for send in out.sends {
            match send {
                CellMessage::Order(message) => self.fly(|| Flying::Order(message.clone())),
                CellMessage::Secure { station, key, way } => self.fly(|| Flying::Secure(station, key, way)),
            }
        }
    }

    fn deliver(&mut self, message: &OrderMessage) {
        let station = &mut self.stations[message.station.index()];
        let order = &message.order;
        let known = station.controller.report().order.is_some_and(|report| {
            report.slot.is_some_and(|slot| slot.key == order.key)
                || report.results.iter().any(|(key, _)| *key == order.key)
        });
        self.doubled += usize::from(known);
        station.controller.handle(self.now, StationInput::Task(TaskCommand::Run(order)));
        station.step(&self.line, self.now);
        let replies = std::mem::take(&mut station.out.replies);
        assert_eq!(replies.len(), 1);
        self.fly(|| Flying::Answer(message.station, order.key, replies[0].1));
    }

    /// The coordinator receives its answer by its state as well.
    fn secure(&mut self, to: StationId, key: Key, way: LeaveWay) {
        let station = &mut self.stations[to.index()];
        station.controller.handle(self.now, StationInput::Task(TaskCommand::Leave(key, way)));
        station.step(&self.line, self.now);
        station.out.replies.clear();
    }

    /// The coordinator is killed, and another life goes on with what was written down.
    fn kill_coordinator(&mut self) {
        let table = self.coordination.state().table().clone();
        let state = PlayerState::replay(table, &self.log).expect("its own records");
        let mut out = Says::default();
        let epoch = state.epoch() + 1;
        self.coordination = Coordination::begin(state, self.now, epoch, &mut out).expect("a new epoch");
        self.log.append(&mut out.records);
        self.newest = [0; 2];
        self.lives += 1;
    }

    /// A station's process is killed while it rests, and comes up with what it has kept.
    fn kill_station(&mut self, at: usize) {
        let station = &self.stations[at];
        let report = station.controller.report();
        if report.order.is_some_and(|order| order.slot.is_some() || order.rest.is_none()) {
            return;
        }
        self.lives += 1;
        let restore = Restore::From(station.controller.snapshot());
        let (image, done) = (station.image, station.done.clone());
        let id = station.controller.station();
        self.stations[at] = Served { done, ..Served::new(&self.line, id, 100 + self.lives, restore, image) };
    }

    /// Until the machine has given so many parts away, and then until nothing is in progress any more. Parts that leave come
    /// in again.
    fn run(&mut self, parts: usize, kills: bool) {
        let end = Tick::from_millis(600_000);
        while self.now < end {
            let given = self.stations[0].done.iter().filter(|task| *task == "release").count();
            self.tick(given < parts);
            if kills && self.one_in(300) {
                self.kill_coordinator();
            }
            if kills && self.one_in(200) {
                let at = self.random.below(2);
                self.kill_station(at);
            }
            let state = self.coordination.state();
            let failed = state.firings().find(|firing| firing.phase != ActivityPhase::Running);
            assert_eq!(failed, None, "at {}", self.now);
            if given >= parts && state.firings().next().is_none() {
                return;
            }
        }
        panic!("not done by {end}: {:?}", self.stations.iter().map(|station| station.done.len()).collect::<Vec<_>>());
    }

    /// Each station has done its orders, each once and in their order; and both rest.
    fn is_done(&self) {
        let state = self.coordination.state();
        let mut told = [Vec::new(), Vec::new()];
        for record in &self.log {
            if let RecordKind::Started { mode, .. } = &record.fact {
                for order in &state.table().activity(*mode).orders {
                    told[order.station.index()].push(order.task.to_string());
                }
            }
        }
        for (station, told) in self.stations.iter().zip(&told) {
            assert_eq!(&station.done, told);
            assert!(station.controller.report().at_home);
        }
        assert!(told[0].len() >= 9 && told[1].len() >= 6, "{told:?}");
    }
}

#[test]
fn parts_are_loaded_machined_and_unloaded_by_real_controllers() {
    let mut world = World::new(3, 1, 0);
    world.run(3, false);
    world.is_done();
    assert_eq!(world.stations[0].done[..3], ["clamp", "machine", "release"].map(str::to_owned));
}

#[test]
fn whatever_is_lost_doubled_or_late_each_task_is_done_once() {
    let mut doubled = 0;
    for seed in 0..12 {
        let mut world = World::new(3, seed, 6);
        world.run(3, false);
        world.is_done();
        doubled += world.doubled;
    }
    assert!(doubled >= 10, "{doubled} orders came twice");
}

#[test]
fn whoever_is_restarted_each_task_is_done_once() {
    let mut lives = 0;
    for seed in 0..12 {
        let mut world = World::new(3, seed, 8);
        world.run(3, true);
        world.is_done();
        lives += world.lives;
    }
    assert!(lives >= 60, "{lives} lives");
}
