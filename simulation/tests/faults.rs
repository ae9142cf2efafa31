//! Faults, their effect on the line, and how people bring it back.

use std::time::Duration;

use linewright_line::net::{Block, ControlMode};
use linewright_line::{StationId, Tick};
use linewright_simulation::{LineSim, LogKind, NodeProcess, OperatorAction, RunEnd, RunGoal, run};
use linewright_station_logic::{HappeningKind, Rules, StopCause};

use crate::common::*;

const MILL: StationId = StationId(2);

#[test]
fn a_jam_in_auto_stops_one_and_lets_the_others_finish_then_a_person_goes_on() {
    let shipped = include_str!("../../launch-config/lines/transfer-line/scenarios/jammed-clamp.toml");
    let sim = played(shipped);
    assert_eq!(sim.record().cycles(), 4);
    let (clamp, advance) = op(sim.line(), "clamp_1", "advance clamp");
    let faults = sim.record().faults();
    assert_eq!(faults.len(), 1);
    assert_eq!((faults[0].station, faults[0].op, faults[0].cause), (clamp, advance, StopCause::Watchdog));
    let stopped = |entry: &linewright_simulation::SimLogEntry| matches!(entry.what, LogKind::Station(id, event) if id != clamp && matches!(event.what, HappeningKind::Stopped(..)));
    assert!(!sim.log().entries().iter().any(stopped), "nobody else stops half-way");
    let modes = sim.log().modes();
    use ControlMode::{Auto, Manual, StandBy};
    assert_eq!(modes, [StandBy, Auto, StandBy, Manual, StandBy, Auto]);
}

#[test]
fn auto_is_refused_while_a_station_is_half_way_along_its_recovery_path() {
    let (sim, end) = play(
        r#"
        cycles = 3
        [[step]]
        when = "cycles >= 1 and mill_1: feed main slide is operating"
        after_s = 0.3
        break = "mill_1: feed main slide"
        [[step]]
        when = "line is stand-by and all are stopped"
        clear = "mill_1: feed main slide"
        [[step]]
        command = "manual"
        [[step]]
        when = "all obey manual"
        jog = "mill_1: return"
        [[step]]
        command = "auto"
        "#,
    );
    // The command is given again and again, and refused: nothing would lead the mill home in auto.
    let log = sim.log().tail(sim.line(), 5);
    assert_ne!(end, RunEnd::Done, "{log}");
    assert!(log.contains("auto refused in manual: mill_1: operation incomplete"), "{log}");
}

#[test]
fn a_lost_device_stops_its_station_after_its_heartbeat_s_time() {
    let sim = played(
        r#"
        cycles = 2
        [[step]]
        when = "mill_1: feed main slide is operating"
        after_s = 0.1
        device_lost = "mill 1 io"
        [[step]]
        when = "mill_1 is incomplete and line is stand-by"
        after_s = 1
        device_back = "mill 1 io"
        [[step]]
        when = "all are heard and all are stopped"
        command = "manual"
        [[step]]
        when = "all obey manual"
        jog = "mill_1: advance"
        [[step]]
        command = "auto"
        "#,
    );
    let entries = sim.log().entries();
    let lost = entries.iter().find(|e| matches!(&e.what, LogKind::Act(text) if text == "mill 1 io lost")).unwrap().at;
    let noticed = |e: &&linewright_simulation::SimLogEntry| matches!(e.what, LogKind::Station(MILL, event) if event.what == HappeningKind::Devices(false));
    let noticed = entries.iter().find(noticed).unwrap().at;
    assert_eq!(noticed.since(lost), sim.line().timing.heartbeat_timeout);
    assert_eq!(sim.record().faults()[0].cause, StopCause::Devices);
}

/// It starts, and its loss is noticed, in one microsecond.
#[test]
fn a_loss_is_noticed_though_its_station_acts_at_the_same_moment() {
    let line = transfer_line(1);
    let (clamp, advance) = op(&line, "clamp_1", "advance clamp");
    let started = |sim: &LineSim| {
        let mut starts =
            sim.log().of(clamp).filter(|(_, event)| event.what == HappeningKind::Started(advance, Block::Normal));
        starts.nth(1).map(|(at, _)| at)
    };
    let (sim, _) = run(&line, logged(), &RunGoal::cycles(3)).unwrap();
    let at = started(&sim).expect("it starts in every cycle");
    let mut sim = LineSim::new(&line, logged()).unwrap();
    assert_eq!(sim.run(&RunGoal::cycles(1)), RunEnd::Done);
    sim.run_to(Tick::from_micros(at.as_micros() - line.timing.heartbeat_timeout.as_micros() as u64));
    let device = line.devices.iter().position(|device| device.name == "clamp 1 io").expect("it is there");
    sim.act(OperatorAction::Device(device, true)).unwrap();
    sim.run_to(at + Duration::from_millis(1));
    assert_eq!(started(&sim), Some(at), "{}", sim.log().tail(&line, 20));
    let noticed = sim.log().of(clamp).find(|(_, event)| event.what == HappeningKind::Devices(false));
    assert_eq!(noticed.map(|(noticed, _)| noticed), Some(at), "{}", sim.log().tail(&line, 20));
}

#[test]
fn a_killed_station_is_missed_when_its_last_report_runs_out() {
    let line = transfer_line(1);
    let mut sim = LineSim::new(&line, logged()).unwrap();
    let goal = RunGoal::cycles(1);
    assert_eq!(sim.run(&goal), RunEnd::Done);
    // In the middle of the feed the mill has no news: its last report is its last repetition.
    let (_, feed) = op(&line, "mill_1", "feed main slide");
    while !sim.controller(MILL).unwrap().marking().any(|p| p.op == feed && p.is_operating()) {
        sim.step();
    }
    let killed = sim.now() + Duration::from_millis(234);
    sim.run_to(killed);
    sim.act(OperatorAction::Kill(NodeProcess::Station(MILL))).unwrap();
    sim.run_to(killed + Duration::from_secs(1));
    let refresh = line.timing.refresh.as_micros() as u64;
    let said = Tick::from_micros(killed.as_micros() / refresh * refresh);
    let entered = sim.log().entries().iter().rfind(|e| e.what == LogKind::Mode(ControlMode::StandBy)).unwrap().at;
    assert_eq!(entered, said + Duration::from_millis(1) + line.timing.stale);
    // It comes back where it was, incomplete, and waits for a person.
    sim.act(OperatorAction::Restart(NodeProcess::Station(MILL))).unwrap();
    sim.run_to(sim.now() + Duration::from_secs(1));
    assert!(sim.hears(MILL));
    assert!(sim.controller(MILL).unwrap().marking().any(|p| p.op == feed && p.is_incomplete()));
    assert_eq!(sim.mode(), ControlMode::StandBy);
}

#[test]
fn with_flags_instead_of_counts_the_observer_sees_the_bar_lift_under_a_closed_clamp() {
    let line = transfer_line(1);
    let rules = Rules { counted: false, ..Rules::default() };
    let (sim, end) = run(&line, linewright_simulation::SimOptions { rules, ..logged() }, &RunGoal::cycles(5)).unwrap();
    assert_eq!(end, RunEnd::Conflict, "{}", sim.log().tail(&line, 40));
    assert!(line.conflicts[sim.conflicts()[0].conflict].why.contains("clamp"));
    let (transfer, lift) = op(&line, "transfer", "1st lift");
    let lifted = |e: &linewright_simulation::SimLogEntry| matches!(e.what, LogKind::Station(id, event) if id == transfer && event.what == HappeningKind::Started(lift, Block::Normal));
    assert!(sim.log().entries().iter().filter(|e| lifted(e)).count() >= 1);
}

#[test]
fn a_line_that_cannot_go_on_says_what_everybody_waits_for() {
    let (_, end) = play(
        r#"
        cycles = 3
        [[step]]
        when = "cycles >= 1"
        stick = "transfer: advance transfer"
        "#,
    );
    let RunEnd::Stuck(reasons) = end else { panic!("{end:?}") };
    assert!(reasons[0].contains("stand-by"), "{reasons:?}");
    assert!(
        reasons
            .iter()
            .any(|r| r.contains("at its panel in manual, for advance transfer (watchdog: motion not complete in time)")),
        "{reasons:?}"
    );
}

#[test]
fn time_out_of_auto_is_nobody_s_wait_and_no_cycle_s_time() {
    let line = transfer_line(1);
    let quiet = run(&line, logged(), &RunGoal::cycles(8)).expect("the line compiles").0;
    let sim = played(
        r#"
        cycles = 8
        starts = false
        [[step]]
        at_s = 100
        command = "start"
        [[step]]
        command = "auto"
        [[step]]
        when = "cycles >= 3"
        command = "stop"
        [[step]]
        when = "line is home"
        after_s = 60
        command = "start"
        [[step]]
        command = "auto"
        "#,
    );
    let record = sim.record();
    assert_eq!(record.faults(), [], "nothing failed");
    // When the third has ended the fourth begins at once, and stop is given just then: the fourth is done first.
    assert_eq!(record.undisturbed(), [false, true, true, true, false, true, true, true]);
    let went = record.cycle_ends().windows(2).zip(&record.undisturbed()[1..]);
    for (pair, _) in went.filter(|(_, went)| **went) {
        let time = pair[1].since(pair[0]).as_secs_f64();
        assert!((3.55..3.57).contains(&time), "{time}");
    }
    for (wait, like) in record.waits().iter().zip(quiet.record().waits()) {
        let mean = |wait: &linewright_simulation::ArrowWait| wait.total.as_secs_f64() / wait.starts as f64;
        assert!(mean(wait) < mean(like) + 0.1, "{wait:?}, undisturbed {like:?}");
    }
}
