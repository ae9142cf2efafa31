//! Cost of the check of a cell: both shipped cells, one that gets stuck, one of a hundred groups, and a large one that
//! is not explored to the end.
//!
//! `cargo bench -p linewright-proof --bench cell -- --once` prints what each comes to, with the time of one run.

use std::time::Instant;

use divan::Bencher;
use linewright_cell::{Cell, parse};
use linewright_proof::cell::{CellExploration, Checked, ExplorationLimits, check};
use linewright_proof::generate::{self, CellShape};

const C1: &str = include_str!("../../launch-config/lines/workcell-c1/cell.toml");
const ASSEMBLY: &str = include_str!("../../launch-config/lines/assembly-cell/cell.toml");

fn main() {
    if std::env::args().any(|argument| argument == "--once") {
        let unreserved = C1.replace("reserve = true", "reserve = false");
        let cells = [("C1", C1), ("assembly", ASSEMBLY), ("C1 unreserved", &unreserved)];
        let cells = cells.into_iter().map(|(name, text)| (name.to_owned(), text.to_owned()));
        let large = [10, 20, 50].map(|n| (format!("{n} machines"), generate::cell(&CellShape::large(n), 1)));
        for (name, text) in cells.chain(large) {
            once(&name, &cell(&text));
        }
    } else {
        divan::main();
    }
}

fn cell(text: &str) -> Cell {
    parse("cell.toml", text, None).expect("it is sound").cell
}

fn run(cell: &Cell) -> Checked {
    check(&CellExploration {
        limits: ExplorationLimits { states: 2_000_000, ..ExplorationLimits::default() },
        ..CellExploration::new(cell)
    })
    .expect("it has a net")
}

fn once(name: &str, cell: &Cell) {
    let began = Instant::now();
    let checked = run(cell);
    let took = began.elapsed();
    println!("{name}: {took:.1?}, sound with {} parts of {}", checked.sound, cell.limits.wip_max);
    for group in &checked.groups {
        let (resources, parts, states, arcs) = (group.resources.len(), group.parts, group.states, group.arcs);
        println!("  {resources} resources with {parts} parts: {states} states, {arcs} arcs, {} bytes", group.bytes);
    }
    checked
        .properties
        .iter()
        .for_each(|property| println!("  {:?}: {}: {}", property.verdict, property.name, property.reason));
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn workcell_c1(bencher: Bencher) {
    let cell = cell(C1);
    bencher.bench(|| assert!(run(&cell).holds()));
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn assembly_cell(bencher: Bencher) {
    let cell = cell(ASSEMBLY);
    bencher.bench(|| assert!(run(&cell).holds()));
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn c1_without_reservation(bencher: Bencher) {
    let cell = cell(&C1.replace("reserve = true", "reserve = false"));
    bencher.bench(|| assert!(!run(&cell).holds()));
}
