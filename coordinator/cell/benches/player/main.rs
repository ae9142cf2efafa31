//! Cost of a firing of the token player: with and without decisions, beside a player that looks at every mode, and from 10
//! to 1,000 resources. Then the memory of a state.
//!
//! `cargo bench -p linewright-coordinator-cell --bench player [FIRINGS [RESOURCES]...]`. A firing is an activity from its
//! start to its end, with the orders of its stations, the records, and the stations played here; so many are one sample.
//! All that is compared is played in turns, so that what else the machine does hits all of it. Times are of this machine,
//! best and median.

mod bays;
#[path = "../common/dice.rs"]
mod dice;
mod floor;
mod naive;

use std::sync::Arc;
use std::time::{Duration, Instant};

use allocation_counter::{AllocationInfo, measure};
use linewright_cell::DispatchRule;
use linewright_cell::net::Supply;
use linewright_coordinator_cell::ahead::LookAhead;
use linewright_coordinator_cell::compile::{OrderTiming, compile_cell};
use linewright_coordinator_cell::dispatch::RuleDispatcher;
use linewright_coordinator_cell::production::DispatchConfiguration;
use linewright_coordinator_cell::{CellTable, DispatchDecision, Dispatcher, PlayerState, Question, Start};

use bays::bays;
use floor::Floor;
use naive::Naive;

/// Of each, so many samples.
const SAMPLES: usize = 9;
/// Longer than anything is compared for.
const NEVER: Duration = Duration::from_secs(1_000_000_000);
const RULES: [DispatchRule; 2] = [DispatchRule::ShortestProcessingTime, DispatchRule::Fifo];

/// Starts the first of what could start, one at a time.
#[derive(Clone, Copy)]
struct First;

impl Dispatcher for First {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        let part = question.parts(&question.candidates[0]).next();
        DispatchDecision { start: vec![Start { candidate: 0, part }], held: Vec::new() }
    }
}

/// The table of a cell, whose parts begin outside and come again when they have left.
fn table(resources: usize) -> Arc<CellTable> {
    let made = bays(resources);
    let parsed = linewright_cell::parse("cell.toml", &made.text, None).unwrap_or_else(|why| panic!("{why:#}"));
    assert_eq!(parsed.cell.resources.len(), resources);
    let pace = OrderTiming { repeat_interval: Duration::from_secs(1), grace: Duration::from_secs(1) };
    let table = compile_cell(&parsed.cell, None, Supply::Closed(&made.parts), pace).expect("it can be played").table;
    let mut handling = table.handling().clone();
    handling.lost_after = Some(NEVER);
    Arc::new(table.with_handling(handling))
}

fn rules(table: &CellTable, patience: Duration) -> Box<dyn Dispatcher> {
    Box::new(RuleDispatcher::new(table, &RULES, patience))
}

fn ahead(table: &CellTable, horizon: u64) -> Box<dyn Dispatcher> {
    let desk = DispatchConfiguration::without_orders(RuleDispatcher::new(table, &RULES, NEVER));
    Box::new(LookAhead::new(table, desk, Duration::from_secs(horizon)))
}

/// Something that is played, and how long its samples took, in nanoseconds for a firing.
struct Line {
    name: String,
    played: Played,
    firings: u64,
    nanos: Vec<f64>,
}

/// For each firing: number of input arcs looked at for enabling, and of allocations.
#[derive(Default)]
struct Counted {
    looks: f64,
    allocations: f64,
}

enum Played {
    Floor(Box<Floor>, Box<dyn Dispatcher>),
    Naive(Naive),
}

impl Line {
    /// Played until all parts have entered and moved on a little.
    fn new(name: impl Into<String>, table: &Arc<CellTable>, dispatcher: Box<dyn Dispatcher>, firings: u64) -> Line {
        // The dispatcher that gets them in does not matter.
        let mut floor = Floor::new(table, &mut First);
        let parts = floor.player.state().parts().len() as u64;
        floor.play(&mut First, 2 * parts);
        let mut line =
            Line { name: name.into(), played: Played::Floor(Box::new(floor), dispatcher), firings, nanos: Vec::new() };
        line.play();
        line
    }

    fn naive(table: &Arc<CellTable>, firings: u64) -> Line {
        let mut naive = Naive::new(table);
        naive.play(firings);
        Line { name: "every mode".to_owned(), played: Played::Naive(naive), firings, nanos: Vec::new() }
    }

    fn play(&mut self) {
        match &mut self.played {
            Played::Floor(floor, dispatcher) => floor.play(&mut **dispatcher, self.firings),
            Played::Naive(naive) => naive.play(self.firings),
        }
    }

    fn count(&self) -> u64 {
        match &self.played {
            Played::Floor(floor, _) => floor.firings,
            Played::Naive(naive) => naive.firings,
        }
    }

    fn sample(&mut self) {
        let (before, began) = (self.count(), Instant::now());
        self.play();
        let took = began.elapsed();
        self.nanos.push(took.as_nanos() as f64 / (self.count() - before) as f64);
    }

    /// Cost of one more sample for each firing, beside time; nothing of the peer.
    fn counted(&mut self) -> Counted {
        let firings = self.firings;
        let Played::Floor(floor, dispatcher) = &mut self.played else { return Counted::default() };
        let (before, looks) = (floor.firings, floor.player.state().enabling().looks());
        let allocations = measure(|| floor.play(&mut **dispatcher, firings)).count_total;
        let each = |count: u64| count as f64 / (floor.firings - before) as f64;
        Counted { looks: each(floor.player.state().enabling().looks() - looks), allocations: each(allocations) }
    }

    /// Best and median.
    fn nanos(&self) -> (f64, f64) {
        let mut all = self.nanos.clone();
        all.sort_unstable_by(f64::total_cmp);
        (all[0], all[all.len() / 2])
    }
}

fn samples(lines: &mut [Line]) {
    for _ in 0..SAMPLES {
        lines.iter_mut().for_each(Line::sample);
    }
}

/// The real player and its peer start the same when both take the first.
fn assert_same(table: &Arc<CellTable>) {
    let quiet = Arc::new(table.without_orders());
    let (mut floor, mut naive) = (Floor::new(&quiet, &mut First), Naive::new(&quiet));
    while floor.firings < 5_000 {
        floor.play(&mut First, 1);
    }
    naive.play(floor.firings);
    assert_eq!((floor.firings, floor.trace), (naive.firings, naive.trace));
}

fn dispatchers(firings: u64) {
    let table = table(50);
    assert_same(&table);
    let quiet = Arc::new(table.without_orders());
    let mut lines = [
        Line::naive(&quiet, firings),
        Line::new("the first, by the clock alone", &quiet, Box::new(First), firings),
        Line::new("the first", &table, Box::new(First), firings),
        Line::new("rules, nobody urgent", &table, rules(&table, NEVER), firings),
        Line::new("rules, all urgent", &table, rules(&table, Duration::ZERO), firings / 20),
        Line::new("looking ahead 60 s", &table, ahead(&table, 60), firings / 100),
    ];
    samples(&mut lines);
    println!("50 resources, 500 parts, {} modes", table.mode_count());
    println!("{:<32} {:>10} {:>10}  {:>10}  decisions records allocations", "", "best", "median", "a second");
    for line in &mut lines {
        let (best, median) = line.nanos();
        print!("{:<32} {best:>7.0} ns {median:>7.0} ns  {:>10.0}", line.name, 1e9 / median);
        if let Played::Floor(floor, dispatcher) = &mut line.played {
            let before = (floor.firings, floor.decisions, floor.records);
            let counted = measure(|| floor.play(&mut **dispatcher, line.firings));
            let each = |count: u64| count as f64 / (floor.firings - before.0) as f64;
            let (decisions, records) = (each(floor.decisions - before.1), each(floor.records - before.2));
            print!("  {decisions:>9.2} {records:>7.2} {:>11.1}", each(counted.count_total));
        }
        println!();
    }
}

fn growth(firings: u64, sizes: &[usize]) {
    println!(
        "\nnanoseconds for a firing, best and median; looks at arcs and allocations for each; bytes of a table and a state"
    );
    println!(
        "resources  parts  modes     the first         looks alloc     rules             alloc  hearing  every mode        table      state"
    );
    let tables: Vec<_> = sizes.iter().map(|&size| table(size)).collect();
    let mut lines: Vec<Line> = Vec::new();
    for table in &tables {
        lines.push(Line::new("the first", table, Box::new(First), firings));
        lines.push(Line::new("rules", table, rules(table, NEVER), firings));
        lines.push(Line::naive(&Arc::new(table.without_orders()), firings / 20));
    }
    samples(&mut lines);
    for ((resources, table), lines) in sizes.iter().zip(&tables).zip(lines.chunks_mut(3)) {
        let [first, by_rules, every] = [0, 1, 2].map(|at| lines[at].nanos());
        let (Counted { looks, allocations }, decided) = (lines[0].counted(), lines[1].counted());
        let Played::Floor(floor, _) = &mut lines[0].played else { continue };
        let hears = (0..SAMPLES).map(|_| hearing(floor)).fold(f64::INFINITY, f64::min);
        let state = floor.player.state();
        let (mut states, mut tables) = (Vec::with_capacity(1), Vec::with_capacity(1));
        let kib = |counted: AllocationInfo| format!("{:.0} KiB", counted.bytes_current as f64 / 1024.0);
        let state_kib = kib(measure(|| states.push(state.clone())));
        let table_kib = kib(measure(|| tables.push(CellTable::clone(table))));
        println!(
            "{resources:>9} {:>6} {:>6} {:>7.0} {:>7.0} {looks:>13.1} {allocations:>5.1} {:>7.0} {:>7.0} {:>13.1} {hears:>8.0} {:>8.0} {:>5.1}x {table_kib:>10} {state_kib:>10}",
            state.parts().len(),
            table.mode_count(),
            first.0,
            first.1,
            by_rules.0,
            by_rules.1,
            decided.allocations,
            every.1,
            every.1 / first.1,
        );
    }
}

/// Cost of a station's report without news.
fn hearing(floor: &mut Floor) -> f64 {
    let began = Instant::now();
    let stations = floor.hear_all(&mut First);
    began.elapsed().as_nanos() as f64 / stations as f64
}

fn peak() -> Option<String> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find(|line| line.starts_with("VmHWM")).map(|line| line.split_whitespace().skip(1).collect())
}

fn main() {
    let mut numbers = std::env::args().skip(1).filter_map(|argument| argument.parse::<usize>().ok());
    let firings = numbers.next().unwrap_or(20_000) as u64;
    let sizes: Vec<usize> = numbers.filter(|&resources| resources >= 10).collect();
    if sizes.is_empty() {
        dispatchers(firings);
        peak().into_iter().for_each(|peak| println!("peak memory of the process so far: {peak}"));
    }
    growth(firings, if sizes.is_empty() { &[10, 32, 100, 316, 1000] } else { &sizes });
    let began = Instant::now();
    let state = PlayerState::new(table(1000));
    println!("1,000 resources from text to state: {:.2?}, {} parts", began.elapsed(), state.parts().len());
}
