//! A line in the simulation, on its buses, watched after every event.
//!
//! After each event the observer has looked at the mechanisms, and the simulation's record has compared the counts: every
//! cycle of every operation is done, and done once. A run ends at the first violation.

use std::ops::Deref;
use std::time::Duration;

use linewright_line::{Line, StationId, Tick};
use linewright_simulation::{LogKind, Network, OperatorAction, SimOptions};
use linewright_station_logic::HappeningKind;

use crate::observer::IndependentObserver;

/// A quiet machine: up to half a millisecond, nothing lost.
pub const QUIET: Network = network((50, 500), 0, 0);
/// A loaded network: up to 20 ms, 5 % lost, 5 % doubled.
pub const ROUGH: Network = network((100, 20_000), 50, 50);

/// A network on which messages take between so many microseconds, and so many of a thousand are lost or doubled.
pub const fn network((shortest, longest): (u64, u64), loss_per_mille: u32, double_per_mille: u32) -> Network {
    Network {
        delay: Duration::from_micros(shortest),
        jitter: Duration::from_micros(longest - shortest),
        loss_per_mille,
        double_per_mille,
        best_effort: true,
    }
}

/// A watched line in virtual time.
pub struct WatchedLine {
    sim: linewright_simulation::LineSim,
    pub(crate) observer: IndependentObserver,
    seed: u64,
    /// Entries of the log that were looked at.
    read: u64,
    /// Mechanisms stand where the observer has seen them then.
    looked: Tick,
}

impl Deref for WatchedLine {
    type Target = linewright_simulation::LineSim;

    fn deref(&self) -> &Self::Target {
        &self.sim
    }
}

impl WatchedLine {
    /// A line switched on at time zero, on a quiet network.
    pub fn new(line: &Line, seed: u64) -> Self {
        WatchedLine::with(line, seed, QUIET, 0.0)
    }

    /// A line switched on at time zero, whose motions take up to `variation` (a fraction) longer or shorter.
    pub fn with(line: &Line, seed: u64, network: Network, variation: f64) -> Self {
        let options = SimOptions {
            seed,
            network,
            images: network,
            variation,
            frames: true,
            keeps_log: true,
            ..SimOptions::default()
        };
        let sim = linewright_simulation::LineSim::new(line, options);
        WatchedLine {
            sim: sim.unwrap_or_else(|error| panic!("the line of a test starts: {error}")),
            observer: IndependentObserver::new(line),
            seed,
            read: 0,
            looked: Tick::ZERO,
        }
    }

    /// Does something to the line.
    pub fn act(&mut self, action: OperatorAction) {
        self.sim.act(action).unwrap_or_else(|error| panic!("what a test starts comes up: {error}"));
    }

    /// The simulation, for what only some scenarios do to it.
    pub(crate) fn inner(&mut self) -> &mut linewright_simulation::LineSim {
        &mut self.sim
    }

    /// Runs until `end`.
    ///
    /// # Panics
    /// When the observer sees what must not happen, or the record a cycle lost or doubled.
    pub fn run_to(&mut self, end: Tick) {
        while self.next_event() <= end {
            self.step();
        }
        self.sim.run_to(end);
    }

    pub fn run_for(&mut self, time: Duration) {
        self.run_to(self.now() + time);
    }

    /// Plays one event.
    pub(crate) fn step(&mut self) {
        self.sim.step();
        let log = self.sim.log();
        let from = usize::try_from(self.read - log.forgotten()).unwrap_or(usize::MAX);
        self.read = log.forgotten() + log.entries().len() as u64;
        for entry in log.entries().get(from..).unwrap_or_default() {
            let LogKind::Station(id, event) = entry.what else { continue };
            match event.what {
                HappeningKind::Refused => self.refused(id),
                // Motions without a generation are not counted: which part is where is then for people to see.
                HappeningKind::Started(..) if self.controller(id).is_some_and(|of| of.generation() == 0) => {
                    self.observer.lose_parts();
                }
                _ => {}
            }
        }
        let plant = self.sim.plant_of(StationId::at(0));
        if plant.now() != self.looked {
            self.looked = plant.now();
            self.observer.look(plant);
        }
        self.judge();
    }

    /// A press that moves nothing must leave the operator with a reason to read, if nothing is moving anyway.
    fn refused(&self, id: StationId) {
        let Some(controller) = self.controller(id) else { return };
        let silent = controller.blocked_by(self.line(), self.now()).is_empty();
        if silent && !controller.marking().any(|place| place.is_operating()) {
            self.give_up(&format!("{} refuses a press and does not say why", self.line().station(id).name));
        }
    }

    fn judge(&self) {
        if !self.observer.violations().is_empty() {
            self.give_up(&self.observer.violations().join("\n"));
        }
        if !self.conflicts().is_empty() {
            self.give_up(&format!("by the description: {:?}", self.conflicts()));
        }
        if self.alarms() != 0 {
            self.give_up("both actuators of one axis were on at once");
        }
        if !self.record().errors().is_empty() {
            self.give_up(&self.record().errors().join("\n"));
        }
    }

    /// Ends the run with what a person needs to understand it.
    pub(crate) fn give_up(&self, why: &str) -> ! {
        let tail = self.log().tail(self.line(), 120);
        let states = self.states_text();
        panic!("{why}\nat {} with seed {}\n{tail}{states}", self.now(), self.seed);
    }
}
