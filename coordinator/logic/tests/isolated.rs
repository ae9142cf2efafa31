//! Stations whose trouble is an exception of the cell they work in: the others stay in auto.

use linewright_coordinator_logic::Command;
use linewright_line::StationId;
use linewright_line::net::ControlMode;

use crate::common::Bench;

/// The line in auto.
fn bench() -> Bench {
    let mut bench = Bench::with_one_on_order();
    for command in [Command::Start, Command::Auto] {
        assert_eq!(bench.command(command), None);
    }
    bench
}

const ON_ORDER: StationId = StationId(1);

#[test]
fn its_trouble_is_not_the_lines() {
    for (what, wrong) in [
        ("incomplete", (|heard| heard.incomplete = true) as fn(&mut linewright_coordinator_logic::Heard)),
        ("devices", |heard| heard.devices_valid = false),
        ("selector", |heard| heard.selector_manual = true),
        ("restarted", |heard| heard.boot_id += 1),
    ] {
        let mut bench = bench();
        bench.coordinator.isolate(|id, _| id == ON_ORDER);
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
    bench.coordinator.isolate(|id, _| id == ON_ORDER);
    let stale = bench.line.timing.stale;
    for _ in 0..4 {
        bench.now = bench.now + stale / 2;
        [0, 2].into_iter().for_each(|station| bench.say(station));
    }
    assert_eq!((bench.mode(), bench.coordinator.text().as_str()), (ControlMode::Auto, "auto, without clamp_1"));
    // A new epoch is acknowledged by the others alone.
    bench.command(Command::Stop);
    assert!(!bench.coordinator.waiting_for().contains(&ON_ORDER));
}

#[test]
fn only_stations_on_order_are_left_out() {
    let mut bench = bench();
    bench.coordinator.isolate(|_, _| true);
    bench.heard[0].incomplete = true;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::StandBy);
}

/// Emergency stop is for all, and nobody leaves it past a station that moves.
#[test]
fn in_the_emergency_stop_all_count() {
    let mut bench = bench();
    bench.coordinator.isolate(|id, _| id == ON_ORDER);
    bench.heard[1].stopped = false;
    bench.command(Command::EStop);
    assert_eq!(bench.mode(), ControlMode::EStop);
    bench.command(Command::Reset);
    bench.heard[0].selector_manual = true;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::EStop);
    bench.heard[1].stopped = true;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::Manual);
}
