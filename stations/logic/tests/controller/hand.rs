//! Hand mode: the six types of seed 002 Figure 21 through a whole cycle, forward and back, by buttons.

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{HandMode, OpId, StationId};

use super::rig::Rig;
use linewright_testkit::built::{alone, line, r, station};

fn in_hand_mode(home: usize, types: &[u8]) -> Rig {
    let ops: Vec<_> = types.iter().map(|&t| r(t)).collect();
    let mut rig = Rig::new(alone(home, &ops));
    rig.mode(ControlMode::Hand);
    rig.events();
    rig
}

fn hand_of(rig: &Rig, op: u16) -> HandMode {
    rig.line.operation((StationId(0), OpId(op))).hand
}

/// Every type in one cycle: 6, 1 1 2, 3 4 5, 6.
const CYCLE: [u8; 8] = [6, 1, 1, 2, 3, 4, 5, 6];

#[test]
fn buttons_run_the_whole_cycle_forward_sequence_by_sequence() {
    let mut rig = in_hand_mode(7, &CYCLE);
    for sequence in [&[0u16][..], &[1, 2, 3], &[4, 5, 6], &[7]] {
        let button = hand_of(&rig, sequence[0]).forward().0;
        assert_eq!(rig.outputs, 0, "a sequence begins with a press");
        rig.hold(button);
        for &op in sequence {
            assert!(rig.drives(op), "op {op}, its button held");
            rig.release(button);
            assert_eq!(rig.outputs, 0, "op {op} pauses");
            assert_eq!(rig.marking(), [StationPlace::operating(OpId(op))], "and is not stopped: it is no fault");
            rig.hold(button);
            rig.arrive(op);
        }
        rig.release(button);
    }
    assert_eq!(rig.report().done, [1; 8]);
    assert!(rig.report().at_home);
}

#[test]
fn a_motion_that_arrives_while_its_button_is_up_completes_when_it_is_down() {
    let mut rig = in_hand_mode(1, &[6, 6]);
    let button = hand_of(&rig, 0).forward().0;
    rig.hold(button);
    rig.release(button);
    rig.set(u128::MAX, false);
    rig.set(linewright_testkit::built::complete_bit(OpId(0), false), true);
    assert_eq!(rig.report().done, [0, 0]);
    rig.hold(button);
    assert_eq!(rig.report().done, [1, 0]);
}

#[test]
fn the_watchdog_does_not_run_while_a_button_is_up() {
    let mut rig = in_hand_mode(1, &[6, 6]);
    let button = hand_of(&rig, 0).forward().0;
    rig.hold(button);
    rig.wait_ms(900);
    rig.release(button);
    rig.wait_ms(5000);
    rig.hold(button);
    rig.wait_ms(99);
    assert!(rig.drives(0));
    rig.wait_ms(1);
    assert_eq!(rig.events().last().map(String::as_str), Some("stopped op 0: watchdog: in 0 not on within 1 s"));
}

#[test]
fn a_single_operation_is_reversed_and_started_again() {
    let mut rig = in_hand_mode(2, &[6, 6, 6]);
    let hand = hand_of(&rig, 1);
    for (button, op) in [(hand_of(&rig, 0).forward().0, 0), (hand.forward().0, 1)] {
        rig.hold(button);
        rig.arrive(op);
        rig.release(button);
    }
    let back = hand.back().expect("type 6").0;
    rig.hold(back);
    assert!(rig.drives_back(1));
    rig.release(back);
    assert_eq!(rig.outputs, 0);
    rig.hold(back);
    rig.arrive_back(1);
    assert_eq!((rig.doing().as_str(), rig.report().done), ("op 1 (undone)", vec![1, 0, 0]));
    rig.release(back);
    rig.hold(hand.forward().0);
    assert!(rig.drives(1));
}

#[test]
fn a_reversed_sequence_runs_back_to_its_first_operation_under_one_button() {
    let mut rig = in_hand_mode(3, &[3, 4, 5, 6]);
    let hand = hand_of(&rig, 0);
    rig.hold(hand.forward().0);
    for op in 0..3 {
        rig.arrive(op);
    }
    rig.release(hand.forward().0);
    rig.hold(hand.back().expect("type 3").0);
    for op in [2, 1, 0] {
        assert!(rig.drives_back(op), "undoing op {op}");
        rig.arrive_back(op);
    }
    assert_eq!(rig.outputs, 0, "the reverse sequence ends at the first operation");
    let report = rig.report();
    assert_eq!((report.cycle, report.done, report.started), (0, vec![0; 4], vec![0; 4]));
    assert!(report.at_home, "everything after home has been undone: the same position");
    rig.release(hand.back().expect("type 3").0);
    rig.hold(hand.forward().0);
    assert!(rig.drives(0));
    assert_eq!(rig.report().cycle, 1);
}

#[test]
fn a_sequence_that_is_never_reversed_goes_one_way() {
    let mut rig = in_hand_mode(2, &[1, 1, 2]);
    let button = hand_of(&rig, 0).forward().0;
    rig.hold(button);
    rig.arrive(0);
    rig.release(button);
    assert!(!rig.drives_back(0));
    for other in 0..8 {
        if other != button {
            rig.hold(other);
            assert_eq!(rig.outputs, 0);
            rig.release(other);
        }
    }
    assert_eq!(
        rig.marking(),
        [StationPlace::operating(OpId(1))],
        "op 1 waits for its button, whatever else is pressed"
    );
}

#[test]
fn a_button_that_means_nothing_here_is_refused_and_one_of_another_station_is_ignored() {
    let mut rig = in_hand_mode(2, &[6, 6, 6]);
    let later = hand_of(&rig, 1).forward().0;
    rig.hold(later);
    assert_eq!((rig.outputs, rig.events()), (0, vec!["rejected the command".to_owned()]));
    rig.release(later);
    rig.hold(31);
    assert_eq!(rig.events(), Vec::<String>::new(), "button 31 is none of this station's");
    rig.mode(ControlMode::StandBy);
    rig.release(31);
    rig.events();
    rig.hold(later);
    assert_eq!(rig.events(), Vec::<String>::new(), "outside hand mode nobody asked this station");
}

#[test]
fn two_buttons_pressed_in_one_image_mean_forward() {
    let mut rig = in_hand_mode(2, &[6, 6, 6]);
    let (hand, next) = (hand_of(&rig, 0), hand_of(&rig, 1));
    rig.hold(hand.forward().0);
    rig.arrive(0);
    rig.release(hand.forward().0);
    rig.order.buttons = 1 << hand.back().expect("type 6").0 | 1 << next.forward().0;
    rig.order();
    assert!(rig.drives(1));
}

/// The shipped clamp: one button both closes it and takes the opening back; the arrows decide.
#[test]
fn a_shared_button_goes_on_if_the_arrows_hold_back_if_not_and_nowhere_if_it_is_not_known() {
    let clamp = station("clamp", 0, &[r(6), r(6)], 0, true);
    let bar = station("bar", 1, &[r(6), r(6)], 8, false);
    let arrows = vec![linewright_testkit::built::arrow((1, 0), (0, 1), 0)];
    let both = line(vec![clamp, bar], arrows);
    let press = |bar_says: Option<&[i32]>| {
        let mut rig = Rig::new(both.clone());
        if let Some(done) = bar_says {
            rig.hear(StationId(1), super::rig::peer_says(done));
        }
        rig.mode(ControlMode::Hand);
        rig.hold(hand_of(&rig, 1).forward().0);
        rig.doing()
    };
    assert_eq!(press(Some(&[1, 0])), "op 1", "its cause is done: on");
    assert_eq!(press(Some(&[0, 0])), "undoing op 0", "its cause is not done: back");
    assert_eq!(press(None), "op 0 (done)", "unknown blocks the negated condition too");
}

#[test]
fn auto_takes_over_what_a_button_has_started_and_hand_mode_what_auto_has() {
    let mut rig = in_hand_mode(1, &[6, 6]);
    let button = hand_of(&rig, 0).forward().0;
    rig.hold(button);
    rig.release(button);
    rig.mode(ControlMode::Auto);
    assert!(rig.drives(0));
    rig.mode(ControlMode::Hand);
    assert_eq!(rig.outputs, 0, "it waits for its button");
    rig.hold(button);
    assert!(rig.drives(0));
}
