//! Stations whose faults are exceptions of their cell: the others stay in auto.

use linewright_coordinator_logic::ModeCommand;
use linewright_line::StationId;
use linewright_line::net::ControlMode;

use crate::common::CoordinatorBench;

/// The line in auto.
fn bench() -> CoordinatorBench {
    let mut bench = CoordinatorBench::with_one_task_driven();
    for command in [ModeCommand::Start, ModeCommand::Auto] {
        assert_eq!(bench.command(command), None);
    }
    bench
}

const TASK_DRIVEN: StationId = StationId(1);

#[test]
fn its_trouble_is_not_the_lines() {
    for (what, wrong) in [
        ("incomplete", (|heard| heard.incomplete = true) as fn(&mut linewright_coordinator_logic::StationView)),
        ("devices", |heard| heard.devices_valid = false),
        ("selector", |heard| heard.selector_manual = true),
        ("restarted", |heard| heard.boot_id += 1),
    ] {
        let mut bench = bench();
        bench.coordinator.isolate(|id, _| id == TASK_DRIVEN);
        wrong(&mut bench.heard[1]);
        bench.beat();
        assert_eq!(bench.mode(), ControlMode::Auto, "{what}");
        // When it is not left out any more, it is.
        bench.coordinator.isolate(|_, _| false);
        bench.beat();
        assert_ne!(bench.mode(), ControlMode::Auto, "{what}");
    }
}

#[test]
fn one_that_is_not_heard_is_not_waited_for() {
    let mut bench = bench();
    bench.coordinator.isolate(|id, _| id == TASK_DRIVEN);
    let stale = bench.line.timing.stale;
    for _ in 0..4 {
        bench.now = bench.now + stale / 2;
        [0, 2].into_iter().for_each(|station| bench.say(station));
    }
    assert_eq!((bench.mode(), bench.coordinator.text().as_str()), (ControlMode::Auto, "auto. Left out: clamp_1"));
    // A new epoch is acknowledged by the others alone.
    bench.command(ModeCommand::Stop);
    assert!(!bench.coordinator.waiting_for().contains(&TASK_DRIVEN));
}

#[test]
fn only_task_driven_stations_are_left_out() {
    let mut bench = bench();
    bench.coordinator.isolate(|_, _| true);
    bench.heard[0].incomplete = true;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::StandBy);
}

/// Emergency stop is for all, and it is not left past a station that moves.
#[test]
fn in_the_emergency_stop_all_count() {
    let mut bench = bench();
    bench.coordinator.isolate(|id, _| id == TASK_DRIVEN);
    bench.heard[1].stopped = false;
    bench.command(ModeCommand::EStop);
    assert_eq!(bench.mode(), ControlMode::EStop);
    bench.command(ModeCommand::Reset);
    bench.heard[0].selector_manual = true;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::EStop);
    bench.heard[1].stopped = true;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::Manual);
}

/// In emergency stop by itself, a station is none of the line's, until it is reset; and then only by an epoch of its own.
#[test]
fn one_that_is_stopped_alone_stops_nobody_else() {
    let mut bench = bench();
    let before = bench.coordinator.epoch();
    bench.coordinator.stop_alone(|id| id == TASK_DRIVEN);
    bench.heard[1].estopped = true;
    bench.heard[1].incomplete = true;
    bench.beat();
    assert_eq!((bench.mode(), bench.coordinator.epoch()), (ControlMode::Auto, before));
    assert!(bench.coordinator.is_stopped(TASK_DRIVEN) && !bench.coordinator.is_stopped(StationId(0)));
    assert!(bench.coordinator.text().ends_with(", clamp_1 in emergency stop"), "{}", bench.coordinator.text());
    assert!(bench.coordinator.order().enabled);

    // Its state from before the arrival of its reset has no effect. The others go on.
    bench.heard[1].incomplete = false;
    bench.heard[1].mode_epoch = before;
    bench.coordinator.stop_alone(|_| false);
    let reset = bench.coordinator.epoch();
    assert_eq!(reset, before + 1);
    assert_eq!(bench.coordinator.stopped_until(TASK_DRIVEN), reset);
    assert!(bench.coordinator.stopped_until(StationId(0)) < reset);
    let heard = bench.heard[1];
    bench.coordinator.handle(bench.now, linewright_coordinator_logic::ModeInput::Station(TASK_DRIVEN, heard));
    bench.coordinator.step(bench.now, &mut linewright_coordinator_logic::ModeOutbox::default());
    assert_eq!(bench.mode(), ControlMode::Auto);
    assert!(bench.coordinator.order().enabled);

    // If it is in one still though it has, another has stopped it.
    let heard = linewright_coordinator_logic::StationView { mode_epoch: reset, ..heard };
    bench.coordinator.handle(bench.now, linewright_coordinator_logic::ModeInput::Station(TASK_DRIVEN, heard));
    bench.coordinator.step(bench.now, &mut linewright_coordinator_logic::ModeOutbox::default());
    assert_eq!(bench.mode(), ControlMode::EStop);
}

#[test]
fn only_task_driven_stations_are_stopped_alone() {
    let mut bench = bench();
    bench.coordinator.stop_alone(|_| true);
    let stopped = bench.line.station_ids().filter(|&id| bench.coordinator.is_stopped(id));
    assert_eq!(stopped.collect::<Vec<_>>(), [TASK_DRIVEN]);
}

/// A station that was led away from its rest by hand has nothing to go on with in auto, and nothing can be ordered of it.
#[test]
fn between_two_rests_without_an_order_it_keeps_the_line_from_auto() {
    for mode in [ControlMode::StandBy, ControlMode::Manual] {
        let mut bench = CoordinatorBench::with_one_task_driven();
        bench.command(ModeCommand::Start);
        if mode == ControlMode::Manual {
            bench.command(ModeCommand::Manual);
        }
        bench.heard[1].at_home = false;
        bench.coordinator.hold(|id| id == TASK_DRIVEN);
        bench.beat();
        let expected = format!(
            "auto refused in {mode}: clamp_1: between two rests, with no task order; lead it to a rest in manual, or \
             take its resource out of service"
        );
        assert_eq!((bench.command(ModeCommand::Auto), bench.mode()), (Some(expected), mode));
        // Left out by its cell it is none of the line's.
        bench.coordinator.isolate(|id, _| id == TASK_DRIVEN);
        assert_eq!((bench.command(ModeCommand::Auto), bench.mode()), (None, ControlMode::Auto));
    }
}

/// Home is only where every station is at its start, also one that is left out.
#[test]
fn a_stop_ends_in_stand_by_while_a_station_that_is_left_out_is_away() {
    let mut bench = bench();
    bench.coordinator.isolate(|id, _| id == TASK_DRIVEN);
    bench.heard[1].at_home = false;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::Auto);
    assert_eq!(bench.command(ModeCommand::Stop), None);
    assert_eq!(bench.mode(), ControlMode::StandBy);
    assert_eq!(bench.coordinator.text(), "stand-by, auto ended (clamp_1: not at home). Left out: clamp_1");
    let refusal = bench.command(ModeCommand::Stop);
    assert_eq!(refusal.as_deref(), Some("stop refused in stand-by: clamp_1: not at home"));
    assert_eq!(bench.command(ModeCommand::Start), None, "as from home");
    bench.heard[1].at_home = true;
    bench.beat();
    assert_eq!((bench.command(ModeCommand::Stop), bench.mode()), (None, ControlMode::Home));
}

/// A coordinator that was killed and comes up finds it away: the line is not at home.
#[test]
fn a_coordinator_that_comes_up_while_it_is_away_is_in_stand_by() {
    let mut bench = CoordinatorBench::with_one_task_driven();
    bench.heard[1].at_home = false;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::StandBy);
    assert_eq!(bench.command(ModeCommand::Start), None, "the start that is due");
    assert!(bench.command(ModeCommand::Start).is_some_and(|refusal| refusal.contains("already")));
}

/// What is left out in auto is no reason against auto, whichever mode it is given in. In hand all stations count: it is refused,
/// and not entered and left at once.
#[test]
fn auto_and_hand_are_judged_alike_from_stand_by_and_from_manual() {
    for mode in [ControlMode::StandBy, ControlMode::Manual] {
        let bench = || {
            let mut bench = CoordinatorBench::with_one_task_driven();
            bench.command(ModeCommand::Start);
            bench.coordinator.isolate(|id, _| id == TASK_DRIVEN);
            (bench.heard[1].at_home, bench.heard[1].incomplete) = (false, true);
            bench.coordinator.hold(|id| id == TASK_DRIVEN);
            if mode == ControlMode::Manual {
                bench.command(ModeCommand::Manual);
            }
            bench.beat();
            assert_eq!(bench.mode(), mode);
            bench
        };
        let mut auto = bench();
        assert_eq!((auto.command(ModeCommand::Auto), auto.mode()), (None, ControlMode::Auto));
        assert_eq!(auto.coordinator.text(), "auto. Left out: clamp_1");
        let mut hand = bench();
        let expected = "clamp_1: operation incomplete; complete or undo it in manual";
        let before = hand.coordinator.epoch();
        assert_eq!(hand.command(ModeCommand::Hand), Some(format!("hand refused in {mode}: {expected}")));
        assert_eq!((hand.mode(), hand.coordinator.epoch()), (mode, before));
        // One that is its line's trouble is the same trouble from both.
        let mut counted = bench();
        counted.coordinator.isolate(|_, _| false);
        let expected = format!(
            "auto refused in {mode}: clamp_1: operation incomplete; complete or undo it in manual; clamp_1: between two rests, \
             with no task order; lead it to a rest in manual, or take its resource out of service"
        );
        assert_eq!((counted.command(ModeCommand::Auto), counted.mode()), (Some(expected), mode));
    }
}

/// Also of a line whose stations count: home is only where all stand at home.
#[test]
fn a_coordinator_that_finds_a_station_half_way_is_in_stand_by_and_names_its_start() {
    let mut bench = CoordinatorBench::new();
    (bench.heard[2].at_home, bench.heard[2].incomplete) = (false, true);
    bench.beat();
    let text = "stand-by, coordinator started with stations away from home: mill_1: operation incomplete; complete or undo it \
                in manual";
    assert_eq!(bench.coordinator.text(), text);
    let refusal = bench.command(ModeCommand::Auto);
    let expected = "auto refused in stand-by: mill_1: operation incomplete; complete or undo it in manual";
    assert_eq!(refusal.as_deref(), Some(expected), "the reason that matters");
    assert_eq!(bench.coordinator.text(), text, "what is refused is no command");
    assert_eq!((bench.command(ModeCommand::Manual), bench.mode()), (None, ControlMode::Manual));
    assert_eq!(bench.coordinator.text().split(':').next(), Some("manual"));
}
