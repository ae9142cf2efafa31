//! Benefit of looking ahead and planning: makespans of random workcells by each rule, by looking ahead and by a schedule
//! that is followed, played by the token player with nominal times.
//!
//! `cargo bench -p linewright-coordinator-cell --bench makespan [CELLS [PARTS]]`. First the assembly cell beside the optimum,
//! which tests find by an exact search; then cells that are too large for one, so the best rule is what the others are
//! compared with, in percent. Times are of this machine.

#[path = "common/dice.rs"]
mod dice;

use std::fmt::Write as _;
use std::sync::Arc;
use std::time::{Duration, Instant};

use linewright_cell::net::Supply;
use linewright_cell::{Cell, DispatchRule};
use linewright_coordinator_cell::ahead::LookAhead;
use linewright_coordinator_cell::compile::{OrderTiming, compile_cell};
use linewright_coordinator_cell::dispatch::RuleDispatcher;
use linewright_coordinator_cell::production::{DispatchConfiguration, Production, ProductionOrderRequest};
use linewright_coordinator_cell::schedule::{RolloutScheduler, ScheduleFollower};
use linewright_coordinator_cell::{
    CellTable, Coordination, DispatchDecision, Dispatcher, PlayerInput, PlayerOutbox, PlayerState, Question, Record,
    RecordKind,
};
use linewright_line::Tick;

use dice::Dice;

/// No part is urgent in this comparison.
const PATIENCE: Duration = Duration::from_secs(10_000_000);
const TYPES: usize = 5;

/// A workcell by chance: machines around a store, a robot for every four of them, types whose steps have one machine or two.
fn text(seed: u64) -> String {
    let mut dice = Dice(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let machines = 6 + dice.below(4);
    let robots = machines.div_ceil(4);
    let mut out =
        String::from("name = \"random\"\ntitle = \"Random\"\n[cell]\nwip_max = 12\n[dispatch]\nrules = [\"fifo\"]\n");
    let mut add = |line: String| _ = writeln!(out, "{line}");
    add("[[resource]]\nname = \"ST\"\nprototype = \"random-access-store\"\ncapacity = 12".to_owned());
    for r in 0..robots {
        add(format!("[[resource]]\nname = \"R{r}\"\nprototype = \"robot\""));
    }
    for m in 0..machines {
        add(format!("[[resource]]\nname = \"M{m}\"\nprototype = \"machine\"\ncapacity = 1"));
        let (r, time) = (m % robots, 6 + dice.below(8));
        let sync = |name: &str, actions: String| {
            format!("[[sync]]\nname = \"{name} M{m}\"\nactions = [{actions}]\ntime_s = {time}")
        };
        add(sync("load", format!("\"ST.retrieve\", \"R{r}.pick-and-place\", \"M{m}.load\"")));
        add(sync("unload", format!("\"M{m}.unload\", \"R{r}.pick-and-place\", \"ST.store\"")));
    }
    add("[[sync]]\nname = \"enter\"\nactions = [\"outside.in\", \"ST.store\"]".to_owned());
    add("[[sync]]\nname = \"leave\"\nactions = [\"ST.retrieve\", \"outside.out\"]".to_owned());
    for kind in 0..TYPES {
        add(format!("[[part]]\nname = \"P{kind}\""));
        for step in 0..2 + dice.below(3) {
            let first = dice.below(machines);
            let other = (first + 1 + dice.below(machines - 1)) % machines;
            let mut on = format!("{{ resource = \"M{first}\", time_s = {} }}", 20 + dice.below(80));
            if dice.below(2) == 0 {
                let _ = write!(on, ", {{ resource = \"M{other}\", time_s = {} }}", 20 + dice.below(80));
            }
            add(format!("[[part.step]]\nname = \"s{step}\"\non = [{on}]"));
        }
    }
    out
}

/// Calls another one, and keeps the time.
struct Timed<'a> {
    inner: &'a mut dyn Dispatcher,
    asked: u32,
    all: Duration,
    longest: Duration,
}

impl Dispatcher for Timed<'_> {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        let begin = Instant::now();
        let answer = self.inner.decide(question);
        let took = begin.elapsed();
        (self.asked, self.all, self.longest) = (self.asked + 1, self.all + took, self.longest.max(took));
        answer
    }

    fn note(&mut self, record: &Record) {
        self.inner.note(record);
    }
}

/// The makespan in seconds, the mean and the longest time of a decision.
fn play(table: &Arc<CellTable>, dispatcher: &mut dyn Dispatcher, parts: u64) -> (f64, Duration, Duration) {
    let mut timed = Timed { inner: dispatcher, asked: 0, all: Duration::ZERO, longest: Duration::ZERO };
    let mut out = PlayerOutbox::default();
    let mut player =
        Coordination::begin(PlayerState::new(table.clone()), Tick::ZERO, 1, &mut out).expect("a first life");
    player.step(Tick::ZERO, &[PlayerInput::Starts(true)], &mut timed, &mut out);
    while let Some(at) = player.next_deadline().filter(|&at| at != Tick::NEVER) {
        player.step(at, &[], &mut timed, &mut out);
    }
    assert_eq!(player.state().left(), parts, "all is done");
    let ends = out.records.iter().filter(|record| matches!(record.fact, RecordKind::Ended { .. }));
    let end = ends.map(|record| record.at).max().unwrap_or(Tick::ZERO);
    (end.as_secs_f64(), timed.all / timed.asked.max(1), timed.longest)
}

/// Orders of so many parts of each product.
fn ordered<'a>(production: &mut Production, products: impl Iterator<Item = (&'a str, u32)>) {
    for (kind, (product, quantity)) in products.enumerate() {
        let request = ProductionOrderRequest {
            key: kind as u128,
            name: format!("order {kind}"),
            product: product.to_owned(),
            quantity,
            ..ProductionOrderRequest::default()
        };
        for change in production.submit(&[request]).expect("it is sound") {
            let record = Record { at: Tick::ZERO, fact: RecordKind::Production { change } };
            production.note(&record).expect("it fits");
        }
    }
}

fn compare(seed: u64, cell: &Cell, parts: u32) -> [f64; 3] {
    let pace = OrderTiming { repeat_interval: Duration::from_secs(1), grace: Duration::from_secs(1) };
    let made = compile_cell(cell, None, Supply::Open, pace).expect("it can be played");
    let table = Arc::new(made.table.clone());
    let mut production = Production::new(&table);
    let names: Vec<String> = (0..TYPES).map(|kind| format!("P{kind}")).collect();
    ordered(&mut production, names.iter().map(|name| (name.as_str(), parts / TYPES as u32)));
    let desk = |rules: &[DispatchRule]| {
        DispatchConfiguration::new(RuleDispatcher::new(&table, rules, PATIENCE), production.clone())
    };
    let all = u64::from(parts / TYPES as u32 * TYPES as u32);
    let rules = [DispatchRule::Fifo, DispatchRule::ShortestProcessingTime];
    let by_rules = rules.map(|rule| play(&table, &mut desk(&[rule]), all).0);
    let best = by_rules.iter().copied().fold(f64::INFINITY, f64::min);
    let mut look = LookAhead::new(&table, desk(&[DispatchRule::Fifo]), Duration::from_secs(300));
    let (ahead, mean, longest) = play(&table, &mut look, all);
    let base = LookAhead::new(&table, desk(&[DispatchRule::Schedule, DispatchRule::Fifo]), Duration::ZERO);
    let mut follower = ScheduleFollower::new(base, Box::new(RolloutScheduler::default()));
    let (followed, _, planning) = play(&table, &mut follower, all);
    println!(
        "{seed:>4} {:>6} {:>6}   {:>8.0} {:>8.0}   {ahead:>8.0} {:>+6.1} %  {:>6.2} {:>7.1}   {followed:>8.0} {:>+6.1} %  {:>8.0} {:>4}",
        table.cell_count(),
        table.mode_count(),
        by_rules[0],
        by_rules[1],
        (ahead / best - 1.0) * 100.0,
        mean.as_secs_f64() * 1e3,
        longest.as_secs_f64() * 1e3,
        (followed / best - 1.0) * 100.0,
        planning.as_secs_f64() * 1e3,
        follower.revisions().len(),
    );
    [best, ahead, followed]
}

/// The assembly cell, with room for all parts, beside the shortest makespans there are.
fn small() {
    let text = include_str!("../../../launch-config/lines/assembly-cell/cell.toml");
    let text = text.replace("wip_max = 5", "wip_max = 9").replace("capacity = 5", "capacity = 9");
    let cell = linewright_cell::parse("cell.toml", &text, None).unwrap_or_else(|why| panic!("{why:#}")).cell;
    let pace = OrderTiming { repeat_interval: Duration::from_secs(1), grace: Duration::from_secs(1) };
    let table =
        Arc::new(compile_cell(&cell, None, Supply::Open, pace).expect("it can be played").table.without_orders());
    println!("assembly cell, makespans in s\nparts      optimum    fifo     spt   ahead  schedule");
    for (counts, optimum) in [([1, 1, 1], 17.5), ([2, 2, 1], 31.0), ([2, 2, 2], 35.0), ([3, 3, 3], 52.5)] {
        let mut production = Production::new(&table);
        ordered(&mut production, ["1", "2", "3"].into_iter().zip(counts));
        let desk = |rules: &[DispatchRule]| {
            DispatchConfiguration::new(RuleDispatcher::new(&table, rules, PATIENCE), production.clone())
        };
        let all = u64::from(counts.iter().sum::<u32>());
        let [fifo, spt] = [DispatchRule::Fifo, DispatchRule::ShortestProcessingTime]
            .map(|rule| play(&table, &mut desk(&[rule]), all).0);
        let mut look = LookAhead::new(&table, desk(&[DispatchRule::Fifo]), Duration::from_secs(30));
        let ahead = play(&table, &mut look, all).0;
        let base = LookAhead::new(&table, desk(&[DispatchRule::Schedule, DispatchRule::Fifo]), Duration::ZERO);
        let followed = play(&table, &mut ScheduleFollower::new(base, Box::new(RolloutScheduler::default())), all).0;
        println!("{counts:?} {optimum:>8} {fifo:>7} {spt:>7} {ahead:>7} {followed:>9}");
    }
    println!();
}

fn main() {
    small();
    let mut numbers = std::env::args().skip(1).filter_map(|argument| argument.parse::<u32>().ok());
    let (cells, parts) = (numbers.next().unwrap_or(8), numbers.next().unwrap_or(40));
    println!("makespans in s, {parts} parts; decisions in ms; percent of the better of both rules");
    println!(
        "cell places  modes       fifo      spt      ahead          mean longest   schedule           planning  made"
    );
    let mut sums = [0.0; 3];
    for seed in 0..u64::from(cells) {
        let cell = linewright_cell::parse("cell.toml", &text(seed), None).unwrap_or_else(|why| panic!("{why:#}")).cell;
        let one = compare(seed, &cell, parts);
        sums.iter_mut().zip(one).for_each(|(sum, one)| *sum += one / f64::from(cells));
    }
    let [best, ahead, followed] = sums;
    println!(
        "mean: the better rule {best:.0} s, looking ahead {ahead:.0} s ({:+.1} %), a schedule {followed:.0} s ({:+.1} %)",
        (ahead / best - 1.0) * 100.0,
        (followed / best - 1.0) * 100.0
    );
}
