//! Counts going back: across the cycle boundary and at home, in manual.

use linewright_line::net::ControlMode;

use super::rig::Rig;
use linewright_testkit::built::{alone, i, r};

type Counts = (i32, Vec<i32>, Vec<i32>);

fn counts(rig: &Rig) -> Counts {
    let report = rig.report();
    (report.cycle, report.done, report.started)
}

fn in_manual(home: usize, types: &[u8]) -> Rig {
    let ops: Vec<_> = types.iter().map(|&t| r(t)).collect();
    let mut rig = Rig::new(alone(home, &ops));
    rig.mode(ControlMode::Manual);
    rig
}

#[test]
fn undoing_the_first_operation_leads_into_the_cycle_before_and_redoing_it_gives_the_same_counts() {
    for home in 0..3 {
        let mut rig = in_manual(home, &[6, 6, 6]);
        while rig.report().done[0] < 2 {
            let next = (usize::from(rig.marking()[0].op.0) + 1) % 3;
            rig.advance_through(next as u16);
        }
        let before = counts(&rig);
        rig.retract_through(0);
        let (cycle, done, started) = counts(&rig);
        assert_eq!((cycle, done[0], started[0]), (before.0 - 1, before.1[0] - 1, before.2[0] - 1), "home {home}");
        rig.advance_through(0);
        assert_eq!(counts(&rig), before, "home {home}");
    }
}

#[test]
fn every_operation_undone_and_redone_gives_the_counts_it_had() {
    for op in 0..3u16 {
        let mut rig = in_manual(2, &[6, 6, 6]);
        for before in 0..=op {
            rig.advance_through(before);
        }
        let had = counts(&rig);
        for _ in 0..3 {
            rig.retract_through(op);
            assert_eq!(rig.report().done[usize::from(op)], had.1[usize::from(op)] - 1);
            rig.advance_through(op);
            assert_eq!(counts(&rig), had, "op {op}");
        }
    }
}

#[test]
fn a_count_goes_back_when_the_motion_starts_and_the_start_when_it_is_complete() {
    let mut rig = in_manual(2, &[6, 6, 6]);
    rig.advance_through(0);
    rig.retract(true);
    assert_eq!(counts(&rig), (1, vec![0, 0, 0], vec![1, 0, 0]));
    rig.arrive_back(0);
    assert_eq!(counts(&rig), (0, vec![0, 0, 0], vec![0, 0, 0]));
}

#[test]
fn turning_forward_half_way_through_undoing_gives_the_count_again() {
    let mut rig = in_manual(2, &[6, 6, 6]);
    rig.advance_through(0);
    rig.retract(true);
    rig.retract(false);
    rig.advance_through(0);
    assert_eq!(counts(&rig), (1, vec![1, 0, 0], vec![1, 0, 0]));
}

#[test]
fn the_home_operation_of_a_station_that_never_ran_can_be_undone() {
    let mut rig = in_manual(2, &[6, 6, 6]);
    rig.retract_through(2);
    assert_eq!(counts(&rig), (0, vec![0, 0, -1], vec![0, 0, -1]));
    rig.mode(ControlMode::Auto);
    rig.arrive(2);
    assert_eq!(counts(&rig), (1, vec![0, 0, 0], vec![1, 0, 0]));
}

#[test]
fn a_reverse_sequence_back_to_the_first_operation_ends_in_the_cycle_before() {
    let mut rig = in_manual(3, &[3, 4, 5, 6]);
    for op in [0, 1, 2, 3, 0, 1] {
        rig.advance_through(op);
    }
    assert_eq!(counts(&rig), (2, vec![2, 2, 1, 1], vec![2, 2, 1, 1]));
    rig.advance_through(2);
    rig.retract_through(2);
    rig.retract_through(1);
    rig.retract_through(0);
    assert_eq!(counts(&rig), (1, vec![1; 4], vec![1; 4]));
    rig.advance_through(0);
    assert_eq!(counts(&rig), (2, vec![2, 1, 1, 1], vec![2, 1, 1, 1]));
}

/// A motion offered by the reason is possible, and where return moves nothing the reason is given.
#[test]
fn return_is_offered_where_it_moves_and_nowhere_else() {
    for types in [&[1, 1, 2, 6][..], &[3, 4, 5, 6], &[6, 6, 6]] {
        let home = types.len() - 1;
        for last in 0..types.len() as u16 {
            let mut rig = in_manual(home, types);
            (0..=last).for_each(|op| rig.advance_through(op));
            for back in 0..=last + 1 {
                let reasons = rig.blocked_by();
                let offered = reasons.contains(&"advance or return at its panel".to_owned());
                rig.retract(true);
                assert_eq!(offered, rig.outputs != 0, "{types:?}, after {last}, {back} back: {reasons:?}");
                if !offered {
                    assert!(reasons.iter().any(|why| why.contains("no return: ")), "{reasons:?}");
                    break;
                }
                rig.arrive_back(rig.marking()[0].op.0);
                rig.retract(false);
            }
        }
    }
    let mut rig = in_manual(3, &[1, 1, 2, 6]);
    rig.advance_through(0);
    rig.retract_through(0);
    assert!(rig.report().at_home);
    assert_eq!(rig.blocked_by(), ["advance at its panel; no return: it is at home"]);
    let mut rig = Rig::new(alone(2, &[r(1), i(2, &[2]), r(6)]));
    rig.mode(ControlMode::Manual);
    rig.advance_through(0);
    rig.advance_through(1);
    assert_eq!(rig.blocked_by(), ["advance at its panel; no return: op 1 cannot be undone"]);
    rig.retract(true);
    assert_eq!(rig.outputs, 0);
}
