//! A station comes back without its memory, at any moment of a cycle, and so do counts and positions.
//!
//! ```text
//!   clamp_1     ──── ✝ ···(down)··· restart without its journal ──▶ moves only where it is measured to be safe
//!   the others  ──── trouble: no memory of common counts ──▶ stand-by ──▶ manual, all home ──▶ auto
//! ```
//!
//! That no mechanism meets another is what the observer of every simulation here looks at, by positions alone.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::StationId;
use linewright_line::net::{ControlMode, StationPlace};
use linewright_tests::{WatchedLine, moments, transfer_line};

const STATIONS: [&str; 3] = ["transfer", "clamp_1", "mill_1"];

/// The station is killed and comes back without its journal; gives the place it stood in.
fn lose_memory(sim: &mut WatchedLine, station: StationId) -> StationPlace {
    let place = sim.marking(station)[0];
    sim.kill_station(station);
    sim.run_for(Duration::from_secs(2));
    sim.restart_station_without_memory(station);
    sim.run_until("everything is heard", WatchedLine::all_heard);
    sim.run_for(Duration::from_millis(300));
    place
}

/// The documented way back: confirm where the station stands, lead all stations home in manual, give auto.
fn lead_home(sim: &mut WatchedLine, lost: StationId, stood: StationPlace) {
    if sim.mode() != Some(ControlMode::Manual) {
        sim.go_manual();
    }
    let asks = |sim: &WatchedLine| sim.blocked_by(lost).iter().any(|reason| reason.contains("confirm it with rejoin"));
    let is_home = |sim: &WatchedLine, id: StationId| sim.controller(id).is_some_and(|c| c.is_at_home());
    if !is_home(sim, lost) {
        let within = (!asks(sim)).then_some(stood.op);
        sim.rejoin(lost, within);
        sim.run_for(Duration::from_millis(100));
    }
    sim.lead_home();
}

#[test]
fn a_station_without_its_memory_meets_nobody_and_is_led_back() {
    for moment in moments(0, 260) {
        for station in STATIONS {
            let mut sim = WatchedLine::in_second_cycle(moment, moment);
            let id = sim.id(station);
            let stood = lose_memory(&mut sim, id);
            let refusal = sim.ask(ModeCommand::Auto).expect_err("it has no memory of common counts");
            assert!(refusal.contains(station), "{station} at {moment} ms: {refusal}");
            lead_home(&mut sim, id, stood);
            sim.back_to_auto();
            sim.run_until_done("mill_1", "reset main slide", 2);
        }
    }
}

#[test]
fn start_and_auto_find_a_switch_that_contradicts_the_marking() {
    let mut sim = WatchedLine::new(&transfer_line(1.0), 1);
    sim.run_until("everything is heard", WatchedLine::all_heard);
    sim.wire(linewright_line::Owner::Station(StationId(1)), "LS_open", Some(false));
    sim.run_for(Duration::from_millis(300));
    let _ = sim.ask(ModeCommand::Start);
    let refusal = sim.ask(ModeCommand::Auto).expect_err("the clamp is not measured open");
    assert!(refusal.contains("clamp_1: position lost"), "{refusal}");
    assert!(sim.fault(StationId(1)).contains("LS_open"), "{}", sim.fault(StationId(1)));
    sim.wire(linewright_line::Owner::Station(StationId(1)), "LS_open", None);
    sim.run_for(Duration::from_millis(300));
    sim.order(ModeCommand::Auto);
    sim.run_until_done("mill_1", "reset main slide", 1);
}

#[test]
fn a_closed_clamp_whose_switch_goes_off_stops_the_mill() {
    let mut sim = WatchedLine::new(&transfer_line(1.0), 1);
    sim.start_auto();
    sim.run_until_done("mill_1", "decel", 1);
    sim.run_for(Duration::from_millis(100));
    sim.wire(linewright_line::Owner::Station(StationId(1)), "LS_closed", Some(false));
    sim.run_for(Duration::from_millis(100));
    assert!(sim.is_incomplete("mill_1"), "the feed is stopped");
    assert!(sim.fault(StationId(2)).contains("interlock: clamp_1 not clear: LS_closed"), "{}", sim.fault(StationId(2)));
    assert!(sim.fault(StationId(1)).contains("position lost"), "{}", sim.fault(StationId(1)));
    assert_eq!(sim.mode(), Some(ControlMode::StandBy));
    sim.wire(linewright_line::Owner::Station(StationId(1)), "LS_closed", None);
    sim.bring_back();
    sim.run_until_done("mill_1", "reset main slide", 2);
}
