//! Manual mode: people at the stations' own panels, alone and together.
//!
//! ```text
//!   operator A ── advance/return ──▶ transfer ◀── agree? ──▶ clamp_1 ◀── agree? ──▶ mill_1
//!   operator B ── advance/return ────────────────────▶┘                              ▲
//!   operator C ── advance/return ─────────────────────────────────────────────────────┘
//! ```
//!
//! The seeds of the three-operator test are many; `LINEWRIGHT_CASES=5000 cargo test --release -p linewright-tests` runs
//! fifty times as many.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::StationId;
use linewright_line::net::{ControlMode, StationPlace};
use linewright_plant::MotionFault;
use linewright_station_logic::HappeningKind;
use linewright_testkit::cases::cases;
use linewright_tests::{QUIET, Rng, WatchedLine, network, transfer_line};

/// Breaks the mill's feed in its second cycle, repairs it, and enters manual.
fn mill_broken_in_its_feed() -> WatchedLine {
    let mut sim = WatchedLine::new(&transfer_line(1.0), 1);
    sim.start_auto();
    let (mill, feed) = sim.op("mill_1", "feed main slide");
    sim.run_until("the feed in cycle 2", |s| {
        s.controller(mill).is_some_and(|c| c.cycle() == 2) && s.marking(mill) == [StationPlace::operating(feed)]
    });
    sim.run_for(Duration::from_millis(300));
    sim.fail("mill_1", "feed main slide", MotionFault::Break);
    sim.run_until("the mill stops", |s| s.is_incomplete("mill_1"));
    sim.repair("mill_1", "feed main slide");
    sim.go_manual();
    sim
}

#[test]
fn a_mill_sent_home_does_not_release_the_clamp_before_the_part_is_machined() {
    let mut sim = mill_broken_in_its_feed();
    let clamp = sim.id("clamp_1");
    assert!(!sim.jog("clamp_1", false), "the clamp does not open under the tool");
    assert!(sim.blocked_by(clamp).join("; ").contains("mill_1"), "{:?}", sim.blocked_by(clamp));
    assert!(sim.jog("mill_1", false) && sim.jog("mill_1", false), "the mill goes home");
    assert!(sim.log().of(sim.id("mill_1")).any(|(_, e)| e.what == HappeningKind::HomeAgain));
    assert_eq!(sim.observer().machined(1, 2), 0, "the second part has not been machined");

    assert!(!sim.jog("clamp_1", true), "the clamp does not go on to its next cycle");
    let reasons = sim.blocked_by(clamp).join("; ");
    assert!(reasons.contains("mill_1: reset main slide (cycle 2)"), "{reasons}");

    sim.back_to_auto();
    sim.run_until_done("clamp_1", "return clamp", 3);
    assert_eq!(sim.observer().machined(1, 2), 1, "machined first, then released");
}

#[test]
fn a_mill_sent_home_and_its_clamp_opened_by_hand_closes_it_again_before_machining() {
    let mut sim = mill_broken_in_its_feed();
    assert!(sim.jog("mill_1", false) && sim.jog("mill_1", false), "the mill goes home");
    assert!(!sim.jog("clamp_1", false), "the bar has run back on the strength of the closed clamp");
    let reasons = sim.blocked_by(sim.id("clamp_1")).join("; ");
    assert!(reasons.contains("transfer, return transfer has started"), "{reasons}");
    assert!(sim.jog("transfer", false), "so the bar goes over again first");
    assert!(sim.jog("clamp_1", false), "and the clamp is taken back: the tool is home");
    assert!(!sim.jog("mill_1", true), "no tool on an open clamp");
    sim.back_to_auto();
    sim.run_until_done("mill_1", "reset main slide", 4);
    assert_eq!((sim.observer().machined(1, 2), sim.observer().machined(1, 3)), (1, 1));
}

#[test]
fn a_bar_under_a_closed_clamp_does_not_go_back_up() {
    let mut sim = WatchedLine::new(&transfer_line(1.0), 2);
    sim.start_auto();
    let (clamp, advance) = sim.op("clamp_1", "advance clamp");
    sim.run_until("the clamp closes in cycle 2", |s| {
        s.controller(clamp).is_some_and(|c| c.cycle() == 2) && s.marking(clamp) == [StationPlace::operating(advance)]
    });
    sim.selector("transfer", true);
    let transfer = sim.id("transfer");
    sim.run_until("manual", |s| s.mode_of(transfer) == Some(ControlMode::Manual));
    // The clamp has finished closing; the bar has not begun to run back.
    assert!(!sim.jog("transfer", false), "it does not lift");
    let reasons = sim.blocked_by(transfer).join("; ");
    assert!(reasons.contains("interlock: clamp_1 not clear: LS_open"), "{reasons}");
    sim.selector("transfer", false);
    sim.run_for(Duration::from_millis(200));
    sim.back_to_auto();
    sim.run_until_done("mill_1", "reset main slide", 4);
}

/// Presses and releases at random, one finger for each button, until `end`.
fn fidget(sim: &mut WatchedLine, rng: &mut Rng, stations: &[StationId], presses: u32) {
    for _ in 0..presses {
        let &station = rng.pick(stations);
        let advance = rng.chance(500);
        match rng.below(5) {
            0 => {
                sim.release(station, true);
                sim.release(station, false);
            }
            1 | 2 => {
                // Off and on again: a new press.
                sim.release(station, !advance);
                sim.release(station, advance);
                sim.run_for(Duration::from_micros(rng.within(100, 30_000)));
                sim.press(station, advance);
            }
            _ => sim.press(station, advance),
        }
        sim.run_for(Duration::from_micros(rng.within(100, 60_000)));
    }
}

fn three_operators(seed: u64, late_images: bool) {
    let mut rng = Rng::new(seed);
    let longest = *rng.pick(&[500, 5_000, 40_000, 150_000]);
    let rough = network((50, longest), *rng.pick(&[0, 0, 100]), 50);
    let mut sim = WatchedLine::with(&transfer_line(0.1), seed, QUIET, 0.1);
    sim.start_auto();
    sim.run_for(Duration::from_millis(rng.within(0, 400)));
    sim.command(ModeCommand::EStop);
    sim.run_for(Duration::from_millis(20));
    sim.order(ModeCommand::Reset);
    sim.go_manual();
    sim.networks(rough, if late_images { rough } else { QUIET });
    let stations: Vec<StationId> = sim.line().station_ids().collect();
    fidget(&mut sim, &mut rng, &stations, 40);
    for &station in &stations {
        sim.release(station, true);
        sim.release(station, false);
    }
}

#[test]
fn three_operators_at_three_panels_at_once() {
    if let Some(seed) = std::env::var("LINEWRIGHT_SEED").ok().and_then(|seed| seed.parse().ok()) {
        return three_operators(seed, seed % 2 == 1);
    }
    for seed in 0..cases(350) {
        three_operators(seed, seed % 2 == 1);
    }
}
