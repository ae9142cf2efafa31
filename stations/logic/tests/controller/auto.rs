//! Auto: the order of the chart, the arrows, master stop, and what a station counts before it has moved.

use linewright_line::net::ControlMode;
use linewright_line::{OpId, StationId};

use super::rig::{Rig, peer_says};
use linewright_testkit::built::{alone, arrow, i, line, r, station};

#[test]
fn auto_runs_the_operations_in_the_order_of_the_chart_and_counts_the_cycle() {
    let mut rig = Rig::new(alone(3, &[r(1), i(1, &[0]), r(1), r(2)]));
    rig.mode(ControlMode::Auto);
    for op in 0..4 {
        assert!(rig.drives(op), "op {op}");
        rig.arrive(op);
    }
    assert_eq!(
        rig.events(),
        [
            "changed to mode auto",
            "started op 0",
            "completed op 0",
            "started op 1",
            "completed op 1",
            "started op 2",
            "completed op 2",
            "started op 3",
            "completed op 3",
            "started op 0",
        ]
    );
    let report = rig.report();
    assert_eq!((report.cycle, report.done, report.started), (2, vec![1, 1, 1, 1], vec![2, 1, 1, 1]));
}

#[test]
fn home_listed_last_counts_nothing_and_home_listed_earlier_counts_cycle_1_up_to_it() {
    let counts = |home| {
        let report = Rig::new(alone(home, &[r(6), r(6), r(6)])).report();
        (report.cycle, report.done, report.started)
    };
    assert_eq!(counts(2), (0, vec![0, 0, 0], vec![0, 0, 0]));
    assert_eq!(counts(0), (1, vec![1, 0, 0], vec![1, 0, 0]));
    assert_eq!(counts(1), (1, vec![1, 1, 0], vec![1, 1, 0]));
}

fn two_stations() -> linewright_line::Line {
    let stations = vec![station("a", 1, &[r(6), r(6)], 0, false), station("b", 1, &[r(6), r(6)], 8, false)];
    line(stations, vec![arrow((1, 1), (0, 0), 1), arrow((1, 0), (0, 1), 0)])
}

#[test]
fn an_arrow_of_lag_1_asks_for_the_cycle_before_and_one_of_lag_0_for_the_same() {
    let mut rig = Rig::new(two_stations());
    rig.mode(ControlMode::Auto);
    assert_eq!(rig.blocked_by(), ["the state of b, for op 0"]);
    rig.hear(StationId(1), peer_says(&[0, 0]));
    assert!(rig.drives(0), "op 1 of b was last done in cycle 0, which is enough for cycle 1");
    rig.arrive(0);
    assert_eq!(rig.outputs, 0);
    assert_eq!(rig.blocked_by(), ["b: op 0 (cycle 1), for op 1"]);
    rig.hear(StationId(1), peer_says(&[1, 0]));
    assert!(rig.drives(1));
    rig.arrive(1);
    assert_eq!(rig.blocked_by(), ["b: op 1 (cycle 1), for op 0"], "cycle 2 needs cycle 1");
}

#[test]
fn a_view_that_has_grown_old_blocks_a_start_and_does_not_stop_what_runs() {
    let mut rig = Rig::new(two_stations());
    rig.hear(StationId(1), peer_says(&[5, 5]));
    rig.order.lease = std::time::Duration::from_secs(60);
    rig.mode(ControlMode::Auto);
    assert!(rig.drives(0));
    rig.silence_ms(251);
    assert!(rig.drives(0), "a running motion asks no view");
    rig.arrive(0);
    assert_eq!(rig.outputs, 0);
    assert_eq!(rig.blocked_by(), ["the state of b, for op 1"]);
    rig.hear(StationId(1), peer_says(&[5, 5]));
    assert!(rig.drives(1));
}

#[test]
fn master_stop_lets_the_round_finish_and_holds_the_station_at_home() {
    let mut rig = Rig::new(alone(1, &[r(6), r(6)]));
    rig.mode(ControlMode::Auto);
    rig.order.master_stop = Some(1);
    rig.order();
    rig.arrive(0);
    rig.arrive(1);
    assert_eq!(rig.outputs, 0);
    assert!(rig.report().at_home);
    assert_eq!(rig.blocked_by(), ["master stop: halted at home"]);
    rig.order.master_stop = None;
    rig.order();
    assert!(rig.drives(0));
}

#[test]
fn in_stand_by_the_running_operation_finishes_and_the_next_does_not_start() {
    let mut rig = Rig::new(alone(1, &[r(6), r(6)]));
    rig.mode(ControlMode::Auto);
    rig.mode(ControlMode::StandBy);
    assert!(rig.drives(0));
    rig.arrive(0);
    assert_eq!(rig.outputs, 0);
    assert_eq!(rig.marking(), [linewright_line::net::StationPlace::completed(OpId(0))]);
}

#[test]
fn switched_on_away_from_home_it_does_not_claim_to_be_there() {
    let shipped = alone(1, &[r(6), r(6)]);
    let mut controller =
        linewright_station_logic::Controller::new(&shipped, StationId(0), 1, linewright_station_logic::Restore::Fresh)
            .expect("compiles");
    let image = linewright_station_logic::StationInput::Inputs {
        bits: 0,
        valid: true,
        until: linewright_line::Tick::NEVER,
        under: linewright_station_logic::NO_DELAY,
    };
    controller.handle(linewright_line::Tick::ZERO, image);
    assert_eq!(controller.report().done, [0, -1]);
    assert_eq!(controller.fault_text(&shipped), "op 1: not at home at power-up");
}
