//! A cell in virtual time, with the names of what was compiled. No unexpected message may be sent in it.

use std::ops::{Deref, DerefMut};
use std::time::Duration;

use linewright_coordinator_cell::Dispatcher;
use linewright_line::Tick;
use linewright_simulation::cell::{CellSim, CellSimOptions, StationSpeed};

use super::plans::Compiled;

pub struct World {
    pub it: Compiled,
    sim: CellSim,
}

/// Stations take what they take, messages some milliseconds, and one in so many is lost, and doubled.
pub fn options(seed: u64, bad_luck: u64, crash_at: Vec<usize>) -> CellSimOptions {
    let millis = Duration::from_millis;
    CellSimOptions {
        seed,
        bad_luck,
        crash_at,
        pace: StationSpeed::Between(millis(500), millis(2000)),
        delay: (millis(1), millis(20)),
        period: millis(100),
        replays: false,
    }
}

impl World {
    pub fn new(it: Compiled, stations: usize, seed: u64) -> Self {
        World::with(it, stations, options(seed, 0, Vec::new()))
    }

    pub fn with(it: Compiled, stations: usize, options: CellSimOptions) -> Self {
        let sim = CellSim::new(it.table.clone(), stations, options);
        World { it, sim }
    }

    pub fn run(&mut self, dispatcher: &mut dyn Dispatcher, until: Tick) {
        self.sim.run(dispatcher, until);
        assert_eq!(self.sim.events, []);
    }
}

impl Deref for World {
    type Target = CellSim;

    fn deref(&self) -> &CellSim {
        &self.sim
    }
}

impl DerefMut for World {
    fn deref_mut(&mut self) -> &mut CellSim {
        &mut self.sim
    }
}
