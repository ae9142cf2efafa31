//! The database beside the log, over crashes: it is the log, whole, whatever the log itself has dropped.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use linewright_coordinator_cell::compile::dispatcher;
use linewright_coordinator_cell::{CellTable, PlayerOutbox, PlayerState, Record};
use linewright_coordinator_node::cell::HistoryFeeder;
use linewright_history::{CellAbout, HistoryReader, TimeBase};
use linewright_line::Tick;
use linewright_simulation::Rng;
use linewright_simulation::cell::{CellSim, RecordStore};

use super::crash::{Death, OnDisk, options};
use super::shipped::{Shipped, directory, shipped};

fn about(of: &Shipped) -> CellAbout {
    CellAbout {
        cell: of.cell.name.clone(),
        title: of.cell.title.clone(),
        table: of.table.digest(),
        clock: TimeBase::Simulated,
        stations: of.cell.controllers.clone(),
        // Reports are not what this is about.
        sheet: Default::default(),
    }
}

/// A log, and a database that is fed beside it.
struct Both {
    log: OnDisk,
    dir: PathBuf,
    about: CellAbout,
    chronicle: Option<HistoryFeeder>,
    /// Whether the history is passed the steps; if not, each life leaves that to the next.
    tells: bool,
    /// Records of the step in progress.
    step: Vec<Record>,
    /// Number of times that the log began anew.
    anew: Arc<AtomicUsize>,
}

impl Both {
    fn begin(&mut self, state: &PlayerState) {
        let (database, log) = (self.dir.join("cell.db"), self.dir.join("cell.log"));
        self.chronicle = Some(HistoryFeeder::open(&database, self.about.clone(), &log, state, None));
    }
}

impl RecordStore for Both {
    fn append(&mut self, record: &Record) {
        self.log.append(record);
        self.step.push(record.clone());
    }

    fn sync(&mut self) {
        self.log.sync();
    }

    fn restart(&mut self, table: &Arc<CellTable>, rng: &mut Rng) -> PlayerState {
        self.step.clear();
        self.chronicle = None;
        let state = self.log.restart(table, rng);
        self.begin(&state);
        state
    }

    fn settled(&mut self, state: &PlayerState) {
        let chronicle = self.chronicle.as_mut().expect("it is open");
        let out = PlayerOutbox { records: std::mem::take(&mut self.step), ..PlayerOutbox::default() };
        if self.tells {
            chronicle.tell(state, &out);
        }
        if self.log.is_long() {
            // Virtual time is faster than any disk.
            let since = Instant::now();
            while self.tells && !chronicle.has(state) {
                assert!(since.elapsed() < Duration::from_secs(20), "{:?}", chronicle.failed());
                std::thread::yield_now();
            }
            if chronicle.has(state) {
                self.log.settled(state);
                self.anew.fetch_add(1, Ordering::Relaxed);
            }
        }
    }
}

/// Records of a database; none may be missing.
fn records(path: &Path) -> Vec<Record> {
    let mut records = Vec::new();
    let reader = HistoryReader::open(path).expect("opens");
    reader.each(Tick::NEVER, |event| records.push(event.record().expect("nothing is missing"))).expect("reads");
    records
}

/// Plays a production that is killed at these steps; how often the log began anew.
fn played(of: &Shipped, death: Death, crash_at: Vec<usize>, seed: u64, tells: bool) -> usize {
    let dir = directory();
    let log = OnDisk::new(dir.path(), &of.table, death, 15);
    let anew = Arc::new(AtomicUsize::new(0));
    let path = dir.path().to_owned();
    let (chronicle, step) = (None, Vec::new());
    let mut both = Both { log, dir: path, about: about(of), chronicle, tells, step, anew: anew.clone() };
    both.begin(&PlayerState::new(of.table.clone()));
    let mut sim = CellSim::with_store(of.table.clone(), of.stations, options(seed, 6, crash_at), Box::new(both));
    sim.run(&mut dispatcher(&of.cell, &of.table), Tick::from_millis(24 * 3_600_000));
    assert_eq!(sim.state().left(), u64::from(of.parts));
    let (log, state) = (sim.log.clone(), sim.state().clone());
    // The last life ends, and another one begins that takes what is missing.
    drop(sim);
    let (database, log_file) = (dir.path().join("cell.db"), dir.path().join("cell.log"));
    HistoryFeeder::open(&database, about(of), &log_file, &state, None).close().expect("all is written");
    assert!(records(&database) == log, "seed {seed}, {death:?}: the database is the log");
    anew.load(Ordering::Relaxed)
}

#[test]
fn after_any_crashes_the_database_is_the_whole_log() {
    let mut rng = Rng::new(31);
    let mut anew = 0;
    for (name, parts) in [("assembly-cell", &[2, 2, 1][..]), ("workcell-c1", &[3, 3])] {
        let of = shipped(name, parts);
        for seed in 0..8 {
            let death = if seed % 2 == 0 { Death::Killed } else { Death::PowerCut };
            let mut at = 0;
            let crash_at = (0..8).map(|_| {
                at += 1 + rng.below(50) as usize;
                at
            });
            anew += played(&of, death, crash_at.collect(), seed, true);
        }
    }
    assert!(anew > 0, "no log has begun anew");
}

#[test]
fn what_was_never_told_is_read_from_the_log() {
    let of = shipped("assembly-cell", &[2, 2, 1]);
    let anew = played(&of, Death::Killed, vec![30, 90], 3, false);
    // The database is behind in each life from its first step on, so the log may drop nothing.
    assert_eq!(anew, 0);
}
