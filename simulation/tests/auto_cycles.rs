//! The automatic cycle without faults, compared with what the description alone promises.

use std::collections::BTreeSet;
use std::time::Duration;

use linewright_line::Line;
use linewright_simulation::{CriticalPath, LinePlan, LineSim, Network, RunEnd, RunGoal, SimOptions, run};

use crate::common::*;

fn cycles(line: &Line, options: SimOptions, count: usize) -> LineSim {
    let (sim, end) = run(line, options, &RunGoal::cycles(count)).expect("the line compiles");
    assert_eq!(end, RunEnd::Done, "{}", sim.log().tail(line, 60));
    assert_eq!((sim.record().cycles(), sim.conflicts()), (count, [].as_slice()));
    sim
}

/// Seconds per cycle over all but the first.
fn cycle_time(sim: &LineSim) -> f64 {
    let ends = sim.record().cycle_ends();
    ends[ends.len() - 1].since(ends[0]).as_secs_f64() / (ends.len() - 1) as f64
}

#[test]
fn the_cycle_time_is_the_plan_s_and_what_messages_add() {
    for machines in [1, 4] {
        let line = transfer_line(machines);
        let planned = LinePlan::of(&line).cycle_time() / 1e6;
        let sim = cycles(&line, logged(), 10);
        let simulated = cycle_time(&sim);
        // A switch is on within a thousandth of the way, so a motion may end that much early; each arrow of the path
        // takes one message.
        let path = CriticalPath::of(&line, sim.record()).expect("ten cycles are steady");
        let messages = Duration::from_millis(1).as_secs_f64() * line.arrows.len() as f64;
        assert!((planned * 0.998..=planned + messages).contains(&simulated), "{simulated} against {planned}");
        assert!((path.cycle_time_s() - simulated).abs() < 2e-6, "{} against {simulated}", path.cycle_time_s());
    }
}

#[test]
fn the_critical_path_is_the_plan_s_longest_circuit() {
    let line = transfer_line(1);
    let circuit = LinePlan::of(&line).longest_circuit().expect("the chart has circuits");
    assert_eq!((circuit.micros, circuit.cycles), (3_560_000, 1), "worked out by hand from the description");
    let sim = cycles(&line, logged(), 5);
    let path = CriticalPath::of(&line, sim.record()).expect("five cycles are steady");
    let planned: BTreeSet<_> = circuit.operations.into_iter().collect();
    let found: BTreeSet<_> = path.links.iter().map(|link| (link.motion.station, link.motion.op)).collect();
    assert_eq!(found, planned);
    // Four arrows, one message each; the rest follows in the same microsecond.
    let late: Duration = path.links.iter().map(|link| link.late).sum();
    assert_eq!(late, Duration::from_millis(4));
    let moving: Duration = path.links.iter().map(|link| link.motion.end.since(link.motion.start)).sum();
    assert_eq!(path.time, moving + late, "the path has no gaps");
}

#[test]
fn who_waits_for_whom() {
    let line = transfer_line(1);
    let sim = cycles(&line, logged(), 4);
    let arrow = |from, to| line.arrows.iter().position(|a| (a.from, a.to) == (from, to)).expect("an arrow");
    let bar = arrow(op(&line, "clamp_1", "return clamp"), op(&line, "transfer", "1st lift"));
    let wait = sim.record().waits()[bar];
    // The bar is back long before the mill has finished: from 2160 ms to 3560 ms of the chart. Once it starts from home.
    assert_eq!(wait.starts, 3);
    let mean = wait.total.as_secs_f64() / 3.0;
    assert!((1.39..1.41).contains(&mean), "{mean}");
}

#[test]
fn a_run_longer_than_its_memory_knows_when_it_began() {
    let line = transfer_line(1);
    let sim = cycles(&line, SimOptions::default(), 12_000);
    let (began, oldest) = (sim.record().began().expect("it ran"), sim.record().motions()[0].start);
    assert!(oldest > began, "the oldest motions are forgotten");
    let mean = sim.record().cycle_ends()[11_999].since(began).as_secs_f64() / 12_000.0;
    assert!((3.55..3.57).contains(&mean), "{mean}");
}

#[test]
fn a_run_follows_from_its_seed() {
    let line = transfer_line(2);
    let network = Network { jitter: Duration::from_millis(5), ..Network::default() };
    let trace = |seed| cycles(&line, SimOptions { seed, network, variation: 0.1, ..logged() }, 5).log().text(&line);
    let first = trace(1);
    assert_eq!(first, trace(1));
    assert_ne!(first, trace(2));
    let quiet = |seed| cycles(&line, SimOptions { seed, ..logged() }, 3).log().text(&line);
    assert_eq!(quiet(1), quiet(2), "where nothing is drawn, the seed is nothing");
}

#[test]
fn a_cycle_as_a_trace() {
    let line = transfer_line(1);
    insta::assert_snapshot!(cycles(&line, logged(), 1).log().text(&line));
}

#[test]
fn the_slowest_network_there_is_makes_a_line_slow_and_nothing_else() {
    let line = transfer_line(1);
    let network = Network { delay: Duration::from_secs(10), ..Network::default() };
    let sim = cycles(&line, SimOptions { network, ..logged() }, 3);
    let path = CriticalPath::of(&line, sim.record()).expect("three cycles are steady");
    let moving: Duration = path.links.iter().map(|link| link.motion.end.since(link.motion.start)).sum();
    assert_eq!(path.time, moving + Duration::from_secs(4 * 10), "four arrows, a message each");
}
