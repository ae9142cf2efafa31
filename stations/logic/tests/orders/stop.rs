//! Ordered to stop: it stands where it is, and stays there until a person leads on.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_station_logic::{OrderRules, PanelCommand, TaskFailure, TaskOrder, TaskOutcome, TaskRefusal, TaskReply};

use super::bench::{OrderBench, ended, key, order};

/// On its way in with the part, by order 2.
fn sliding() -> OrderBench {
    let mut m1 = OrderBench::machining();
    m1.set("L_0", false);
    m1.events();
    m1
}

#[test]
fn told_to_stop_it_stands_at_once_and_a_person_leads_on() {
    let mut m1 = sliding();
    assert_eq!(m1.stop(key(1, 2)), ended(TaskFailure::Stopped));
    assert_eq!((m1.on(), m1.doing().as_str()), (vec![], "slide in (stopped)"));
    assert_eq!((m1.slot(), m1.rest()), (None, None));
    assert_eq!(m1.events()[0], "stopped slide in: stop requested by the coordinator");
    m1.wait(Duration::from_secs(30));
    assert_eq!(m1.run(&order(2, "machine")), ended(TaskFailure::Stopped), "a copy of the order that comes late");
    assert_eq!(m1.secure(key(1, 2)), ended(TaskFailure::Stopped), "and one of a message to leave it");
    assert_eq!(m1.run(&order(3, "machine")), TaskReply::Refused(TaskRefusal::Incomplete));
    assert_eq!((m1.on(), m1.doing().as_str()), (vec![], "slide in (stopped)"));

    m1.mode(ControlMode::Manual);
    m1.through(PanelCommand::Retract(true));
    assert_eq!(m1.rest().as_deref(), Some("clamped"));
    m1.mode(ControlMode::Auto);
    assert_eq!(m1.outputs, 0, "nothing goes on by itself");
    m1.done(&order(4, "release"));
}

/// Between two motions nothing is incomplete, and yet nothing goes back: not for late copies, not after a restart.
#[test]
fn stopped_between_two_motions_it_does_not_go_back_either() {
    let mut m1 = sliding();
    m1.mode(ControlMode::StandBy);
    m1.arrive();
    assert_eq!(m1.doing(), "slide in (done)");
    assert_eq!(m1.stop(key(1, 2)), ended(TaskFailure::Stopped));
    m1.mode(ControlMode::Auto);
    let mut again = m1.killed(8);
    again.mode(ControlMode::Auto);
    for m1 in [&mut m1, &mut again] {
        assert_eq!(m1.secure(key(1, 2)), ended(TaskFailure::Stopped));
        assert_eq!((m1.outputs, m1.slot(), m1.doing().as_str()), (0, None, "slide in (done)"));
        assert_eq!(m1.run(&order(3, "machine")), TaskReply::Refused(TaskRefusal::NotThere));
    }
}

#[test]
fn told_to_stop_on_its_way_back_it_stands_there() {
    let mut m1 = sliding();
    m1.secure(key(1, 2));
    m1.arrive();
    assert_eq!(m1.doing(), "undoing slide in");
    assert_eq!(m1.stop(key(1, 2)), ended(TaskFailure::Stopped));
    assert_eq!((m1.outputs, m1.doing().as_str()), (0, "undoing slide in (stopped)"));

    // Its own time was over before: that is still why.
    let mut m1 = OrderBench::clamped();
    m1.run(&TaskOrder { limit: Duration::from_millis(500), ..order(2, "machine") });
    m1.wait(Duration::from_millis(500));
    assert_eq!(m1.stop(key(1, 2)), ended(TaskFailure::TimedOut));
    assert_eq!(m1.outputs, 0);
}

#[test]
fn killed_before_it_hears_of_the_stop_it_stays_where_that_has_left_it() {
    let mut m1 = sliding().killed(8);
    m1.mode(ControlMode::Auto);
    assert_eq!(m1.stop(key(1, 2)), ended(TaskFailure::Restarted));
    assert_eq!(m1.secure(key(1, 2)), ended(TaskFailure::Restarted));
    assert_eq!((m1.outputs, m1.doing().as_str()), (0, "slide in (stopped)"));
}

#[test]
fn a_stop_is_about_one_order_alone() {
    let mut m1 = sliding();
    assert_eq!(m1.stop(key(1, 1)), TaskReply::Ended(TaskOutcome::Done), "what is done is not stopped");
    assert_eq!(m1.on(), ["Y_in", "prog_1", "prog_4"], "nor is what came after it");
    assert_eq!(m1.stop(key(1, 3)), ended(TaskFailure::Cancelled));
    assert_eq!(m1.slot(), Some(key(1, 2)), "nor what came before");
    assert_eq!(m1.run(&order(3, "machine")), ended(TaskFailure::Cancelled), "and that one is not begun");
}

#[test]
fn told_before_it_has_begun_it_does_not_begin() {
    let mut m1 = OrderBench::new();
    m1.set("part_present", false);
    m1.run(&order(1, "clamp"));
    assert_eq!(m1.stop(key(1, 1)), ended(TaskFailure::Waiting(12)));
    m1.set("part_present", true);
    assert_eq!((m1.outputs, m1.rest().is_some()), (0, true));
    m1.done(&order(2, "clamp"));
}

/// Where people move it, a message that comes late takes nothing out of their hands.
#[test]
fn a_copy_that_comes_late_does_not_stop_a_person() {
    let mut m1 = sliding();
    m1.stop(key(1, 2));
    m1.mode(ControlMode::Manual);
    m1.hold(&[PanelCommand::Retract(true)]);
    let driven = m1.outputs;
    assert_ne!(driven, 0);
    m1.stop(key(1, 2));
    assert_eq!(m1.outputs, driven);
}

#[test]
fn without_its_rule_it_goes_back() {
    let mut m1 = sliding();
    m1.controller =
        m1.controller.clone().with_order_rules(OrderRules { stops_at_once: false, ..OrderRules::default() });
    assert_eq!(m1.stop(key(1, 2)), TaskReply::Running);
    assert_eq!(m1.on(), ["Y_in", "prog_1", "prog_4"]);
}
