//! The shipped cells, and what they have to have produced.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use linewright_cell::Cell;
use linewright_cell::net::Supply;
use linewright_coordinator_cell::compile::{CompiledCell, OrderTiming, compile_cell};
use linewright_coordinator_cell::{CellTable, OrderKey, PartId};
use linewright_simulation::cell::CellSim;
use tempfile::TempDir;

pub const PACE: OrderTiming =
    OrderTiming { repeat_interval: Duration::from_millis(200), grace: Duration::from_secs(1) };

/// A cell and a production of it.
pub struct Shipped {
    pub cell: Cell,
    pub made: CompiledCell,
    pub table: Arc<CellTable>,
    pub stations: usize,
    /// Number of parts in all.
    pub parts: u32,
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../launch-config/lines").join(name).join("cell.toml")
}

pub fn shipped(name: &str, parts: &[u32]) -> Shipped {
    paced(name, parts, PACE)
}

pub fn paced(name: &str, parts: &[u32], pace: OrderTiming) -> Shipped {
    supplied(name, Supply::Batch(parts), parts.iter().sum(), pace)
}

/// A cell with production orders for this number of parts in all.
pub fn with_production_orders(name: &str, parts: u32) -> Shipped {
    supplied(name, Supply::Open, parts, PACE)
}

fn supplied(name: &str, supply: Supply<'_>, parts: u32, pace: OrderTiming) -> Shipped {
    let text = std::fs::read_to_string(file(name)).expect("it is there");
    let cell = linewright_cell::parse("cell.toml", &text, None).expect("it is sound").cell;
    let made = compile_cell(&cell, None, supply, pace).expect("it can be played");
    let (stations, table) = (cell.controllers.len(), Arc::new(made.table.clone()));
    Shipped { cell, made, table, stations, parts }
}

/// A directory in memory where there is one: thousands of logs are written, and a disk takes milliseconds to sync each time.
pub fn directory() -> TempDir {
    let memory = Path::new("/dev/shm");
    if memory.is_dir() { TempDir::new_in(memory) } else { TempDir::new() }.expect("a directory")
}

/// Work really done by stations on each part, in order, however many the same: station, task and parameters. Which
/// machine does a step that several can do depends on when, so machines are distinguished only where `told_apart`.
pub fn production(sim: &CellSim, told_apart: bool) -> Vec<Vec<String>> {
    let mut keys: BTreeMap<OrderKey, PartId> = BTreeMap::new();
    let mut of_part: BTreeMap<PartId, BTreeMap<OrderKey, String>> = BTreeMap::new();
    for (index, station) in sim.stations.iter().enumerate() {
        for done in &station.done {
            let part = done.part.expect("every order is about a part");
            assert_eq!(keys.insert(done.key, part), None, "{} was done twice", done.key);
            // Which slot is free depends on when.
            let same = done.parameters.iter().filter(|(name, _)| &**name != "slot");
            let with: Vec<String> = same.map(|(name, value)| format!(" {name} {value}")).collect();
            let (task, with) = (&done.task, with.concat());
            // `load m1` and `load m2` are the same but for the machine.
            let first = task.split(' ').next().unwrap_or_default();
            let act = if told_apart { format!("{index}: {task}{with}") } else { format!("{first}{with}") };
            of_part.entry(part).or_default().insert(done.key, act);
        }
    }
    let mut all: Vec<Vec<String>> = of_part.into_values().map(|acts| acts.into_values().collect()).collect();
    all.sort();
    all
}
