//! A task from its order to its end.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_station_logic::{TaskFailure, TaskOutcome, TaskReply};

use super::bench::{OrderBench, key, order};

#[test]
fn a_task_is_done_from_rest_to_rest_and_then_nothing_more_happens() {
    let mut m1 = OrderBench::new();
    assert_eq!(m1.rest().as_deref(), Some("open"));
    assert_eq!(m1.run(&order(1, "clamp")), TaskReply::Running);
    assert_eq!((m1.on(), m1.rest(), m1.slot()), (vec!["Y_close"], None, Some(key(1, 1))));
    m1.arrive();
    assert_eq!((m1.on(), m1.rest().as_deref(), m1.slot()), (vec![], Some("clamped"), None));
    assert_eq!(m1.result(key(1, 1)), Some(TaskOutcome::Done));
    m1.wait(Duration::from_secs(60));
    assert_eq!(m1.outputs, 0);
    assert_eq!(
        m1.events(),
        ["accepted a task order: clamp", "started clamp close", "completed clamp close", "completed task clamp"]
    );
}

#[test]
fn the_parameters_are_on_while_the_task_is_done_and_not_longer() {
    let mut m1 = OrderBench::machining();
    for motion in ["Y_in", "Y_mill", "Y_out"] {
        assert_eq!(m1.on(), [motion, "prog_1", "prog_4"]);
        m1.arrive();
    }
    assert_eq!((m1.on(), m1.rest().as_deref()), (vec![], Some("clamped")));
}

#[test]
fn a_task_that_ends_where_it_begins_is_done_once_for_each_order() {
    let mut m1 = OrderBench::clamped();
    for id in 2..5 {
        m1.done(&order(id, "machine"));
        assert_eq!(m1.outputs, 0, "it does not begin again");
        assert_eq!(m1.controller.report().done[1], id as i32 - 1);
    }
    m1.done(&order(5, "release"));
    assert_eq!(m1.rest().as_deref(), Some("open"));
    let report = m1.controller.report();
    assert_eq!((report.cycle, report.done, report.at_home), (5, vec![1, 3, 3, 3, 1], true));
}

#[test]
fn nothing_starts_before_what_it_waits_for_is_there_and_the_code_says_so_if_it_never_comes() {
    let mut m1 = OrderBench::new();
    m1.set("part_present", false);
    assert_eq!(m1.run(&order(1, "clamp")), TaskReply::Running);
    assert_eq!(m1.outputs, 0);
    assert_eq!(m1.blocked_by(), ["part_present (m1 io, node 02h, 6000h:01 bit 6) to be on, for clamp close"]);
    m1.wait(Duration::from_secs(19));
    m1.set("part_present", true);
    assert_eq!(m1.on(), ["Y_close"]);
    m1.arrive();
    m1.done(&order(2, "release"));

    m1.set("part_present", false);
    m1.run(&order(3, "clamp"));
    m1.wait(Duration::from_secs(20));
    assert_eq!(m1.result(key(1, 3)), Some(TaskOutcome::Failed(TaskFailure::Waiting(12))));
    assert_eq!((m1.slot(), m1.rest().as_deref()), (None, Some("open")));
    m1.set("part_present", true);
    assert_eq!(m1.outputs, 0, "an order that is over starts nothing");
}

#[test]
fn the_time_of_the_description_counts_where_the_order_leaves_more() {
    let mut m1 = OrderBench::new();
    m1.set("part_present", false);
    let mut long = order(1, "clamp");
    long.limit = Duration::from_secs(3600);
    m1.run(&long);
    m1.wait(Duration::from_millis(25_950));
    assert_eq!(m1.slot(), Some(key(1, 1)));
    m1.wait(Duration::from_millis(50));
    assert_eq!(m1.result(key(1, 1)), Some(TaskOutcome::Failed(TaskFailure::Waiting(12))), "limit_s = 26");
}

#[test]
fn in_stand_by_the_motion_ends_and_the_task_goes_on_in_auto() {
    let mut m1 = OrderBench::machining();
    m1.mode(ControlMode::StandBy);
    m1.arrive();
    assert_eq!((m1.doing(), m1.on()), ("slide in (done)".to_owned(), vec!["prog_1", "prog_4"]));
    m1.mode(ControlMode::Auto);
    assert_eq!(m1.on(), ["Y_mill", "prog_1", "prog_4"]);
}

#[test]
fn master_stop_lets_a_task_end_and_takes_no_other_on() {
    let mut m1 = OrderBench::new();
    m1.run(&order(1, "clamp"));
    m1.master_stop(true);
    m1.arrive();
    assert_eq!(m1.result(key(1, 1)), Some(TaskOutcome::Done));
    assert_eq!(m1.run(&order(2, "release")), TaskReply::Refused(linewright_station_logic::TaskRefusal::Mode));
    assert!(m1.controller.report().at_home && m1.controller.report().stopped);
    m1.master_stop(false);
    assert_eq!(m1.run(&order(2, "release")), TaskReply::Running);
}
