//! Leaving an order: back to where the task began, as far as it goes by itself.

use std::time::Duration;

use linewright_line::StationId;
use linewright_line::net::ControlMode;
use linewright_station_logic::{
    LeaveWay, PanelCommand, Restore, TaskFailure, TaskOrder, TaskOutcome, TaskRefusal, TaskReply,
};

use super::bench::{MEMORY, OrderBench, ended, key, order};

#[test]
fn told_to_go_back_it_ends_the_motion_and_takes_the_task_back() {
    let mut m1 = OrderBench::clamped();
    m1.events();
    m1.run(&order(2, "machine"));
    assert_eq!(m1.secure(key(1, 2)), TaskReply::Running);
    assert_eq!(m1.on(), ["Y_in", "prog_1", "prog_4"], "the motion under way ends");
    m1.arrive();
    assert_eq!(m1.on(), ["Y_out", "prog_1", "prog_4"], "and is taken back");
    assert_eq!(m1.run(&order(3, "release")), TaskReply::Refused(TaskRefusal::Busy));
    m1.arrive();
    assert_eq!((m1.on(), m1.rest().as_deref(), m1.slot()), (vec![], Some("clamped"), None));
    assert_eq!(m1.secure(key(1, 2)), ended(TaskFailure::Cancelled));
    assert_eq!(m1.run(&order(2, "machine")), ended(TaskFailure::Cancelled), "a copy of the order that comes late");
    assert_eq!(m1.controller.report().done[1], 0);
    m1.done(&order(3, "release"));
}

/// Which slot of a store is meant does not change on the way: neither where the order is over and the station goes back by itself, nor where
/// a person leads it, also after a restart.
#[test]
fn the_parameters_are_on_on_every_way_out_of_the_task() {
    let mut m1 = OrderBench::clamped();
    m1.run(&order(2, "machine"));
    m1.leave(key(1, 2), LeaveWay::Hold);
    m1.arrive();
    assert_eq!((m1.slot(), m1.on()), (None, vec![]), "it stands");
    m1.secure(key(1, 2));
    assert_eq!(m1.on(), ["Y_out", "prog_1", "prog_4"], "it goes back by itself");

    m1.mode(ControlMode::EStop);
    assert_eq!(m1.outputs, 0);
    let mut m1 = m1.killed(8);
    m1.mode(ControlMode::StandBy);
    assert_eq!(m1.outputs, 0, "no mode was given since");
    m1.mode(ControlMode::Manual);
    m1.hold(&[PanelCommand::Retract(true)]);
    assert_eq!(m1.on(), ["Y_out", "prog_1", "prog_4"], "{:?}", m1.blocked_by());
    m1.arrive();
    m1.hold(&[PanelCommand::Retract(false)]);
    assert_eq!((m1.rest().as_deref(), m1.on()), (Some("clamped"), vec![]));
    m1.hold(&[PanelCommand::Advance(true)]);
    assert_eq!(m1.on(), ["Y_in"], "a task that a person begins has none");
}

#[test]
fn what_cannot_be_taken_back_it_stays_with() {
    let mut m1 = OrderBench::machining();
    m1.arrive();
    assert_eq!(m1.secure(key(1, 2)), TaskReply::Running);
    m1.arrive();
    assert_eq!((m1.doing().as_str(), m1.on()), ("mill (done)", vec![]));
    assert_eq!(m1.result(key(1, 2)), Some(TaskOutcome::Failed(TaskFailure::Held)));
    assert_eq!(m1.blocked_by(), ["an operator: no task begins here; lead the station to a rest in manual"]);
    assert_eq!(m1.run(&order(3, "machine")), TaskReply::Refused(TaskRefusal::NotThere));
}

#[test]
fn told_in_the_last_motion_it_has_done_the_task_all_the_same() {
    let mut m1 = OrderBench::new();
    m1.run(&order(1, "clamp"));
    m1.secure(key(1, 1));
    m1.arrive();
    assert_eq!((m1.result(key(1, 1)), m1.rest().as_deref()), (Some(TaskOutcome::Done), Some("clamped")));
    assert_eq!(m1.secure(key(1, 1)), TaskReply::Ended(TaskOutcome::Done));
    assert_eq!(m1.outputs, 0, "what is done is not taken back");
}

#[test]
fn told_before_it_has_begun_it_does_not_begin() {
    let mut m1 = OrderBench::new();
    m1.set("part_present", false);
    m1.run(&order(1, "clamp"));
    m1.events();
    assert_eq!(m1.secure(key(1, 1)), ended(TaskFailure::Waiting(12)));
    assert_eq!(m1.events(), ["left task clamp on request, while it waited for an input (code 12)"]);
    m1.set("part_present", true);
    assert_eq!(m1.outputs, 0);
}

#[test]
fn told_before_the_order_itself_it_does_not_take_it_on_when_it_comes() {
    let mut m1 = OrderBench::new();
    assert_eq!(m1.secure(key(1, 1)), ended(TaskFailure::Cancelled));
    assert_eq!(m1.run(&order(1, "clamp")), ended(TaskFailure::Cancelled));
    assert_eq!(m1.outputs, 0);
    m1.done(&order(2, "clamp"));
    assert_eq!(m1.secure(key(1, 1)), ended(TaskFailure::Cancelled));
    let mut next = order(3, "release");
    next.key.epoch = 2;
    m1.run(&next);
    assert_eq!(m1.secure(key(1, 4)), TaskReply::Refused(TaskRefusal::OldEpoch));
}

/// Another station may rely on where it stands, which the coordinator alone can see.
#[test]
fn when_its_time_is_over_it_ends_the_motion_and_stands_until_it_is_told_to_go_back() {
    let mut m1 = OrderBench::clamped();
    let short = TaskOrder { limit: Duration::from_millis(500), ..order(2, "machine") };
    m1.run(&short);
    m1.wait(Duration::from_millis(500));
    assert_eq!((m1.doing().as_str(), m1.result(key(1, 2))), ("slide in", None), "it has not ended as long as it moves");
    m1.arrive();
    m1.wait(Duration::from_secs(60));
    let timed_out = TaskOutcome::Failed(TaskFailure::TimedOut);
    assert_eq!((m1.doing().as_str(), m1.result(key(1, 2))), ("slide in (done)", Some(timed_out)));
    assert_eq!(m1.secure(key(1, 2)), TaskReply::Running);
    m1.arrive();
    assert_eq!((m1.rest().as_deref(), m1.slot()), (Some("clamped"), None));
    assert_eq!(m1.orders().results.last(), Some(&(key(1, 2), timed_out)), "for what it was");
}

#[test]
fn told_to_go_back_in_the_motion_in_which_its_time_is_over_it_fails_with_that() {
    let mut m1 = OrderBench::clamped();
    m1.run(&TaskOrder { limit: Duration::from_millis(500), ..order(2, "machine") });
    m1.wait(Duration::from_millis(500));
    assert_eq!(m1.secure(key(1, 2)), TaskReply::Running);
    for doing in ["slide in", "undoing slide in"] {
        assert_eq!((m1.doing().as_str(), m1.result(key(1, 2))), (doing, None));
        m1.arrive();
    }
    assert_eq!(m1.result(key(1, 2)), Some(TaskOutcome::Failed(TaskFailure::TimedOut)));
}

/// It waits for a part that does not come: its failure does not depend on which time is over first.
#[test]
fn given_up_by_its_own_clock_or_by_another_it_fails_with_what_it_waited_for() {
    for told in [false, true] {
        let mut m1 = OrderBench::new();
        m1.set("part_present", false);
        let short = TaskOrder { limit: Duration::from_millis(500), ..order(1, "clamp") };
        m1.run(&short);
        m1.wait(Duration::from_millis(if told { 490 } else { 500 }));
        assert_eq!(m1.secure(key(1, 1)), ended(TaskFailure::Waiting(12)), "told: {told}");
    }
}

#[test]
fn it_goes_back_in_auto_alone_and_not_without_its_devices() {
    let mut m1 = OrderBench::machining();
    m1.mode(ControlMode::StandBy);
    m1.arrive();
    m1.secure(key(1, 2));
    assert_eq!(m1.doing(), "slide in (done)");
    m1.devices(false);
    m1.mode(ControlMode::Auto);
    assert_eq!(m1.doing(), "slide in (done)");
    m1.devices(true);
    assert_eq!(m1.on(), ["Y_out", "prog_1", "prog_4"]);
}

#[test]
fn a_fault_on_the_way_back_ends_it() {
    let mut m1 = OrderBench::machining();
    m1.secure(key(1, 2));
    m1.arrive();
    m1.wait(Duration::from_secs(3));
    assert_eq!(m1.doing(), "undoing slide in (stopped)");
    assert_eq!((m1.result(key(1, 2)), m1.slot()), (Some(TaskOutcome::Failed(TaskFailure::Held)), None));
    assert_eq!(m1.secure(key(1, 2)), ended(TaskFailure::Held), "what a fault has stopped waits for a person");
    assert_eq!(m1.outputs, 0);
}

/// The robot of the same description: a task of five operations, all of which can be taken back.
#[test]
fn a_long_task_is_taken_back_operation_by_operation_to_where_any_task_can_begin() {
    let mut robot = OrderBench::standing(StationId(1), Restore::Fresh, MEMORY, &["A_0", "G_0"]);
    robot.mode(ControlMode::Auto);
    robot.run(&order(1, "load m1"));
    // To the store, grasp, carry to m1. The machine never reports that it has clamped.
    for _ in 0..3 {
        robot.arrive();
    }
    assert_eq!(robot.doing(), "carry to m1 (done)");
    assert_eq!(robot.blocked_by(), ["m1_closed (robot io, node 03h, 6000h:01 bit 5) to be on, for let go"]);
    robot.secure(key(1, 1));
    for doing in ["undoing carry to m1", "undoing grasp", "undoing to the store"] {
        assert_eq!(robot.doing(), doing);
        robot.arrive();
    }
    assert_eq!(robot.doing(), "at rest \"home\"");
    assert_eq!(robot.orders().results, [(key(1, 1), TaskOutcome::Failed(TaskFailure::Waiting(21)))]);
    let report = robot.report();
    assert_eq!((report.done, report.started, report.cycle), (vec![0; 10], vec![0; 10], 1));
    robot.run(&order(2, "load m1"));
    assert_eq!(robot.doing(), "to the store");
}

/// The motion ends, the order too; it stands there, and may be ordered back afterwards.
#[test]
fn told_to_hold_it_ends_the_motion_and_stands_until_it_is_told_to_go_back() {
    let mut m1 = OrderBench::clamped();
    m1.run(&order(2, "machine"));
    assert_eq!((m1.leave(key(1, 2), LeaveWay::Hold), m1.on().first().copied()), (TaskReply::Running, Some("Y_in")));
    m1.arrive();
    m1.wait(Duration::from_secs(60));
    let held = TaskOutcome::Failed(TaskFailure::Held);
    assert_eq!((m1.doing().as_str(), m1.result(key(1, 2))), ("slide in (done)", Some(held)));
    assert_eq!(m1.leave(key(1, 2), LeaveWay::Hold), TaskReply::Ended(held), "a copy");
    assert_eq!(m1.secure(key(1, 2)), TaskReply::Running);
    m1.arrive();
    assert_eq!((m1.rest().as_deref(), m1.slot()), (Some("clamped"), None));
    // Before it is received an order is left the same way.
    assert_eq!(m1.leave(key(1, 3), LeaveWay::Hold), ended(TaskFailure::Cancelled));
    assert_eq!(m1.run(&order(3, "release")), ended(TaskFailure::Cancelled));
}

/// What its operations have waited for so far decides whether another station may rely on where it stands.
#[test]
fn a_station_is_in_a_handshake_from_the_first_operation_that_waits_until_that_is_taken_back() {
    let mut robot = OrderBench::standing(StationId(1), Restore::Fresh, MEMORY, &["A_0", "G_0"]);
    robot.mode(ControlMode::Auto);
    robot.run(&order(1, "load m1"));
    let mut seen = Vec::new();
    let mut look = |robot: &OrderBench| seen.push((robot.doing(), robot.orders().is_in_handshake));
    for _ in 0..3 {
        look(&robot);
        robot.arrive();
    }
    look(&robot);
    robot.set("m1_closed", true);
    look(&robot);
    robot.leave(key(1, 1), LeaveWay::Hold);
    robot.arrive();
    look(&robot);
    robot.secure(key(1, 1));
    for _ in 0..3 {
        look(&robot);
        robot.arrive();
    }
    let expected = [
        ("to the store", false),
        ("grasp", false),
        ("carry to m1", false),
        ("carry to m1 (done)", false),
        ("let go", true),
        ("let go (done)", true),
        ("undoing let go", true),
        ("undoing carry to m1", false),
        ("undoing grasp", false),
    ];
    assert_eq!(seen, expected.map(|(doing, is)| (doing.to_owned(), is)));
}
