//! A fault in each of the seventeen operations, in auto, and every way back.
//!
//! ```text
//!   auto ── fault in one operation ──▶ stand-by ──▶ manual: resume, or return and redo, or go home ──▶ auto
//!             that one stops at once;                      by the station's panel
//!             the others finish what they do, and start nothing
//! ```

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::{Block, ControlMode, StationPlace};
use linewright_line::{Drive, OpId, OperationModule, Owner, StationId};
use linewright_plant::MotionFault;
use linewright_station_logic::{HappeningKind, StopCause};
use linewright_tests::{WatchedLine, transfer_line};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Recovery {
    /// Advance: the motion goes on.
    Resume,
    /// Return, then advance: taken back and done again, by the panel.
    ReturnAndRedo,
    /// Return, then auto does it again.
    ReturnAndAuto,
    /// Return along the recovery path, for an irreversible operation.
    Home,
}

/// Messages and frames from one end of the line to the other, with the mode's way there and back.
const SPREADS: Duration = Duration::from_millis(6);

fn operations() -> Vec<(String, String, bool)> {
    let line = transfer_line(1.0);
    let of = |station: &linewright_line::Station| {
        let name = station.name.clone();
        let ops = station.operations.iter().map(move |operation| {
            (name.clone(), operation.name.clone(), matches!(operation.module, OperationModule::Reversible { .. }))
        });
        ops.collect::<Vec<_>>()
    };
    line.stations.iter().flat_map(of).collect()
}

/// Runs until the operation is under way in its third cycle, and a little on.
fn reach(sim: &mut WatchedLine, station: &str, operation: &str) {
    sim.start_auto();
    let (id, op) = sim.op(station, operation);
    sim.run_until("the operation in cycle 3", |s| {
        s.controller(id).is_some_and(|c| c.cycle() == 3) && s.marking(id) == [StationPlace::operating(op)]
    });
    sim.run_for(Duration::from_millis(40));
}

fn one_stops_and_the_others_finish(sim: &mut WatchedLine, station: &str, operation: &str, fault: MotionFault) {
    let (id, op) = sim.op(station, operation);
    let others: Vec<StationId> = sim.line().station_ids().filter(|&other| other != id).collect();
    sim.fail(station, operation, fault);
    sim.run_until("the faulty operation stops", |s| s.is_incomplete(station));
    let stopped = sim.now();
    let signal = sim.line().operation((id, op)).normal.fault;
    let cause = match drive_of(sim, id, op) {
        // A drive that sticks trips over its following error: it reports that itself, to an operation with that signal.
        Some(drive) if drive.fault == signal => StopCause::Signal,
        None if fault == MotionFault::Break && signal.is_some() => StopCause::Signal,
        _ => StopCause::Watchdog,
    };
    let seen =
        sim.log().of(id).any(|(at, e)| at == stopped && e.what == HappeningKind::Stopped(op, Block::Normal, cause));
    assert!(seen, "{station}: {operation} stops with {cause:?}");
    sim.run_for(SPREADS);
    assert_eq!(sim.energised(id), 0, "its actuator is off");
    assert_eq!(sim.mode(), Some(ControlMode::StandBy));

    let running: Vec<Vec<StationPlace>> = others.iter().map(|&other| sim.marking(other)).collect();
    sim.run_for(Duration::from_secs(2));
    for (&other, before) in others.iter().zip(running) {
        let finished: Vec<StationPlace> =
            before.iter().map(|p| if p.is_operating() { StationPlace::completed(p.op) } else { *p }).collect();
        assert_eq!(sim.marking(other), finished, "{} finishes what it did", sim.line().station(other).name);
    }
    for id in sim.line().station_ids() {
        let late = |(at, e): &(linewright_line::Tick, linewright_station_logic::StationHappening)| {
            *at > stopped + SPREADS && matches!(e.what, HappeningKind::Started(..))
        };
        assert_eq!(sim.log().of(id).find(late), None, "nothing new starts");
    }
    let refusal = sim.ask(ModeCommand::Auto).expect_err("auto is refused with a fault standing");
    assert!(refusal.contains(&format!("{station}: operation incomplete")), "{refusal}");
}

fn drive_of(sim: &WatchedLine, station: StationId, op: OpId) -> Option<&Drive> {
    let axis = sim.line().operation((station, op)).motion.axis;
    let drives = sim.line().devices_of(Owner::Station(station)).filter_map(linewright_line::Device::drive);
    drives.into_iter().find(|drive| drive.axis == axis)
}

fn recover(sim: &mut WatchedLine, station: &str, operation: &str, recovery: Recovery) {
    sim.repair(station, operation);
    sim.go_manual();
    match recovery {
        Recovery::Resume => assert!(sim.jog(station, true), "resumes"),
        Recovery::ReturnAndRedo => {
            assert!(sim.jog(station, false), "returns");
            assert!(sim.jog(station, true), "redoes");
        }
        Recovery::ReturnAndAuto => assert!(sim.jog(station, false), "returns"),
        Recovery::Home => {
            assert!(sim.jog(station, false), "takes the first operation of its path back");
            assert!(sim.jog(station, false), "goes home");
            let id = sim.id(station);
            assert!(sim.controller(id).is_some_and(linewright_station_logic::Controller::is_at_home));
        }
    }
    assert!(!sim.is_incomplete(station));
    sim.back_to_auto();
}

fn scenario(station: &str, operation: &str, fault: MotionFault, recovery: Recovery, seed: u64) {
    let mut sim = WatchedLine::new(&transfer_line(1.0), seed);
    reach(&mut sim, station, operation);
    one_stops_and_the_others_finish(&mut sim, station, operation, fault);
    recover(&mut sim, station, operation, recovery);
    // Two more cycles; the record has compared every count.
    sim.makes_each_part_once(5);
    let (id, op) = sim.op(station, operation);
    assert!((5..=6).contains(&sim.done(id, op)), "{}", sim.done(id, op));
}

fn every_operation(fault: MotionFault) {
    let moved_by_drives = |station: &str| station == "mill_1";
    for (n, (station, operation, reversible)) in operations().into_iter().enumerate() {
        if fault == MotionFault::SlipBack && moved_by_drives(&station) {
            // A fault of a valve that a drive does not have.
            continue;
        }
        let ways: &[Recovery] = if reversible {
            &[Recovery::Resume, Recovery::ReturnAndRedo, Recovery::ReturnAndAuto]
        } else {
            &[Recovery::Resume, Recovery::Home]
        };
        for &recovery in ways {
            println!("{station}: {operation}: {fault:?}, {recovery:?}");
            scenario(&station, &operation, fault, recovery, n as u64);
        }
    }
}

#[test]
fn there_are_seventeen_operations() {
    assert_eq!(operations().len(), 17);
}

#[test]
fn a_motion_that_sticks_is_found_by_its_watchdog() {
    every_operation(MotionFault::Stick);
}

#[test]
fn a_motion_that_breaks_is_found_by_its_fault_signal() {
    every_operation(MotionFault::Break);
}

#[test]
fn a_motion_that_slips_back_is_found_by_its_watchdog() {
    every_operation(MotionFault::SlipBack);
}

/// The feed's fault signal is a sensor's, not its drive's.
#[test]
fn a_broken_tool_stops_the_feed() {
    let mut sim = WatchedLine::new(&transfer_line(1.0), 7);
    reach(&mut sim, "mill_1", "feed main slide");
    let (mill, feed) = sim.op("mill_1", "feed main slide");
    sim.wire(Owner::Station(mill), "tool_broken", Some(true));
    sim.run_until("the feed stops", |s| s.is_incomplete("mill_1"));
    let stopped = HappeningKind::Stopped(feed, Block::Normal, StopCause::Signal);
    assert!(sim.log().of(mill).any(|(_, event)| event.what == stopped));
    sim.run_for(SPREADS);
    assert_eq!(sim.energised(mill), 0);
    sim.wire(Owner::Station(mill), "tool_broken", Some(false));
    recover(&mut sim, "mill_1", "feed main slide", Recovery::Home);
    sim.run_until_done("mill_1", "reset main slide", 5);
}
