//! Line cycles a second, in virtual time.
//!
//! One iteration is a whole run: compile the line, switch on, start, auto, and so many cycles. The throughput divan
//! shows is line cycles a second.

use divan::Bencher;
use divan::counter::ItemsCount;
use linewright_line::{Line, TransferLine, parse};
use linewright_simulation::{Network, RunEnd, RunGoal, SimOptions, run};

fn main() {
    divan::main();
}

const CYCLES: usize = 1000;

fn line(machines: usize) -> Line {
    let text = TransferLine { machines, time_scale: 1.0 }.text();
    parse("line.toml", &text).unwrap_or_else(|problems| panic!("{problems:?}")).line
}

fn bench(bencher: Bencher, machines: usize, options: SimOptions) {
    let line = line(machines);
    let goal = RunGoal::cycles(CYCLES);
    bencher.counter(ItemsCount::new(CYCLES)).bench_local(|| {
        let (sim, end) = run(&line, options, &goal).expect("the line compiles");
        assert_eq!(end, RunEnd::Done);
        sim.events()
    });
}

/// The transfer line with so many machines: three stations, nine, seventeen.
#[divan::bench(args = [1, 4, 8], sample_count = 10, sample_size = 1)]
fn transfer_line(bencher: Bencher, machines: usize) {
    bench(bencher, machines, SimOptions::default());
}

/// The same with random delays and motions.
#[divan::bench(args = [1, 4], sample_count = 10, sample_size = 1)]
fn with_jitter(bencher: Bencher, machines: usize) {
    let network = Network { jitter: std::time::Duration::from_millis(2), ..Network::default() };
    bench(bencher, machines, SimOptions { network, variation: 0.05, ..SimOptions::default() });
}

/// The same with every message waking its reader.
#[divan::bench(sample_count = 10, sample_size = 1)]
fn one_by_one(bencher: Bencher) {
    bench(bencher, 1, SimOptions { one_by_one: true, ..SimOptions::default() });
}
