//! What follows for a goal from what has become of its order.

use linewright_coordinator_node::cell::{GoalStep, step_of};
use linewright_msgs::{DispatchOrderResult as Result, ProductionState as Order, Time};
use linewright_node_shell::GoalEnd;

fn order(status: u8, done: u32, is_over: bool) -> Order {
    let ended = if is_over { Time { sec: 1, nanosec: 0 } } else { Time::default() };
    Order { id: 4, quantity: 3, status, done, ended, ..Order::default() }
}

#[test]
fn progress_is_told_once_and_the_end_ends_the_goal() {
    let step = |told: &Order, now: &Order, is_cancelled| step_of(told, Some(now), is_cancelled);
    let working = order(Order::STATUS_IN_WORK, 1, false);
    assert_eq!(step(&Order::default(), &working, false), GoalStep::Tell);
    assert_eq!(step(&working, &Order { text: "in work, still".into(), ..working.clone() }, false), GoalStep::Wait);
    assert_eq!(step(&working, &order(Order::STATUS_IN_WORK, 2, false), false), GoalStep::Tell);
    // A goal whose order is made although it was to be cancelled has reached what it was for.
    for is_cancelled in [false, true] {
        let done = order(Order::STATUS_DONE, 3, true);
        assert_eq!(step(&working, &done, is_cancelled), GoalStep::End(GoalEnd::Succeeded, Result::END_DONE));
    }
}

#[test]
fn a_cancelled_order_ends_its_goal_when_all_of_it_is_out() {
    let working = order(Order::STATUS_IN_WORK, 1, false);
    let inside = order(Order::STATUS_CANCELLED, 1, false);
    assert_eq!(step_of(&working, Some(&inside), true), GoalStep::Tell);
    let out = order(Order::STATUS_CANCELLED, 2, true);
    assert_eq!(step_of(&inside, Some(&out), true), GoalStep::End(GoalEnd::Canceled, Result::END_CANCELLED));
    assert_eq!(step_of(&inside, Some(&out), false), GoalStep::End(GoalEnd::Aborted, Result::END_CANCELLED));
    let withdrawn = order(Order::STATUS_WITHDRAWN, 0, true);
    assert_eq!(step_of(&working, Some(&withdrawn), true), GoalStep::End(GoalEnd::Canceled, Result::END_WITHDRAWN));
    assert_eq!(step_of(&working, None, true), GoalStep::End(GoalEnd::Aborted, Result::END_UNKNOWN));
}
