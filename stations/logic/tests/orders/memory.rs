//! Memory of a station after its controller was killed.

use linewright_line::net::ControlMode;
use linewright_station_logic::{Controller, PanelCommand, Restore, TaskFailure, TaskOutcome, TaskRefusal, TaskReply};

use super::bench::{MEMORY, OrderBench, ended, key, order};

#[test]
fn killed_in_a_motion_it_has_ended_the_order_and_says_so() {
    let mut m1 = OrderBench::new();
    m1.run(&order(1, "clamp"));
    let mut again = m1.killed(8);
    assert_eq!((again.doing().as_str(), again.outputs), ("clamp close (stopped)", 0));
    again.mode(ControlMode::Auto);
    assert_eq!(again.orders().memory, MEMORY, "another life, the same memory");
    assert_eq!(again.run(&order(1, "clamp")), ended(TaskFailure::Restarted));
    assert_eq!(again.run(&order(2, "clamp")), TaskReply::Refused(TaskRefusal::Incomplete));
}

#[test]
fn killed_before_it_has_begun_it_does_not_begin() {
    let mut m1 = OrderBench::new();
    m1.set("part_present", false);
    m1.run(&order(1, "clamp"));
    let mut again = m1.killed(8);
    again.mode(ControlMode::Auto);
    again.set("part_present", true);
    assert_eq!(again.outputs, 0);
    assert_eq!(again.run(&order(1, "clamp")), ended(TaskFailure::Restarted));
    again.done(&order(2, "clamp"));
}

#[test]
fn killed_after_its_last_motion_it_keeps_what_it_has_said() {
    let mut m1 = OrderBench::machining();
    m1.wait(std::time::Duration::from_millis(2_500));
    m1.arrive();
    m1.arrive();
    m1.secure(key(1, 2));
    m1.arrive();
    let kept = m1.orders().results;
    assert_eq!(kept.last(), Some(&(key(1, 2), TaskOutcome::Done)), "the last motion was under way");
    assert_eq!(m1.killed(8).orders().results, kept);
}

#[test]
fn what_it_has_had_and_what_it_has_refused_it_still_knows() {
    let mut m1 = OrderBench::new();
    let release = order(1, "release");
    assert_eq!(m1.run(&release), TaskReply::Refused(TaskRefusal::NotThere));
    m1.done(&order(2, "clamp"));
    let mut again = m1.killed(8);
    again.mode(ControlMode::Auto);
    assert_eq!(again.run(&release), TaskReply::Refused(TaskRefusal::NotThere));
    assert_eq!(again.run(&order(2, "clamp")), TaskReply::Ended(TaskOutcome::Done));
    assert_eq!(again.rest().as_deref(), Some("clamped"));
    again.done(&order(3, "release"));
    assert_eq!(again.killed(9).controller.snapshot(), again.controller.snapshot());
}

#[test]
fn without_its_memory_it_takes_no_order_that_was_meant_for_it() {
    let m1 = OrderBench::new();
    let mut fresh = OrderBench::of(Restore::Fresh, 8);
    fresh.mode(ControlMode::Auto);
    fresh.set("part_present", true);
    assert_eq!((m1.orders().memory, fresh.orders().memory), (7, 8));
    assert_eq!(fresh.run(&order(1, "clamp")), TaskReply::Refused(TaskRefusal::OtherMemory));
    let meant = linewright_station_logic::TaskOrder { memory: 8, ..order(1, "clamp") };
    assert_eq!(fresh.run(&meant), TaskReply::Running);
}

#[test]
fn a_snapshot_of_any_length_is_taken_and_no_longer_than_it_may_be_afterwards() {
    let m1 = OrderBench::new();
    let mut snapshot = m1.controller.snapshot();
    let orders = snapshot.order.as_mut().expect("it is task-driven");
    orders.results = (1..100).map(|id| (key(1, id), TaskReply::Ended(TaskOutcome::Done))).collect();
    orders.slot = Some(key(1, 100));
    orders.last = 100;
    let again = Controller::new(&m1.line, m1.station, 8, Restore::From(snapshot)).expect("it fits");
    let kept = again.snapshot().order.expect("it is task-driven");
    assert_eq!((kept.results.len(), kept.slot), (16, None));
    assert_eq!(kept.results.last(), Some(&(key(1, 100), ended(TaskFailure::Restarted))));
}

/// A coordinator that has lost its records begins a later life, and counts from 1.
#[test]
fn numbers_begin_anew_with_a_later_epoch() {
    let of = |epoch, id, task| linewright_station_logic::TaskOrder { key: key(epoch, id), ..order(id, task) };
    let mut m1 = OrderBench::new();
    m1.mode(ControlMode::Auto);
    m1.set("part_present", true);
    m1.done(&of(1, 40, "clamp"));
    m1.done(&of(2, 1, "release"));
    assert_eq!(m1.run(&of(1, 41, "clamp")), TaskReply::Refused(TaskRefusal::OldEpoch));
    assert_eq!(m1.run(&of(2, 1, "release")), TaskReply::Ended(TaskOutcome::Done));
    m1.mode(ControlMode::StandBy);
    // Received and not taken on: the life is known, and none of its orders is.
    assert_eq!(m1.run(&of(3, 1, "clamp")), TaskReply::Refused(TaskRefusal::Mode));
    m1.mode(ControlMode::Auto);
    assert_eq!(m1.run(&of(3, 1, "clamp")), TaskReply::Running);
}

/// The message to leave an order has neither its sender nor the memory it is meant for.
#[test]
fn a_message_to_leave_an_order_of_any_epoch_keeps_no_other_order_out() {
    for epoch in [2, 1 << 29, u64::MAX] {
        let mut m1 = OrderBench::clamped();
        m1.secure(key(epoch, 7));
        assert_eq!(m1.is_taken, epoch != u64::MAX, "what is of no coordinator's life is ignored, and told");
        assert_eq!(m1.orders().epoch, 1);
        m1.done(&order(2, "release"));
        // The order that it names is left all the same.
        let named = linewright_station_logic::TaskOrder { key: key(epoch, 7), ..order(7, "clamp") };
        assert_eq!(m1.run(&named), ended(TaskFailure::Cancelled));
    }
}

#[test]
fn an_order_of_an_epoch_far_ahead_is_not_taken_on() {
    let mut m1 = OrderBench::clamped();
    let far = linewright_station_logic::TaskOrder { key: key(u64::MAX, 1), ..order(1, "release") };
    assert_eq!(m1.run(&far), TaskReply::Refused(TaskRefusal::OtherMemory));
    assert!(!m1.is_taken);
    m1.done(&order(2, "release"));
}

#[test]
fn killed_after_it_was_told_to_leave_an_order_it_does_not_go_back_on_a_late_copy_of_that() {
    let mut m1 = OrderBench::machining();
    m1.mode(ControlMode::Manual);
    m1.through(PanelCommand::Advance(true));
    m1.secure(key(1, 2));
    let mut again = m1.killed(8);
    again.mode(ControlMode::Auto);
    assert_eq!((again.doing().as_str(), again.rest()), ("slide in (done)", None));
    assert_eq!(again.secure(key(1, 2)), ended(TaskFailure::Interrupted));
    assert_eq!((again.outputs, again.slot()), (0, None));
}
