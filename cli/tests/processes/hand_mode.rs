//! Hand mode by the topic `buttons`: one step of the cycle forward and back.

use linewright_msgs::StationState;

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

    assert_eq!(rig.eye.seen().conflicts(), [""; 0]);
}
