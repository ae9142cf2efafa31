//! Processes die, at any moment of a cycle, and come back.
//!
//! ```text
//!   transfer    ──── ✝ ·····(down)····· restart from its journal ──▶ looked at ──▶ auto
//!   coordinator ──── seconds later: transfer is silent ──▶ stand-by
//!   clamp_1     ──── finishes what it does, starts nothing
//! ```

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{StationId, Tick};
use linewright_station_logic::HappeningKind;
use linewright_tests::{NodeProcess, WatchedLine, moments};

const STATIONS: [&str; 3] = ["transfer", "clamp_1", "mill_1"];

/// The first motion that started after `since`, if any.
fn started_after(sim: &WatchedLine, since: Tick) -> Option<(StationId, Tick, String)> {
    sim.line().station_ids().find_map(|id| {
        let mut late = sim.log().of(id).filter(|(at, e)| *at > since && matches!(e.what, HappeningKind::Started(..)));
        late.next().map(|(at, e)| (id, at, e.text(sim.line(), id)))
    })
}

#[test]
fn a_station_killed_at_any_moment_and_restarted_from_its_journal() {
    for moment in moments(0, 210) {
        for station in STATIONS {
            let mut sim = WatchedLine::in_second_cycle(moment, moment);
            let id = sim.id(station);
            let timing = sim.line().timing;
            sim.kill_station(id);
            let killed = sim.now();
            sim.run_for(Duration::from_secs(3));
            let quiet = killed + timing.lease;
            assert_eq!(started_after(&sim, quiet), None, "{station} killed at {moment} ms");
            assert!(!sim.anything_energised());
            assert_eq!(sim.mode(), Some(ControlMode::StandBy));
            let refusal = sim.ask(ModeCommand::Auto).expect_err("a station is missing");
            assert!(refusal.contains(&format!("{station}: no state received")), "{refusal}");

            sim.restart_station(id);
            sim.settle();
            assert!(started_after(&sim, quiet).is_none(), "its return starts nothing");
            sim.bring_back();
            sim.makes_each_part_once(4);
        }
    }
}

#[test]
fn a_station_that_dies_between_its_record_and_its_word() {
    for moment in moments(0, 220) {
        for station in STATIONS {
            let mut sim = WatchedLine::in_second_cycle(moment, moment + 1);
            let id = sim.id(station);
            sim.kill_station_at_its_next_record(id);
            sim.run_until("it dies", |s| !s.is_running(id));
            // Restarted at once by its supervisor: before it is missed.
            sim.run_for(Duration::from_millis(20));
            sim.restart_station(id);
            sim.bring_back();
            sim.makes_each_part_once(4);
        }
    }
}

#[test]
fn a_station_restarted_sooner_than_it_is_missed_stops_auto_all_the_same() {
    for moment in moments(0, 200) {
        for station in STATIONS {
            let mut sim = WatchedLine::in_second_cycle(moment, moment);
            let id = sim.id(station);
            sim.kill_station(id);
            let killed = sim.now();
            sim.run_for(Duration::from_millis(20));
            sim.restart_station(id);
            // Its new life counts once the old one has been silent for as long as a view lasts.
            let believed = killed + sim.line().timing.stale;
            sim.settle();
            assert_eq!(sim.mode(), Some(ControlMode::StandBy));
            assert_eq!(started_after(&sim, believed + Duration::from_millis(6)), None);
            let refusal = sim.ask(ModeCommand::Auto).expect_err("nobody has looked at it");
            // Where only manual leads on, that is the reason: *start* leads nowhere before.
            let reason = if sim.is_incomplete(station) { "operation incomplete" } else { "restarted" };
            assert!(refusal.contains(&format!("{station}: {reason}")), "{refusal}");
            if sim.is_incomplete(station) {
                sim.bring_back();
            } else {
                // It stood still: a person's word is enough.
                sim.order(ModeCommand::Start);
                sim.order(ModeCommand::Auto);
            }
            sim.makes_each_part_once(4);
        }
    }
}

#[test]
fn a_coordinator_killed_at_any_moment_and_replaced() {
    for moment in moments(0, 300) {
        for (remembers, down) in [(true, 30), (false, 30), (true, 300), (false, 2000)] {
            let mut sim = WatchedLine::in_second_cycle(moment, moment);
            let before = sim.epoch();
            let timing = sim.line().timing;
            sim.kill_coordinator();
            let killed = sim.now();
            sim.run_for(Duration::from_millis(down));
            sim.restart_coordinator(remembers);
            sim.run_to(killed + Duration::from_secs(4));
            let quiet = killed + timing.lease;
            assert_eq!(started_after(&sim, quiet), None, "at {moment} ms, remembers {remembers}, down {down} ms");
            assert!(sim.epoch() > before, "its epochs are above all before it");
            assert_ne!(sim.mode(), Some(ControlMode::Auto), "nobody has asked for auto");
            sim.bring_back();
            sim.makes_each_part_once(4);
        }
    }
}

#[test]
fn a_station_cut_off_from_the_coordinator_but_not_from_its_neighbours() {
    for moment in moments(0, 340) {
        for (station, back_too) in STATIONS.into_iter().flat_map(|s| [(s, false), (s, true)]) {
            let mut sim = WatchedLine::in_second_cycle(moment, moment);
            let id = sim.id(station);
            let timing = sim.line().timing;
            sim.cut(NodeProcess::Coordinator, NodeProcess::Station(id));
            if back_too {
                sim.cut(NodeProcess::Station(id), NodeProcess::Coordinator);
            }
            let cut = sim.now();
            sim.run_for(Duration::from_secs(3));
            // Its images are cut as well, so its devices count as lost: that stops the line.
            let quiet = cut + timing.lease + timing.stale;
            assert_eq!(started_after(&sim, quiet), None, "{station} cut off at {moment} ms");
            sim.heal();
            sim.bring_back();
            sim.makes_each_part_once(4);
        }
    }
}

#[test]
fn neighbours_that_do_not_hear_each_other_wait_and_go_on_when_they_do() {
    for moment in moments(0, 120) {
        let mut sim = WatchedLine::in_second_cycle(moment, moment);
        let (transfer, clamp) = (sim.id("transfer"), sim.id("clamp_1"));
        sim.cut(NodeProcess::Station(transfer), NodeProcess::Station(clamp));
        sim.cut(NodeProcess::Station(clamp), NodeProcess::Station(transfer));
        sim.run_for(Duration::from_secs(5));
        assert_eq!(sim.mode(), Some(ControlMode::Auto), "nothing is wrong with any of them");
        assert!(!sim.anything_energised(), "but none goes on");
        let heard = sim.blocked_by(clamp).iter().chain(&sim.blocked_by(transfer)).any(|r| r.contains("the state of "));
        assert!(heard, "and each says why");
        sim.heal();
        sim.makes_each_part_once(4);
    }
}
