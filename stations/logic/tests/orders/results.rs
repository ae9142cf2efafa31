//! Results of motions: the robot of the description, which looks into its hand when that has closed.

use std::time::Duration;

use linewright_line::StationId;
use linewright_line::net::ControlMode;
use linewright_station_logic::{LeaveWay, Restore, StationInput, TaskFailure, TaskOutcome, TaskReply};

use super::bench::{MEMORY, OrderBench, key, order};

const CLOSES: &str = "normal = { actuator = \"Y_grip\", complete = \"G_1\" }\n";
const RESULT: &str = "result = { input = \"part_in_hand\", within_s = 0.5, code = 24 }\n";
const CARRIES: &str = "normal = { actuator = \"Y_100\", complete = \"A_100\" }\n";
const WAITS: &str = "waits = [\"m1_closed\"]\nwaits_code = 23\n";

/// The robot in auto, on its way with an order to the store.
fn robot(change: impl Fn(String) -> String) -> OrderBench {
    let with_result = |text: String| {
        let text = text.replacen(CLOSES, &format!("{CLOSES}{RESULT}"), 1);
        change(text.replacen("\"m1_closed\", \"S0\"", "\"m1_closed\", \"part_in_hand\", \"S0\"", 1))
    };
    let mut robot = OrderBench::changed(with_result, StationId(1), Restore::Fresh, MEMORY, &["A_0", "G_0"]);
    robot.mode(ControlMode::Auto);
    assert_eq!(robot.run(&order(1, "load m1")), TaskReply::Running);
    robot.arrive();
    robot.events();
    robot
}

#[test]
fn a_hand_that_closes_on_nothing_ends_the_order_at_once() {
    let mut robot = robot(|text| text);
    robot.arrive();
    assert_eq!(robot.on(), ["slot_1", "slot_2"], "it does not leave the store");
    assert_eq!(robot.blocked_by(), ["part_in_hand (robot io, node 03h, 6000h:01 bit 6) to be on, after grasp"]);
    robot.wait(Duration::from_millis(450));
    assert_eq!(robot.slot(), Some(key(1, 1)));
    robot.wait(Duration::from_millis(50));
    assert_eq!(robot.result(key(1, 1)), Some(TaskOutcome::Failed(TaskFailure::Waiting(24))));
    let events = robot.events();
    assert!(events.last().is_some_and(|event| event.contains("code 24")), "{events:?}");
    assert_eq!(robot.slot(), None);
    assert!(!robot.orders().is_in_handshake, "it has gone nowhere where others rely on it");

    robot.leave(key(1, 1), LeaveWay::Back);
    assert_eq!(robot.on(), ["Y_open", "slot_1", "slot_2"], "it goes back by itself");
    robot.arrive();
    robot.arrive();
    assert_eq!(robot.rest().as_deref(), Some("home"));
}

#[test]
fn a_part_that_is_seen_in_time_is_carried_on() {
    let mut robot = robot(|text| text);
    robot.arrive();
    robot.wait(Duration::from_millis(450));
    robot.set("part_in_hand", true);
    assert_eq!(robot.on(), ["Y_100", "slot_1", "slot_2"]);
    robot.set("part_in_hand", false);
    robot.wait(Duration::from_secs(1));
    assert_eq!(robot.on(), ["Y_100", "slot_1", "slot_2"], "what is under way looks at it no more");
}

#[test]
fn a_part_that_was_seen_before_the_motion_ended_does_not_wait() {
    let mut robot = robot(|text| text);
    robot.set("part_in_hand", true);
    robot.arrive();
    assert_eq!(robot.on(), ["Y_100", "slot_1", "slot_2"]);
}

#[test]
fn a_part_that_is_lost_while_something_else_is_waited_for_ends_the_order() {
    let mut robot = robot(|text| text.replacen(CARRIES, &format!("{CARRIES}{WAITS}"), 1));
    robot.set("part_in_hand", true);
    robot.arrive();
    robot.wait(Duration::from_secs(5));
    assert_eq!(robot.slot(), Some(key(1, 1)), "for m1 it waits as long as the order permits");
    robot.set("part_in_hand", false);
    assert_eq!(robot.result(key(1, 1)), Some(TaskOutcome::Failed(TaskFailure::Waiting(24))));
}

/// Which inputs are off is not known while its devices are lost: that is another failure.
#[test]
fn nothing_is_missing_while_the_inputs_are_not_known() {
    let mut robot = robot(|text| text);
    robot.arrive();
    robot.devices(false);
    robot.wait(Duration::from_secs(1));
    assert_eq!(robot.slot(), Some(key(1, 1)));
    robot.devices(true);
    assert_eq!(robot.result(key(1, 1)), Some(TaskOutcome::Failed(TaskFailure::Waiting(24))));
}

/// Nor when the order's own time is over meanwhile.
#[test]
fn an_order_whose_time_is_over_while_the_inputs_are_not_known_did_not_wait_for_the_part() {
    let mut robot = robot(|text| text);
    robot.arrive();
    robot.devices(false);
    robot.wait(Duration::from_secs(25));
    let result = robot.result(key(1, 1));
    assert!(matches!(result, Some(TaskOutcome::Failed(of)) if of != TaskFailure::Waiting(24)), "{result:?}");
}

#[test]
fn an_order_that_is_left_before_the_time_of_its_result_did_not_wait_for_it() {
    let mut robot = robot(|text| text);
    robot.arrive();
    robot.wait(Duration::from_millis(100));
    robot.leave(key(1, 1), LeaveWay::Hold);
    assert_eq!(robot.result(key(1, 1)), Some(TaskOutcome::Failed(TaskFailure::Held)));
}

/// The part was seen while the machine stood still; the image of before does not show it.
#[test]
fn after_a_standstill_a_result_has_its_time_again() {
    let mut robot = robot(|text| text);
    robot.arrive();
    robot.wait(Duration::from_millis(400));
    let later = robot.now + Duration::from_secs(1);
    robot.now = later;
    robot.controller.handle(later, StationInput::Gap);
    robot.step();
    robot.set("part_in_hand", true);
    assert_eq!(robot.slot(), Some(key(1, 1)), "{:?}", robot.result(key(1, 1)));
}

/// An empty hand is led on to the rest as well: people see it, and what is lost must not keep the station half-way.
#[test]
fn in_manual_a_person_leads_on_without_the_part() {
    let mut robot = robot(|text| text);
    robot.arrive();
    robot.mode(ControlMode::Manual);
    assert_eq!(robot.result(key(1, 1)), Some(TaskOutcome::Failed(TaskFailure::Interrupted)));
    robot.advance(true);
    assert_eq!(robot.on(), ["Y_100", "slot_1", "slot_2"]);
}
