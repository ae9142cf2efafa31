//! Cost of a whole verdict: the ring of five and of six stations, a million and fourteen million markings.
//!
//! Each run decides everything (counts, bounds, deadlocks, liveness, reversibility, home states). For scale: Spin 6.5.2
//! takes a second and more for the million and half a minute for the fourteen million, and decides of it only that
//! there is no deadlock.
//!
//! `cargo bench -p linewright-nets --bench ring -- --once 6 2` decides the ring of six stations once on two threads, to
//! be measured from outside as a process, and prints what it found, the bytes that it accounts for itself and the peak
//! memory of the process.

use divan::Bencher;
use linewright_nets::explicit::{ExplorationLimits, NetFacts, decide};

#[path = "../tests/explicit_ring/mod.rs"]
mod explicit_ring;
use explicit_ring::ring;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(at) = arguments.iter().position(|argument| argument == "--once") {
        let number = |at: usize| arguments.get(at).and_then(|n| n.parse().ok());
        let (Some(stations), Some(threads)) = (number(at + 1), number(at + 2)) else {
            eprintln!("--once needs the number of stations and the number of threads");
            std::process::exit(2);
        };
        once(stations, threads);
    } else {
        divan::main();
    }
}

fn verdict(stations: usize, threads: usize) -> NetFacts {
    let facts = decide(&ring(stations, false), &ExplorationLimits { threads, ..ExplorationLimits::default() })
        .expect("it is bounded");
    assert!(facts.deadlocks == 0 && facts.is_safe() && facts.is_live() && facts.is_reversible());
    facts
}

fn once(stations: usize, threads: usize) {
    let facts = verdict(stations, threads);
    println!("{} states, {} arcs, {} bytes, {:?}", facts.states, facts.arcs, facts.bytes, facts.storage);
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    status.lines().filter(|line| line.starts_with("VmHWM")).for_each(|line| println!("{line}"));
}

#[divan::bench(args = [1, 2], sample_count = 20, sample_size = 1)]
fn five_stations(bencher: Bencher, threads: usize) {
    bencher.bench(|| verdict(5, threads));
}

#[divan::bench(args = [1, 2], sample_count = 3, sample_size = 1)]
fn six_stations(bencher: Bencher, threads: usize) {
    bencher.bench(|| verdict(6, threads));
}
