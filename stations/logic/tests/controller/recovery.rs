//! The three ways out of a fault (seed 002 §4.5.1): resume, return and redo, go home and do the cycle again.

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{OpId, StationId};
use linewright_station_logic::{AgreementRequest, StationReport};

use super::rig::{Rig, peer_says};
use linewright_testkit::built::{alone, arrow, complete_bit, i, line, r, station};

/// Faulted in `op`, in auto, then in manual with the fault gone.
fn faulted(home: usize, ops: &[linewright_testkit::built::Op], op: u16) -> Rig {
    let mut rig = Rig::new(alone(home, ops));
    rig.mode(ControlMode::Auto);
    for before in 0..op {
        rig.arrive(before);
    }
    rig.set(u128::MAX, false);
    rig.set(complete_bit(OpId(op), false) << 1, true);
    rig.mode(ControlMode::StandBy);
    rig.mode(ControlMode::Manual);
    rig.set(u128::MAX, false);
    rig.events();
    rig
}

#[test]
fn a_stopped_operation_is_resumed_and_auto_goes_on_from_there() {
    let mut rig = faulted(2, &[r(6), r(6), r(6)], 1);
    assert_eq!(rig.outputs, 0);
    rig.advance_through(1);
    assert_eq!(rig.events(), ["started op 1", "completed op 1"]);
    rig.mode(ControlMode::Auto);
    assert!(rig.drives(2));
    assert_eq!(rig.report().done, [1, 1, 0]);
}

#[test]
fn a_stopped_operation_is_returned_and_auto_does_it_again_in_the_same_cycle() {
    let mut rig = faulted(2, &[r(6), r(6), r(6)], 1);
    rig.retract_through(1);
    assert_eq!(
        rig.events(),
        ["started undoing op 1", "completed undoing op 1"],
        "nothing was counted, nothing is taken back"
    );
    rig.mode(ControlMode::Auto);
    assert!(rig.drives(1));
    rig.arrive(1);
    assert_eq!(rig.report().done, [1, 1, 0]);
    assert_eq!(rig.report().cycle, 1);
}

#[test]
fn resuming_with_the_fault_still_on_stops_in_the_same_step() {
    let mut rig = faulted(2, &[r(6), r(6), r(6)], 1);
    rig.set(complete_bit(OpId(1), false) << 1, true);
    rig.advance(true);
    assert_eq!(rig.outputs, 0);
    assert_eq!(rig.marking(), [StationPlace::incomplete(OpId(1))]);
}

#[test]
fn releasing_the_button_stops_a_manual_motion_and_either_button_moves_it_on() {
    let mut rig = faulted(2, &[r(6), r(6), r(6)], 1);
    rig.advance(true);
    rig.advance(false);
    assert_eq!((rig.outputs, rig.doing().as_str()), (0, "op 1 (stopped)"));
    rig.retract(true);
    assert!(rig.drives_back(1), "t5");
    rig.retract(false);
    assert_eq!((rig.outputs, rig.doing().as_str()), (0, "undoing op 1 (stopped)"));
    rig.retract(true);
    assert!(rig.drives_back(1), "t7");
    rig.wait_ms(1000);
    let fault = rig.controller.fault_text(&rig.line);
    assert!(fault.starts_with("undoing op 1: watchdog: "), "{fault}");
    rig.retract(false);
    rig.advance(true);
    assert!(rig.drives(1), "t10");
}

#[test]
fn going_home_withdraws_the_round_first_and_does_the_cycle_again_without_counting_home() {
    let mut rig = faulted(3, &[r(1), i(1, &[0]), r(1), r(2)], 1);
    assert_eq!(rig.report().done, [1, 0, 0, 0]);
    rig.retract(true);
    assert!(rig.drives_back(0));
    assert_eq!(rig.report().done, [0, 0, 0, 0], "withdrawn before the motion");
    assert_eq!(rig.report().started, [1; 4], "but claimed until it is home: nobody takes back what it waits for");
    rig.arrive_back(0);
    rig.retract(false);
    rig.advance(true);
    assert_eq!(rig.outputs, 0, "on the way home nothing turns forward");
    rig.advance(false);
    rig.retract(true);
    assert!(rig.drives(3), "the home operation's normal motion, under the return button");
    rig.retract(false);
    assert_eq!((rig.outputs, rig.doing().as_str()), (0, "op 3 (stopped)"));
    rig.retract(true);
    assert!(rig.drives(3));
    rig.arrive(3);
    let report = rig.report();
    assert_eq!((report.done, report.started, report.cycle), (vec![0; 4], vec![0; 4], 0), "the part was never machined");
    assert!(report.at_home && !report.recovering_home);
    rig.retract(false);
    rig.mode(ControlMode::Auto);
    assert!(rig.drives(0));
    assert_eq!(rig.report().cycle, 1, "the same cycle again");
}

#[test]
fn the_way_home_is_not_left_by_auto() {
    let mut rig = faulted(3, &[r(1), i(1, &[0]), r(1), r(2)], 1);
    rig.retract_through(0);
    rig.mode(ControlMode::Auto);
    assert_eq!(rig.outputs, 0);
    rig.mode(ControlMode::Manual);
    rig.retract(true);
    rig.arrive(3);
    assert!(rig.report().at_home);
}

/// Found by the explorer: the home motion used to start whatever the neighbour did.
#[test]
fn going_home_waits_for_the_arrows_into_what_it_skips() {
    let stations =
        vec![station("y", 2, &[r(6), i(2, &[0]), r(6)], 0, false), station("x", 2, &[r(6), r(6), r(6)], 10, false)];
    let mut rig = Rig::new(line(stations, vec![arrow((1, 1), (0, 2), 0)]));
    rig.hear(StationId(1), peer_says(&[1, 0, 0]));
    rig.mode(ControlMode::Manual);
    rig.advance_through(0);
    rig.advance(true);
    rig.advance(false);
    rig.events();
    rig.retract(true);
    assert_eq!((rig.outputs, rig.events()), (0, vec!["rejected the command".to_owned()]));
    let waits_for = "x: op 1 (cycle 1), for op 2, needed on the recovery path";
    assert_eq!(rig.blocked_by().last().map(String::as_str), Some(waits_for));
    rig.retract(false);
    rig.hear(StationId(1), peer_says(&[1, 1, 0]));
    rig.retract(true);
    assert!(rig.drives_back(0));
    let asks = StationReport { request: Some(AgreementRequest { number: 1, ops: 0b10 }), ..peer_says(&[1, 1, 0]) };
    rig.hear(StationId(1), asks);
    assert_eq!(rig.report().answers[0].in_the_way, Some(OpId(2)), "until it is home x may not go back");
}

#[test]
fn an_irreversible_operation_is_resumed_like_any_other() {
    let mut rig = faulted(3, &[r(1), i(1, &[0]), r(1), r(2)], 1);
    rig.advance_through(1);
    assert_eq!(rig.report().done, [1, 1, 0, 0]);
}
