//! Emergency stop, at every moment of a cycle.
//!
//! ```text
//!   auto ──▶ e-stop: every output off ──▶ reset ──▶ (still e-stop) ──▶ manual ──▶ auto
//!                    start, auto, hand refused        only manual leads out
//! ```

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::Owner;
use linewright_line::net::ControlMode;
use linewright_tests::{WatchedLine, moments, transfer_line};

/// Order to the stations, their images to the gateway, the gateway's frames to the devices: at most 0.5 + 0.5 + 0.15
/// milliseconds on the quiet network; a wired button adds its own frame.
const OFF_WITHIN: Duration = Duration::from_millis(2);

/// A slide on a drive brakes instead of standing at once: from 370 mm/s at 30 m/s².
const BRAKES_WITHIN: Duration = Duration::from_millis(20);

fn stop_and_come_back(moment: Duration, by_wire: bool) {
    let mut sim = WatchedLine::new(&transfer_line(1.0), moment.as_millis() as u64);
    sim.start_auto();
    sim.run_until_done("clamp_1", "return clamp", 2);
    sim.run_for(moment);
    if by_wire {
        sim.wire(Owner::Console, "ES_pressed", Some(true));
    } else {
        sim.command(ModeCommand::EStop);
    }
    sim.run_for(OFF_WITHIN);
    assert!(!sim.anything_energised(), "every output is off at {moment:?}");
    assert_eq!(sim.mode(), Some(ControlMode::EStop));
    sim.run_for(BRAKES_WITHIN);
    let stands = sim.positions();
    for command in [ModeCommand::Start, ModeCommand::Stop, ModeCommand::Auto, ModeCommand::Hand, ModeCommand::Manual] {
        let refusal = sim.ask(command).expect_err("the emergency stop is on");
        assert!(refusal.contains("emergency stop"), "{refusal}");
    }
    if by_wire {
        let refusal = sim.ask(ModeCommand::Reset).expect_err("its button is still in");
        assert!(refusal.contains("release it first"), "{refusal}");
        sim.wire(Owner::Console, "ES_pressed", None);
        sim.run_for(Duration::from_millis(50));
        assert_eq!(sim.mode(), Some(ControlMode::EStop), "pulling it out resets nothing");
    }
    sim.settle();
    assert_eq!(sim.positions(), stands, "nothing moves");
    sim.order(ModeCommand::Reset);
    assert_eq!(sim.mode(), Some(ControlMode::EStop), "only manual leads out");
    sim.settle();
    assert_eq!(sim.positions(), stands, "and a reset moves nothing");
    assert!(sim.ask(ModeCommand::Auto).is_err() && sim.ask(ModeCommand::Hand).is_err());

    sim.bring_back();
    sim.makes_each_part_once(4);
}

/// About every 60 ms and every 90 ms; with `LINEWRIGHT_CASES=300` every 20 ms and every 30 ms.
#[test]
fn at_every_moment_of_a_cycle_by_message_and_by_wire() {
    for (first, every, by_wire) in [(0, 60, false), (10, 90, true)] {
        for moment in moments(first, every) {
            stop_and_come_back(Duration::from_millis(moment), by_wire);
        }
    }
}

/// A successor that has lost its journal adopts the stop from the stations that are in it.
#[test]
fn an_emergency_stop_outlives_the_coordinator_that_gave_it() {
    for remembers in [true, false] {
        let mut sim = WatchedLine::new(&transfer_line(1.0), 4);
        sim.start_auto();
        sim.run_until_done("transfer", "advance transfer", 2);
        sim.order(ModeCommand::EStop);
        sim.run_for(Duration::from_millis(100));
        sim.kill_coordinator();
        sim.run_for(Duration::from_secs(2));
        for id in sim.line().station_ids() {
            assert_eq!(sim.mode_of(id), Some(ControlMode::EStop), "no lease ends it");
        }
        sim.restart_coordinator(remembers);
        sim.settle();
        assert!(!sim.anything_energised());
        let stands = sim.positions();
        sim.settle();
        assert_eq!(sim.positions(), stands);
        assert_eq!(sim.mode(), Some(ControlMode::EStop), "remembers {remembers}");
        assert!(sim.ask(ModeCommand::Auto).expect_err("stopped").contains("emergency stop"));
        sim.bring_back();
        sim.run_until_done("mill_1", "reset main slide", 3);
    }
}

#[test]
fn replacing_the_coordinator_is_no_way_out_of_an_emergency_stop() {
    for reset in [false, true] {
        let mut sim = WatchedLine::new(&transfer_line(1.0), 2);
        sim.start();
        sim.order(ModeCommand::EStop);
        if reset {
            sim.order(ModeCommand::Reset);
        }
        sim.run_for(Duration::from_millis(100));
        sim.kill_coordinator();
        sim.restart_coordinator(true);
        sim.settle();
        assert!(sim.ask(ModeCommand::Start).is_err() && sim.ask(ModeCommand::Auto).is_err());
        assert_eq!(sim.mode(), Some(ControlMode::EStop));
        sim.order(ModeCommand::Reset);
        sim.go_manual();
        sim.back_to_auto();
        sim.run_until_done("mill_1", "reset main slide", 2);
    }
}
