//! A task-driven station that stands at another rest than its chart has it: a person looks, and confirms it.

use std::sync::Arc;

use linewright_line::StationId;
use linewright_line::net::ControlMode;
use linewright_station_logic::PanelCommand::{Advance, Retract};
use linewright_station_logic::{Handled, Ignored, RejoinAt, Restore, StationInput};

use super::bench::{MEMORY, OrderBench, order};

/// By its journal it holds a part; its switches are these.
fn clamped_by_its_journal(on: &[&str]) -> OrderBench {
    let kept = OrderBench::clamped().controller.snapshot();
    let mut m1 = OrderBench::measured(Restore::From(kept), on);
    m1.mode(ControlMode::Manual);
    m1
}

fn rejoin(m1: &mut OrderBench, at: RejoinAt) -> Handled {
    rejoin_with(m1, at, &[])
}

fn rejoin_with(m1: &mut OrderBench, at: RejoinAt, numbers: &[(&str, i32)]) -> Handled {
    let numbers: Vec<(Arc<str>, i32)> = numbers.iter().map(|&(name, number)| (name.into(), number)).collect();
    let now = m1.now;
    let handled = m1.controller.handle(now, StationInput::Rejoin(at, &numbers));
    m1.refresh();
    handled
}

#[test]
fn the_one_rest_that_its_switches_fit_is_confirmed_and_tasks_begin_there() {
    let mut m1 = clamped_by_its_journal(&["C_0", "L_0"]);
    assert_eq!(m1.rest().as_deref(), Some("clamped"));
    assert!(m1.controller.position_lost().is_some());
    assert!(m1.fault().contains("confirm it with rejoin"), "{}", m1.fault());
    let waits = m1.blocked_by().join("\n");
    assert!(
        waits.contains("rejoin: axis not where the chart has it; by its switches it stands at rest `open`"),
        "{waits}"
    );
    assert!(rejoin(&mut m1, RejoinAt::Measured).is_taken());
    assert_eq!((m1.rest().as_deref(), m1.fault().as_str()), (Some("open"), ""));
    assert!(!m1.blocked_by().join("\n").contains("rejoin"));
    m1.mode(ControlMode::Auto);
    m1.set("part_present", true);
    m1.done(&order(2, "clamp"));
    // The counts of its record are those of a station that it is taken for again.
    let kept = m1.controller.snapshot();
    assert_eq!(OrderBench::measured(Restore::From(kept), &["C_60", "L_0"]).fault(), "");
}

#[test]
fn without_its_journal_it_is_confirmed_where_it_stands() {
    let mut m1 = OrderBench::measured(Restore::Fresh, &["C_60", "L_0"]);
    m1.mode(ControlMode::Manual);
    let waits = m1.blocked_by().join("\n");
    assert!(waits.contains("no valid journal; by its switches it stands at rest `clamped`"), "{waits}");
    assert!(rejoin(&mut m1, RejoinAt::Measured).is_taken());
    assert_eq!((m1.rest().as_deref(), m1.fault().as_str()), (Some("clamped"), ""));
}

#[test]
fn a_named_rest_is_taken_if_its_switches_fit_it_and_a_known_position_not_at_all() {
    let mut m1 = clamped_by_its_journal(&["C_0", "L_0"]);
    let rest = |m1: &OrderBench, name| RejoinAt::Rest(m1.line.station(m1.station).rest_named(name).expect("it is one"));
    let (open, clamped) = (rest(&m1, "open"), rest(&m1, "clamped"));
    assert_eq!(rejoin(&mut m1, clamped), Handled::Ignored(Ignored::PositionUnclear));
    assert!(rejoin(&mut m1, open).is_taken());
    for at in [open, clamped, RejoinAt::Measured] {
        assert_eq!(rejoin(&mut m1, at), Handled::Ignored(Ignored::NotLost));
    }
    assert_eq!(m1.rest().as_deref(), Some("open"));
}

#[test]
fn between_two_switches_the_operation_is_named_and_its_panel_leads_it_on() {
    let mut m1 = clamped_by_its_journal(&["L_0"]);
    assert_eq!(rejoin(&mut m1, RejoinAt::Measured), Handled::Ignored(Ignored::PositionUnclear));
    let waits = m1.blocked_by().join("\n");
    assert!(waits.contains("possible: `clamp close`, `clamp open`"), "{waits}");
    let opens = m1.line.station(m1.station).operation_named("clamp open");
    assert!(rejoin(&mut m1, opens.into()).is_taken());
    assert_eq!((m1.doing().as_str(), m1.outputs), ("clamp open (stopped)", 0), "nothing moves by it");
    let waits = m1.blocked_by().join("\n");
    assert!(waits.contains("advance (go on) or return (take back) at its panel in manual, for clamp open"), "{waits}");
    m1.through(Advance(true));
    assert_eq!((m1.rest().as_deref(), m1.fault().as_str()), (Some("open"), ""));
}

/// The hand opened over no place: the outputs that choose a slot were off after the confirmation, whichever way it was led.
#[test]
fn within_a_task_its_parameters_are_confirmed_with_the_place_and_are_on_again() {
    let mut m1 = OrderBench::measured(Restore::Fresh, &["C_60"]);
    m1.mode(ControlMode::Manual);
    let slide: RejoinAt = m1.line.station(m1.station).operation_named("slide in").into();
    let clamp: RejoinAt = m1.line.station(m1.station).operation_named("clamp close").into();
    let waits = m1.blocked_by().join("\n");
    assert!(waits.contains("the numbers of its task are lost: give them too (--with program=NUMBER)"), "{waits}");
    let refused = [
        (slide, &[][..], Ignored::NumberMissing),
        (slide, &[("program", 8)], Ignored::NumberOutOfRange),
        (slide, &[("program", -1)], Ignored::NumberOutOfRange),
        (slide, &[("slot", 5)], Ignored::NumberMissing),
        (slide, &[("program", 5), ("slot", 5)], Ignored::NoSuchNumber),
        (slide, &[("program", 5), ("program", 4)], Ignored::NoSuchNumber),
        (clamp, &[("program", 5)], Ignored::PositionUnclear),
    ];
    for (at, numbers, why) in refused {
        assert_eq!(rejoin_with(&mut m1, at, numbers), Handled::Ignored(why), "{numbers:?}");
        assert!(m1.outputs == 0 && m1.blocked_by().join("\n").contains("rejoin: "), "nothing has changed");
    }
    assert!(rejoin_with(&mut m1, slide, &[("program", 4)]).is_taken());
    assert_eq!((m1.doing().as_str(), m1.on()), ("slide in (stopped)", vec!["prog_4"]));
    // A number that was wrong; the position is known by now.
    assert_eq!(rejoin_with(&mut m1, slide, &[("program", 8)]), Handled::Ignored(Ignored::NumberOutOfRange));
    assert_eq!(rejoin_with(&mut m1, clamp, &[("program", 5)]), Handled::Ignored(Ignored::NotLost));
    assert!(rejoin_with(&mut m1, slide, &[("program", 5)]).is_taken());
    let kept = m1.controller.snapshot();
    for way in [Advance(true), Retract(true)] {
        let mut m1 = OrderBench::measured(Restore::From(kept.clone()), &["C_60"]);
        m1.mode(ControlMode::StandBy);
        assert_eq!(m1.outputs, 0, "where nobody leads it they are off");
        m1.mode(ControlMode::Manual);
        m1.hold(&[way]);
        let actuator = if way == Advance(true) { "Y_in" } else { "Y_out" };
        assert_eq!(m1.on(), [actuator, "prog_1", "prog_4"], "{:?}", m1.blocked_by());
    }
}

/// Switched on away from home without its journal it is taken back only after it was confirmed: by *return* it went back through a task
/// whose slot was not known, and opened its hand there.
#[test]
fn it_is_not_taken_back_through_a_task_whose_numbers_are_not_known() {
    let mut robot = OrderBench::standing(StationId(1), Restore::Fresh, MEMORY, &["G_0"]);
    robot.mode(ControlMode::Manual);
    assert_eq!(robot.doing(), "home from m1 (stopped)");
    robot.hold(&[Retract(true)]);
    assert_eq!(robot.outputs, 0, "{:?}", robot.blocked_by());
    robot.hold(&[]);
    assert!(!robot.blocked_by().join("\n").contains("return"), "{:?}", robot.blocked_by());
    // Whatever stops it then, and after another start as well.
    robot.hold(&[Advance(true)]);
    robot.hold(&[]);
    let kept = robot.controller.snapshot();
    let mut again = OrderBench::standing(StationId(1), Restore::From(kept), MEMORY, &["G_0"]);
    again.mode(ControlMode::Manual);
    for robot in [&mut robot, &mut again] {
        robot.hold(&[Retract(true)]);
        assert_eq!(robot.outputs, 0, "{:?}", robot.blocked_by());
        robot.hold(&[]);
        assert!(robot.blocked_by().join("\n").contains("rejoin: "), "{:?}", robot.blocked_by());
    }
    let within: RejoinAt = robot.line.station(robot.station).operation_named("home from m1").into();
    assert!(rejoin_with(&mut robot, within, &[("slot", 3)]).is_taken());
    robot.hold(&[Retract(true)]);
    assert!(robot.outputs != 0 && robot.on().contains(&"slot_1"), "{:?} {:?}", robot.on(), robot.blocked_by());
    // To go on home it needs no number.
    let mut robot = OrderBench::standing(StationId(1), Restore::Fresh, MEMORY, &["G_0"]);
    robot.mode(ControlMode::Manual);
    robot.through(Advance(true));
    assert_eq!(robot.rest().as_deref(), Some("home"));
}

/// By the numbers of its order the coordinator counts where the part is: a confirmation replaced them, and the part was laid into another slot.
#[test]
fn the_numbers_of_an_order_are_not_replaced() {
    let mut m1 = OrderBench::measured(Restore::From(OrderBench::clamped().controller.snapshot()), &["C_60", "L_0"]);
    m1.mode(ControlMode::Auto);
    m1.run(&order(2, "machine"));
    m1.mode(ControlMode::Manual);
    m1.set("L_0", false);
    let (before, slide) = (m1.outputs, m1.line.station(m1.station).operation_named("slide in"));
    assert!(m1.rest().is_none() && before != 0, "{}", m1.doing());
    for at in [RejoinAt::Measured, slide.into()] {
        assert_eq!(rejoin_with(&mut m1, at, &[("program", 5)]), Handled::Ignored(Ignored::NumbersKnown));
    }
    assert_eq!(m1.outputs, before);
    // Nor where its place is lost.
    let mut m1 = OrderBench::measured(Restore::From(m1.controller.snapshot()), &["C_60", "L_0"]);
    m1.mode(ControlMode::Manual);
    m1.set("C_60", false);
    m1.set("C_60", true);
    let refused = rejoin_with(&mut m1, slide.into(), &[("program", 5)]);
    assert_eq!(refused, Handled::Ignored(Ignored::NumbersKnown), "{}", m1.doing());
}

#[test]
fn at_a_rest_no_number_is_confirmed() {
    let mut m1 = OrderBench::measured(Restore::Fresh, &["C_60", "L_0"]);
    m1.mode(ControlMode::Manual);
    let numbers = [("program", 5)];
    assert_eq!(rejoin_with(&mut m1, RejoinAt::Measured, &numbers), Handled::Ignored(Ignored::NoSuchNumber));
    assert!(rejoin(&mut m1, RejoinAt::Measured).is_taken());
    assert_eq!(rejoin_with(&mut m1, RejoinAt::Measured, &numbers), Handled::Ignored(Ignored::NotLost));
}

/// It was called off after the repair, while it was on again.
#[test]
fn a_switch_that_is_on_again_was_off_when_the_motion_stopped() {
    let clamped = OrderBench::clamped().controller.snapshot();
    let mut m1 = OrderBench::measured(Restore::From(clamped), &["C_60", "L_0"]);
    m1.mode(ControlMode::Auto);
    m1.run(&order(2, "machine"));
    m1.set("C_60", false);
    assert_eq!(m1.doing(), "slide in (stopped)");
    assert!(m1.fault().contains(" is off, required on at `"), "{}", m1.fault());
    m1.set("C_60", true);
    assert!(m1.fault().contains(" was off, required on at `") && !m1.fault().contains("is off"), "{}", m1.fault());
}
