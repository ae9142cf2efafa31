//! The automatic cycle, when nothing goes wrong.
//!
//! ```text
//!   ms        0    480    980   1460 1660        2160              3360 3560
//!   transfer  |lifts|advance|lowers|    |return transfer|
//!   clamp_1   |                    |adv |                              |ret |
//!   mill_1                              |rapid|decel| feed |rapid ret|reset|
//! ```
//!
//! The chart above and the table below are worked out by hand from the description's durations and arrows: they are
//! what the line is measured against, so they use nothing of the code under test.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::Tick;
use linewright_line::net::{Block, ControlMode};
use linewright_station_logic::HappeningKind;
use linewright_testkit::cases::cases;
use linewright_tests::{QUIET, ROUGH, WatchedLine, transfer_line, transfer_line_with};

/// Station, operation, start and end in milliseconds after the first lift of its cycle.
const CHART: [(&str, &str, i64, i64); 17] = [
    ("clamp_1", "return clamp", -200, 0),
    ("transfer", "1st lift", 0, 120),
    ("transfer", "2nd lift", 120, 240),
    ("transfer", "3rd lift", 240, 360),
    ("transfer", "4th lift", 360, 480),
    ("transfer", "advance transfer", 480, 980),
    ("transfer", "1st lower", 980, 1100),
    ("transfer", "2nd lower", 1100, 1220),
    ("transfer", "3rd lower", 1220, 1340),
    ("transfer", "4th lower", 1340, 1460),
    ("clamp_1", "advance clamp", 1460, 1660),
    ("transfer", "return transfer", 1660, 2160),
    ("mill_1", "rapid advance positioning slide", 1660, 1960),
    ("mill_1", "decel", 1960, 2060),
    ("mill_1", "feed main slide", 2060, 2760),
    ("mill_1", "rapid return positioning slide", 2760, 3060),
    ("mill_1", "reset main slide", 3060, 3360),
];
/// From one first lift to the next: the clamp opens after the mill's reset and before the lift.
const CYCLE_MS: i64 = 3560;
/// Time that messages may add to one cycle: 16 motions in a row on the critical path, each with an output message, an
/// output frame, an input frame and an input message (at most 1.3 ms on the quiet network), and four arrows (0.5 ms).
const MESSAGES_MS: i64 = 24;
/// The first order to a drive takes it through three states before it moves: five frames each way, and no faster than its
/// inhibit time of 5 ms lets it answer. Both slides have theirs in the first cycle.
const FIRST_ORDERS_MS: i64 = 30;

#[test]
fn ten_cycles_follow_the_chart_to_the_millisecond() {
    let mut sim = WatchedLine::new(&transfer_line(1.0), 1);
    sim.start_auto();
    sim.run_until_done("mill_1", "reset main slide", 10);

    let (transfer, lift) = sim.op("transfer", "1st lift");
    let first = sim.log().of(transfer).find(|(_, e)| e.what == HappeningKind::Started(lift, Block::Normal));
    let origin = first.expect("the bar has lifted").0;
    let mut checked = 0;
    for cycle in 1..=10 {
        for (station, operation, start, end) in CHART {
            // The clamp stands open with its first cycle begun when the line is switched on.
            if cycle == 1 && operation == "return clamp" {
                continue;
            }
            let (id, op) = sim.op(station, operation);
            let times = |what: HappeningKind| -> Vec<Tick> {
                sim.log().of(id).filter(|(_, e)| e.what == what && e.cycle == cycle).map(|(at, _)| at).collect()
            };
            let started = times(HappeningKind::Started(op, Block::Normal));
            let done = times(HappeningKind::Completed(op, Block::Normal));
            for (times, due, what) in [(started, start, "starts"), (done, end, "is done")] {
                assert_eq!(times.len(), 1, "{station}: {operation} {what} once in cycle {cycle}");
                let at = times[0].as_micros() as i64 - origin.as_micros() as i64;
                let due = (i64::from(cycle) - 1) * CYCLE_MS + due;
                let late = at / 1000 - due;
                // A switch is on within a thousandth of the way, so a motion may end that much early.
                assert!(
                    (-4 * i64::from(cycle)..=MESSAGES_MS * i64::from(cycle) + FIRST_ORDERS_MS).contains(&late),
                    "{station}: {operation} {what} {late} ms late in cycle {cycle}"
                );
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 10 * 34 - 2);
    // Nothing else happened: no operation out of the chart, none undone.
    let starts: usize = sim
        .line()
        .station_ids()
        .map(|id| sim.log().of(id).filter(|(_, e)| matches!(e.what, HappeningKind::Started(..))).count())
        .sum();
    assert!((169..=171).contains(&starts), "{starts} starts: ten cycles, and perhaps the clamp of the eleventh");
    for part in 1..=10 {
        assert_eq!(sim.observer().machined(1, part), 1, "part {part} is machined once");
    }
}

#[test]
fn a_rough_network_costs_time_and_perhaps_an_operators_help() {
    let mut sim = WatchedLine::with(&transfer_line_with(2, 0.5), 3, ROUGH, 0.2);
    sim.start_auto();
    for cycle in [6, 12, 18, 24] {
        sim.patiently_until_done("mill_2", "reset main slide", cycle);
    }
    for part in 1..=23 {
        assert_eq!((sim.observer().machined(1, part), sim.observer().machined(2, part)), (1, 1));
    }
}

#[test]
fn master_stop_halts_every_station_at_home_and_start_and_auto_go_on() {
    // At any moment of the cycle, on a network that loses messages too.
    for (moment, network) in (0..36).map(|n| (n * 100, if n % 2 == 0 { QUIET } else { ROUGH })) {
        let mut sim = WatchedLine::with(&transfer_line(1.0), moment, network, 0.0);
        sim.start_auto();
        sim.run_until_done("transfer", "1st lift", 2);
        sim.run_for(Duration::from_millis(moment));
        sim.order(ModeCommand::Stop);
        sim.run_until("the line is home", |s| s.mode() == Some(ControlMode::Home));
        assert!(sim.all_home(), "moment {moment}");
        let positions = sim.positions();
        sim.settle();
        assert_eq!(positions, sim.positions(), "and nothing moves any more");

        sim.order(ModeCommand::Start);
        sim.order(ModeCommand::Auto);
        let reached = sim.observer().places();
        sim.run_until("two more parts", |s| s.observer().places() == reached + 2);
        for part in 1..reached {
            assert_eq!(sim.observer().machined(1, part), 1);
        }
    }
}

/// In the moment in which all are at home and the next round begins, one station has begun it and another has not
/// received that.
#[test]
fn master_stop_just_as_the_next_round_begins() {
    for seed in 0..3 {
        for micros in (0..2400).step_by((2400 / cases(40)).max(1) as usize) {
            let mut sim = WatchedLine::new(&transfer_line(1.0), seed);
            sim.start_auto();
            sim.run_until_done("clamp_1", "return clamp", 2);
            sim.run_for(Duration::from_micros(micros));
            sim.order(ModeCommand::Stop);
            sim.run_until("the line is home", |s| s.mode() == Some(ControlMode::Home));
            assert!(sim.all_home(), "{micros} us, seed {seed}");
            sim.settle();
            assert!(sim.all_home(), "{micros} us, seed {seed}: and stays there");
            sim.order(ModeCommand::Start);
            sim.order(ModeCommand::Auto);
            sim.run_until_done("mill_1", "reset main slide", 3);
        }
    }
}

#[test]
fn a_stop_taken_back_by_start_costs_nothing() {
    let mut sim = WatchedLine::new(&transfer_line(1.0), 5);
    sim.start_auto();
    sim.run_until_done("transfer", "1st lift", 2);
    sim.order(ModeCommand::Stop);
    sim.run_for(Duration::from_millis(200));
    sim.order(ModeCommand::Start);
    sim.run_until_done("mill_1", "reset main slide", 5);
    assert_eq!(sim.mode(), Some(ControlMode::Auto));
}
