//! Anything, in any order, at any time: commands, fingers, faults, crashes, partitions, weather.
//!
//! After every single event the observer has looked at the mechanisms and the record at the counts; that is where
//! this test's assertions are. At the end of each run the world is repaired, and the line must come back to auto by
//! what its operators can do, and make two more parts.
//!
//! A long soak: `LINEWRIGHT_CASES=10000 cargo test --release -p linewright-tests random_actions`. A seed that
//! failed: `LINEWRIGHT_SEED=777 cargo test -p linewright-tests random_actions`.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{OpId, Owner, StationId};
use linewright_plant::{DeviceFault, MotionFault};
use linewright_testkit::cases::cases;
use linewright_tests::{NodeProcess, QUIET, ROUGH, Rng, WatchedLine, transfer_line_with};

const FAULTS: [MotionFault; 4] = [MotionFault::Stick, MotionFault::Slip, MotionFault::Break, MotionFault::SlipBack];

struct World {
    sim: WatchedLine,
    rng: Rng,
    stations: Vec<StationId>,
    broken: Vec<(String, String)>,
    unplugged: Vec<String>,
}

impl World {
    fn new(seed: u64) -> Self {
        let mut rng = Rng::new(seed);
        let line = transfer_line_with(if rng.chance(200) { 2 } else { 1 }, *rng.pick(&[0.1, 0.3, 1.0]));
        let mut sim = WatchedLine::with(&line, seed, QUIET, 0.1);
        let network = if rng.chance(400) { ROUGH } else { QUIET };
        sim.networks(network, if rng.chance(300) { ROUGH } else { QUIET });
        let stations = line.station_ids().collect();
        World { sim, rng, stations, broken: Vec::new(), unplugged: Vec::new() }
    }

    fn station(&mut self) -> StationId {
        *self.rng.pick(&self.stations)
    }

    fn name(&self, station: StationId) -> String {
        self.sim.line().station(station).name.clone()
    }

    fn act(&mut self) {
        let station = self.station();
        let name = self.name(station);
        match self.rng.below(100) {
            0..15 => {
                let command = *self.rng.pick(&ModeCommand::ALL);
                self.sim.command(command);
            }
            // The most frequent commands of operators, so that the line makes progress.
            15..30 => {
                let wish =
                    *self.rng.pick(&[ModeCommand::Auto, ModeCommand::Start, ModeCommand::Manual, ModeCommand::Hand]);
                self.sim.command(wish);
            }
            30..50 => {
                let advance = self.rng.chance(600);
                self.sim.release(station, advance);
                self.sim.release(station, !advance);
                self.sim.run_for(Duration::from_millis(2));
                self.sim.press(station, advance);
            }
            50..55 => {
                self.sim.release(station, true);
                self.sim.release(station, false);
            }
            55..65 => {
                let buttons = self.sim.line().buttons.len() as u64;
                let held = 1 << self.rng.below(buttons);
                self.sim.hold_buttons(held);
            }
            65..68 => self.sim.release_buttons(),
            68..71 => {
                let manual = self.rng.chance(500);
                self.sim.selector(&name, manual);
            }
            71..75 => self.fault(station, &name),
            75..79 => self.repair_motions(),
            79..82 => match self.rng.below(3) {
                0 => self.sim.kill_station(station),
                1 => self.sim.kill_station_at_its_next_record(station),
                _ => self.up_again(),
            },
            82..84 => self.sim.kill_coordinator(),
            84..89 => self.up_again(),
            89..91 => {
                let device = self.rng.below(self.sim.line().devices.len() as u64) as usize;
                let device = self.sim.line().devices[device].name.clone();
                let fault = *self.rng.pick(&[DeviceFault::Silent, DeviceFault::Reboot]);
                self.sim.fail_device(&device, Some(fault));
                self.unplugged.push(device);
            }
            91..94 => self.plug_in(),
            94..96 => {
                let other = self.station();
                let ends = [NodeProcess::Coordinator, NodeProcess::Station(other), NodeProcess::Station(station)];
                let (from, to) = (*self.rng.pick(&ends), *self.rng.pick(&ends));
                self.sim.cut(from, to);
            }
            96..98 => self.sim.heal(),
            98 => self.sim.freeze_fingers(true),
            _ => self.sim.freeze_fingers(false),
        }
    }

    fn fault(&mut self, station: StationId, name: &str) {
        let operations = self.sim.line().station(station).operations.len() as u64;
        let op = OpId::at(self.rng.below(operations) as usize);
        let operation = self.sim.line().operation((station, op)).name.clone();
        let fault = *self.rng.pick(&FAULTS);
        if self.rng.chance(700) {
            self.sim.fail(name, &operation, fault);
        } else {
            self.sim.fail_recovery(name, &operation, Some(fault));
        }
        self.broken.push((name.to_owned(), operation));
    }

    fn repair_motions(&mut self) {
        for (station, operation) in self.broken.drain(..) {
            self.sim.repair(&station, &operation);
        }
    }

    fn plug_in(&mut self) {
        for device in self.unplugged.drain(..) {
            self.sim.fail_device(&device, None);
        }
    }

    /// Starts what is down. No process comes back within a message's way.
    fn up_again(&mut self) {
        let down: Vec<StationId> = self.stations.iter().copied().filter(|&id| !self.sim.is_running(id)).collect();
        self.sim.run_for(Duration::from_millis(50));
        let remembers = self.rng.chance(500);
        self.sim.restart_coordinator(remembers);
        for station in down {
            self.sim.restart_station(station);
        }
    }

    /// Everything is mended, every finger off, every selector at auto; then an operator brings the line back.
    fn mend(&mut self) {
        self.sim.heal();
        self.sim.freeze_fingers(false);
        self.sim.networks(QUIET, QUIET);
        self.repair_motions();
        self.plug_in();
        self.sim.wire(Owner::Console, "ES_pressed", None);
        self.sim.release_buttons();
        for station in self.stations.clone() {
            self.sim.release(station, true);
            self.sim.release(station, false);
        }
        for station in self.stations.clone() {
            self.sim.spare_station(station);
        }
        self.up_again();
        for station in self.stations.clone() {
            let name = self.name(station);
            self.sim.selector(&name, false);
        }
        self.sim.run_for(Duration::from_secs(3));
        self.sim.run_until("everything is heard", WatchedLine::all_heard);
        self.sim.settle();
    }

    /// Recovery by the manual: reset, start, manual, finish or take back what was stopped, auto.
    fn bring_back(&mut self) {
        if self.sim.mode() == Some(ControlMode::EStop) {
            self.sim.order(ModeCommand::Reset);
        }
        if self.sim.mode() == Some(ControlMode::Home) {
            self.sim.order(ModeCommand::Start);
        }
        if self.sim.mode() == Some(ControlMode::Hand) || self.sim.mode() == Some(ControlMode::Auto) {
            self.sim.command(ModeCommand::EStop);
            self.sim.run_for(Duration::from_millis(500));
            self.sim.order(ModeCommand::Reset);
        }
        self.sim.go_manual();
        for station in self.stations.clone() {
            let name = self.name(station);
            for _ in 0..4 {
                if self.sim.is_incomplete(&name) || self.on_its_way_home(station) {
                    // Advance goes on with a motion, return with a recovery or a way home.
                    if !self.sim.jog(&name, true) {
                        self.sim.jog(&name, false);
                    }
                }
            }
        }
        if !self.sim.has_common_start() {
            self.sim.lead_home();
        }
        self.sim.back_to_auto();
    }

    fn on_its_way_home(&self, station: StationId) -> bool {
        self.sim.controller(station).is_some_and(|c| c.report().recovering_home)
    }
}

fn run(seed: u64) {
    let mut world = World::new(seed);
    let actions = world.rng.within(10, 60);
    if world.rng.chance(800) {
        world.sim.start_auto();
        let run_in = world.rng.within(0, 3000);
        world.sim.run_for(Duration::from_millis(run_in));
    }
    for _ in 0..actions {
        world.act();
        let pause = *world.rng.pick(&[0, 200, 5_000, 60_000, 400_000]);
        let pause = world.rng.within(0, pause);
        world.sim.run_for(Duration::from_micros(pause));
    }
    world.mend();
    world.bring_back();
    let parts = world.sim.observer().places();
    world.sim.run_until("two more parts", |s| s.observer().places() >= parts + 2);
}

#[test]
fn whatever_happens_nothing_collides_and_the_line_comes_back() {
    if let Some(seed) = std::env::var("LINEWRIGHT_SEED").ok().and_then(|seed| seed.parse().ok()) {
        return run(seed);
    }
    for seed in 0..cases(150) {
        run(seed);
    }
}
