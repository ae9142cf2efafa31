//! Cells that were played, and their databases.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use linewright_cell::net::Supply;
use linewright_coordinator_cell::Record;
use linewright_coordinator_cell::compile::{OrderTiming, compile_cell, dispatcher, sheet};
use linewright_history::{CellAbout, EventKind, HistoryEvent, HistoryReader, TimeBase};
use linewright_line::Tick;
use linewright_simulation::cell::{CellSim, CellSimOptions};
use tempfile::TempDir;

/// A cell, and everything that has happened to it.
pub struct Played {
    pub about: CellAbout,
    pub log: Vec<Record>,
}

/// A shipped cell that makes parts, with one order in so many failing.
pub fn played(name: &str, parts: &[u32], seed: u64, failing: u64) -> Played {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../launch-config/lines").join(name).join("cell.toml");
    let text = std::fs::read_to_string(file).expect("it is there");
    let cell = linewright_cell::parse("cell.toml", &text, None).expect("it is sound").cell;
    let pace = OrderTiming { repeat_interval: Duration::from_secs(1), grace: Duration::from_secs(1) };
    let made = compile_cell(&cell, None, Supply::Batch(parts), pace).expect("it can be played");
    let table = Arc::new(made.table.clone());
    let mut sim =
        CellSim::new(table.clone(), cell.controllers.len(), CellSimOptions { seed, ..CellSimOptions::default() });
    sim.stations.iter_mut().for_each(|station| station.failing = failing);
    sim.run(&mut dispatcher(&cell, &table), Tick::from_millis(3_600_000));
    let about = CellAbout {
        cell: cell.name.clone(),
        title: cell.title.clone(),
        table: table.digest(),
        clock: TimeBase::Unix,
        stations: cell.controllers.clone(),
        sheet: sheet(&cell, &made),
    };
    Played { about, log: sim.log }
}

pub fn c1() -> Played {
    played("workcell-c1", &[3, 2], 1, 0)
}

/// A place for a database.
pub fn scratch() -> (TempDir, PathBuf) {
    let dir = TempDir::new().expect("a directory");
    let path = dir.path().join("cell.db");
    (dir, path)
}

/// Everything that a database has.
pub fn events(path: &Path) -> Vec<HistoryEvent> {
    let mut events = Vec::new();
    HistoryReader::open(path).expect("opens").each(Tick::NEVER, |event| events.push(event)).expect("reads");
    events
}

/// The records that a database has.
pub fn records(path: &Path) -> Vec<Record> {
    let events = events(path);
    let numbers = events.iter().filter_map(|event| match event.what {
        EventKind::Fact(number, _) => Some(number),
        EventKind::Note(_) => None,
    });
    let records: Vec<Record> = events.iter().filter_map(HistoryEvent::record).collect();
    assert!(numbers.eq(1..=records.len() as u64), "they are numbered as in the log");
    records
}
