//! Hand mode by the topic `buttons`: one step of the cycle forward and back, and what a lost message does.

use std::time::Duration;

use linewright_msgs::StationState;

use crate::support::operator::Operator;
use crate::support::pause;
use crate::support::rig::{Rig, line};

#[test]
fn a_held_button_runs_a_step_and_its_partner_runs_it_back() {
    // Four lifts of half a second: time to let go in between.
    let mut rig = Rig::new(&line(4.0));
    let operator = rig.in_stand_by();
    operator.order("hand", StationState::MODE_HAND);

    let up = operator.hold_buttons("PB_2");
    rig.eye.wait("up", |seen| seen.input("transfer", "LS_vertical_200") && seen.energised().is_empty());
    drop(up);
    pause(300);
    let down = operator.hold_buttons("PB_4");
    rig.eye.wait("down", |seen| seen.input("transfer", "LS_vertical_0") && seen.energised().is_empty());
    drop(down);
    pause(300);
    let order: Vec<String> = rig.eye.seen().starts().iter().map(|start| start.what.clone()).collect();
    let step = ["lift_to_50", "lift_to_100", "lift_to_150", "lift_to_200"];
    let back = ["lower_to_150", "lower_to_100", "lower_to_50", "lower_to_0"];
    let expected: Vec<String> = step.iter().chain(&back).map(|output| format!("transfer: {output}")).collect();
    assert_eq!(order, expected);
    let done = &operator.station("transfer").done;
    assert!(done.iter().all(|count| *count == 0), "taken back, counts and all: {done:?}");

    a_released_button_stops_the_motion(&rig, &operator);
    a_late_refresh_does_not_go_on(&rig, &operator);
    assert_eq!(rig.eye.seen().conflicts(), [""; 0]);
}

fn a_released_button_stops_the_motion(rig: &Rig, operator: &Operator) {
    let finger = operator.hold_buttons("PB_2");
    rig.eye.wait("it lifts", |seen| seen.output("transfer", "lift_to_100"));
    drop(finger);
    rig.eye.within(Duration::from_secs(2), "off", |seen| seen.energised().is_empty());
    let started = rig.eye.seen().starts().len();
    pause(700);
    assert_eq!(rig.eye.seen().starts().len(), started, "and stays off");
    assert!(!rig.eye.seen().input("transfer", "LS_vertical_200"), "half-way");
}

fn a_late_refresh_does_not_go_on(rig: &Rig, operator: &Operator) {
    let finger = operator.hold_buttons("PB_2");
    rig.eye.wait("it lifts on", |seen| !seen.energised().is_empty());
    finger.mute(true);
    // Between two lifts nothing is on for a moment either.
    operator.wait("it waits for the button", |heard| {
        heard.station("transfer").blocked_by.iter().any(|why| why.contains("PB_2 to be held"))
    });
    assert!(rig.eye.seen().energised().is_empty());
    // Longer than a button's word counts, shorter than a silence that would have been a release.
    pause(300);
    let started = rig.eye.seen().starts().len();
    finger.mute(false);
    pause(1000);
    assert_eq!(rig.eye.seen().starts().len(), started, "the finger never left: nobody decided to go on");
    drop(finger);
    pause(300);
    let finger = operator.hold_buttons("PB_2");
    rig.eye.wait("pressed anew it goes on", |seen| seen.input("transfer", "LS_vertical_200"));
    drop(finger);
}
