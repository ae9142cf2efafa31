//! Replies of a station to an order, sent once, twice, too early and too late.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_station_logic::{Handled, Ignored, TaskFailure, TaskOrder, TaskOutcome, TaskRefusal, TaskReply};

use super::bench::{OrderBench, key, order};

fn refused(m1: &mut OrderBench, order: &TaskOrder) -> TaskRefusal {
    let before = (m1.marking(), m1.outputs, m1.slot());
    match m1.run(order) {
        TaskReply::Refused(refusal) => {
            assert_eq!((m1.marking(), m1.outputs, m1.slot()), before, "{refusal:?} moves nothing");
            refusal
        }
        other => panic!("{order:?}: {other:?}"),
    }
}

#[test]
fn an_order_told_again_is_answered_with_what_there_is_and_not_done_again() {
    let mut m1 = OrderBench::new();
    let clamp = order(1, "clamp");
    assert_eq!(m1.run(&clamp), TaskReply::Running);
    assert_eq!(m1.run(&clamp), TaskReply::Running);
    m1.arrive();
    assert_eq!(m1.run(&clamp), TaskReply::Ended(TaskOutcome::Done));
    m1.done(&order(2, "release"));
    assert_eq!(m1.run(&clamp), TaskReply::Ended(TaskOutcome::Done), "though it stands where the task begins");
    assert_eq!(m1.outputs, 0);
    assert_eq!(m1.controller.report().done[0], 1);
}

#[test]
fn what_is_refused_for_now_is_taken_on_later() {
    let mut m1 = OrderBench::new();
    m1.run(&order(1, "clamp"));
    assert_eq!(refused(&mut m1, &order(2, "release")), TaskRefusal::Busy);
    m1.arrive();
    for mode in [ControlMode::StandBy, ControlMode::Hand, ControlMode::Manual, ControlMode::EStop, ControlMode::Home] {
        m1.mode(mode);
        assert_eq!(refused(&mut m1, &order(2, "release")), TaskRefusal::Mode, "{mode}");
    }
    m1.mode(ControlMode::Auto);
    let elsewhere = TaskOrder { memory: 8, ..order(2, "release") };
    assert_eq!(refused(&mut m1, &elsewhere), TaskRefusal::OtherMemory);
    assert_eq!(m1.run(&order(2, "release")), TaskReply::Running);
}

#[test]
fn a_lease_that_has_run_out_is_no_auto() {
    let mut m1 = OrderBench::new();
    m1.now = m1.now + Duration::from_secs(1);
    assert_eq!(refused(&mut m1, &order(1, "clamp")), TaskRefusal::Mode);
}

#[test]
fn what_is_refused_for_good_stays_refused_when_the_reason_has_gone() {
    let mut m1 = OrderBench::new();
    let release = order(1, "release");
    assert_eq!(refused(&mut m1, &release), TaskRefusal::NotThere);
    m1.done(&order(2, "clamp"));
    assert_eq!(refused(&mut m1, &release), TaskRefusal::NotThere, "a copy that was late");
    m1.devices(false);
    let machine = order(3, "machine");
    assert_eq!(refused(&mut m1, &machine), TaskRefusal::Devices);
    m1.devices(true);
    assert_eq!(refused(&mut m1, &machine), TaskRefusal::Devices);
    assert_eq!(m1.orders().results, [(key(1, 2), TaskOutcome::Done)], "a refusal is no result");
    assert_eq!(m1.orders().refused, [(key(1, 1), TaskRefusal::NotThere), (key(1, 3), TaskRefusal::Devices)]);
}

#[test]
fn an_order_of_an_earlier_life_or_an_older_one_is_refused() {
    let mut m1 = OrderBench::new();
    m1.done(&order(4, "clamp"));
    assert_eq!(refused(&mut m1, &order(3, "release")), TaskRefusal::Old);
    let mut next = order(5, "release");
    next.key.epoch = 2;
    m1.done(&next);
    assert_eq!(m1.orders().epoch, 2);
    assert_eq!(refused(&mut m1, &order(6, "clamp")), TaskRefusal::OldEpoch);
    let mut late = order(6, "clamp");
    late.key.epoch = 2;
    assert_eq!(m1.run(&late), TaskReply::Running);
}

#[test]
fn of_an_order_it_no_longer_knows_it_says_that_it_has_had_it() {
    let mut m1 = OrderBench::new();
    for round in 0..9 {
        m1.done(&order(2 * round + 1, "clamp"));
        m1.done(&order(2 * round + 2, "release"));
    }
    assert_eq!(m1.orders().results.len(), 16);
    assert_eq!(refused(&mut m1, &order(2, "release")), TaskRefusal::Old);
    assert_eq!(m1.run(&order(3, "clamp")), TaskReply::Ended(TaskOutcome::Done));
}

#[test]
fn a_task_or_a_number_that_is_not_there_is_refused_and_none_is_guessed() {
    let mut m1 = OrderBench::clamped();
    let with = |id, parameters: &[(&str, i32)]| TaskOrder {
        parameters: parameters.iter().map(|(name, value)| ((*name).into(), *value)).collect(),
        ..order(id, "machine")
    };
    let wrong = [
        order(2, "drill"),
        with(3, &[]),
        with(4, &[("programme", 1)]),
        with(5, &[("program", 8)]),
        with(6, &[("program", -1)]),
        with(7, &[("program", 1), ("slot", 2)]),
        with(8, &[("program", 1), ("program", 1)]),
    ];
    for order in &wrong {
        assert_eq!(refused(&mut m1, order), TaskRefusal::Unknown, "{order:?}");
    }
    assert_eq!(m1.run(&with(9, &[("program", 0)])), TaskReply::Running);
    assert_eq!(m1.on(), ["Y_in"]);
}

#[test]
fn an_order_heard_when_its_time_is_over_is_not_begun() {
    let mut m1 = OrderBench::new();
    let late = TaskOrder { limit: Duration::ZERO, ..order(1, "clamp") };
    assert_eq!(refused(&mut m1, &late), TaskRefusal::Late);
    assert_eq!(refused(&mut m1, &order(1, "clamp")), TaskRefusal::Late, "nor a copy that claims to have time");
}

#[test]
fn after_a_fault_it_takes_nothing_on_until_somebody_has_been_there() {
    let mut m1 = OrderBench::machining();
    m1.arrive();
    m1.set("F_mill", true);
    assert_eq!(m1.result(key(1, 2)), Some(TaskOutcome::Failed(TaskFailure::Fault)));
    m1.set("F_mill", false);
    assert_eq!(refused(&mut m1, &order(3, "machine")), TaskRefusal::Incomplete);
}

#[test]
fn a_station_that_goes_round_a_cycle_takes_no_orders() {
    let line =
        linewright_line::parse("line.toml", &linewright_line::TransferLine::default().text()).expect("sound").line;
    let station = linewright_line::StationId(0);
    let restore = linewright_station_logic::Restore::Fresh;
    let mut controller = linewright_station_logic::Controller::new(&line, station, 1, restore).expect("compiles");
    let clamp = order(1, "clamp");
    let command = linewright_station_logic::TaskCommand::Run(&clamp);
    let handled = controller.handle(linewright_line::Tick::ZERO, linewright_station_logic::StationInput::Task(command));
    assert_eq!(handled, Handled::Ignored(Ignored::NoTasks));
    assert_eq!(controller.report().order, None);
    assert_eq!(controller.snapshot().order, None);
}
