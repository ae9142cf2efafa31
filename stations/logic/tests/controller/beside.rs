//! Operations side by side (seed 002, Appendix): fork, join, recovery of one by itself, reversal of all together.

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{OpId, StationId};
use linewright_station_logic::{AgreementAnswer, StationReport};

use super::rig::{Rig, peer_says};
use linewright_testkit::built::{actuator_bit, alone, arrow, beside, complete_bit, line, r, station};

/// op 0, then op 1 beside op 2, then op 3, which is home.
fn group() -> Vec<linewright_testkit::built::Op> {
    vec![r(6), r(6), beside(6), r(6)]
}

/// Both of the group are moving.
fn forked(mode: ControlMode) -> Rig {
    let mut rig = Rig::new(alone(3, &group()));
    rig.mode(mode);
    rig
}

const BOTH: [u16; 2] = [1, 2];

fn both(recovery: bool) -> u128 {
    BOTH.map(|op| actuator_bit(OpId(op), recovery)).iter().sum()
}

#[test]
fn auto_forks_into_the_group_and_joins_when_the_last_of_it_is_done() {
    let mut rig = forked(ControlMode::Auto);
    rig.arrive(0);
    assert_eq!(rig.outputs, both(false));
    rig.arrive(2);
    assert!(rig.drives(1));
    assert_eq!(rig.doing(), "op 1 + op 2 (done)");
    rig.arrive(1);
    assert!(rig.drives(3));
    assert_eq!(rig.marking(), [StationPlace::operating(OpId(3))]);
    assert_eq!(rig.report().done, [1, 1, 1, 0]);
}

#[test]
fn two_that_arrive_in_one_image_join_at_once() {
    let mut rig = forked(ControlMode::Auto);
    rig.arrive(0);
    rig.set(complete_bit(OpId(1), false) | complete_bit(OpId(2), false), true);
    assert!(rig.drives(3));
}

/// Figure 26: the initial marking there is A stopped, B complete.
#[test]
fn a_fault_in_one_is_recovered_without_moving_the_other() {
    for way in ["resume", "return and redo"] {
        let mut rig = forked(ControlMode::Auto);
        rig.arrive(0);
        rig.arrive(2);
        rig.set(complete_bit(OpId(1), false) << 1, true);
        assert_eq!(rig.outputs, 0);
        rig.mode(ControlMode::Manual);
        rig.set(u128::MAX, false);
        if way == "resume" {
            rig.advance_through(1);
        } else {
            rig.retract(true);
            assert!(rig.drives_back(1), "op 2 stays where it is");
            rig.arrive_back(1);
            rig.retract(false);
            rig.advance_through(1);
        }
        assert_eq!(rig.marking(), [StationPlace::completed(OpId(1)), StationPlace::completed(OpId(2))], "{way}");
        assert_eq!(rig.report().done, [1, 1, 1, 0]);
        rig.mode(ControlMode::Auto);
        assert!(rig.drives(3));
    }
}

#[test]
fn a_fault_in_one_lets_the_other_finish() {
    let mut rig = forked(ControlMode::Auto);
    rig.arrive(0);
    rig.set(complete_bit(OpId(1), false) << 1, true);
    assert!(rig.drives(2));
    rig.set(u128::MAX, false);
    rig.arrive(2);
    assert_eq!(rig.doing(), "op 1 (stopped) + op 2 (done)");
}

#[test]
fn the_return_command_reverses_all_of_the_group_together() {
    let mut rig = forked(ControlMode::Manual);
    rig.advance_through(0);
    rig.advance(true);
    assert_eq!(rig.outputs, both(false));
    rig.arrive(1);
    rig.arrive(2);
    rig.advance(false);
    rig.retract(true);
    assert_eq!(rig.outputs, both(true));
    assert_eq!(rig.report().done, [1, 0, 0, 0]);
    rig.arrive_back(1);
    rig.arrive_back(2);
    rig.retract(false);
    rig.advance(true);
    assert_eq!(rig.outputs, both(false), "and forward again together");
}

#[test]
fn a_reversed_sequence_runs_back_through_a_group() {
    let ops = [r(3), r(4), beside(4), r(5), r(6)];
    let mut rig = Rig::new(alone(4, &ops));
    rig.mode(ControlMode::Hand);
    let hand = rig.line.operation((StationId(0), OpId(0))).hand;
    let (forward, back) = (hand.forward().0, hand.back().expect("type 3").0);
    rig.hold(forward);
    for op in [0, 2, 1, 3] {
        rig.arrive(op);
    }
    rig.release(forward);
    rig.hold(back);
    assert!(rig.drives_back(3));
    rig.arrive_back(3);
    assert_eq!(rig.outputs, both(true), "t12 forks backwards");
    rig.arrive_back(1);
    assert!(rig.drives_back(2), "and joins when the last is undone");
    rig.arrive_back(2);
    assert!(rig.drives_back(0));
    rig.arrive_back(0);
    assert_eq!(rig.report().done, [0; 5]);
}

/// Only op 1 has an arrow from it. Op 2 must not move before the peer has agreed about op 1.
#[test]
fn a_group_of_which_one_needs_agreement_waits_as_a_whole() {
    let stations = vec![station("a", 3, &group(), 0, false), station("b", 1, &[r(6), r(6)], 16, false)];
    let mut rig = Rig::new(line(stations, vec![arrow((0, 1), (1, 0), 0)]));
    rig.hear(StationId(1), peer_says(&[0, 0]));
    rig.mode(ControlMode::Manual);
    rig.advance_through(0);
    rig.advance(true);
    rig.arrive(1);
    rig.arrive(2);
    rig.advance(false);
    rig.retract(true);
    assert_eq!(rig.outputs, 0);
    let request = rig.report().request.expect("it asks");
    assert_eq!(request.ops, 0b110, "for both at once");
    let agreed = AgreementAnswer { to: StationId(0), boot_id: 1, number: request.number, in_the_way: None };
    rig.hear(StationId(1), StationReport { answers: vec![agreed], ..peer_says(&[0, 0]) });
    assert_eq!(rig.outputs, both(true));
    assert_eq!(rig.report().done, [1, 0, 0, 0]);
}
