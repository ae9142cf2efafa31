//! Ctrl-C: once stops at home, or where nothing leads home without an operator; twice ends at once.

use std::time::Duration;

use linewright_msgs::StationState;

use crate::support::operator::Operator;
use crate::support::rig::{Rig, line};
use crate::support::{PATIENCE, pause, wait_for};

/// An orderly end takes up to two seconds, then the children are killed.
const AT_ONCE: Duration = Duration::from_secs(10);

fn running_in_auto() -> (Rig, Operator) {
    let mut rig = Rig::new(&line(0.3));
    rig.start(&[]);
    let operator = Operator::join(&rig);
    operator.wait("auto", |heard| heard.in_mode(StationState::MODE_AUTO));
    operator.cycles(1);
    rig.eye.wait("the bar advances", |seen| seen.output("transfer", "advance"));
    (rig, operator)
}

#[test]
fn the_first_ctrl_c_ends_the_round_at_home() {
    let (mut rig, _operator) = running_in_auto();
    rig.signal("INT");
    let (code, report) = rig.ended();
    assert_eq!((code, &report["mode"]), (0, &"home".into()), "{report}");
    let cycles = usize::try_from(report["cycles"].as_u64().expect("a number")).expect("few");
    let seen = rig.eye.seen();
    crate::support::chart::starts_follow_the_chart(seen.starts(), cycles);
    assert_eq!(seen.conflicts(), [""; 0]);
    drop(seen);
    assert!(rig.processes().is_empty(), "nothing is left: {:?}", rig.processes());
}

#[test]
fn the_second_ctrl_c_ends_at_once_with_every_output_off() {
    let (mut rig, _operator) = running_in_auto();
    // The clamp does not close: the line never comes home.
    rig.fail("clamp_1", "advance clamp", "slip");
    rig.signal("INT");
    pause(200);
    rig.signal("INT");
    let (_, report) = rig.ended_within(AT_ONCE);
    assert_ne!(report["mode"], "home", "{report}");
    assert!(rig.processes().is_empty(), "nothing is left: {:?}", rig.processes());
    assert_eq!(rig.eye.seen().energised(), [""; 0]);
}

#[test]
fn one_ctrl_c_ends_a_run_in_an_emergency_stop_and_says_why_it_is_not_at_home() {
    let (mut rig, operator) = running_in_auto();
    operator.say("estop");
    operator.wait("e-stop", |heard| heard.all(|state| state.mode == StationState::MODE_ESTOP));
    rig.signal("INT");
    let (code, report) = rig.ended_within(AT_ONCE);
    assert_eq!((code, &report["mode"]), (1, &"e-stop".into()), "{report}");
    let error = report["error"].as_str().expect("it is not at home");
    assert!(error.starts_with("the stop ended in e-stop since 2"), "{error}");
    assert!(error.contains(" UTC (command estop), not reset"), "{error}");
}

/// Somebody else has given auto: it is stopped like any other run.
#[test]
fn ctrl_c_ends_a_line_that_others_operate_at_home() {
    let mut rig = Rig::new(&line(0.3));
    let operator = rig.in_auto();
    operator.cycles(1);
    rig.eye.wait("the bar advances", |seen| seen.output("transfer", "advance"));
    rig.signal("INT");
    let (code, report) = rig.ended();
    assert_eq!((code, &report["mode"]), (0, &"home".into()), "{report}");
    let cycles = usize::try_from(report["cycles"].as_u64().expect("a number")).expect("few");
    crate::support::chart::starts_follow_the_chart(rig.eye.seen().starts(), cycles);
}

/// A fault in the middle: the run waits for its operator, counts on, and does not end well.
#[test]
fn a_run_of_some_cycles_goes_on_after_a_fault_and_ends_with_1() {
    let mut rig = Rig::new(&line(0.3));
    rig.start(&["--cycles", "3"]);
    let operator = Operator::join(&rig);
    operator.wait("auto", |heard| heard.in_mode(StationState::MODE_AUTO));
    rig.fail("clamp_1", "advance clamp", "stick");
    operator.wait("stand-by", |heard| heard.in_mode(StationState::MODE_STANDBY));
    rig.fail("clamp_1", "advance clamp", "clear");
    operator.recover();
    let (code, report) = rig.ended();
    assert_eq!((code, &report["mode"], &report["cycles"]), (1, &"home".into(), &3.into()), "{report}");
    let error = report["error"].as_str().expect("a reason");
    assert!(error.starts_with("1 fault on the way: clamp_1 stopped advance clamp"), "{error}");
}

/// The same where another gives start and auto: it is named what the run waits for.
#[test]
fn a_run_that_another_operates_reports_that_auto_ended_and_counts_on() {
    let mut rig = Rig::new(&line(0.3));
    rig.start(&["--no-auto", "--cycles", "3"]);
    let operator = Operator::join(&rig);
    operator.order("start", StationState::MODE_STANDBY);
    operator.order("auto", StationState::MODE_AUTO);
    rig.fail("clamp_1", "advance clamp", "stick");
    operator.wait("stand-by", |heard| heard.in_mode(StationState::MODE_STANDBY));
    let said = || std::fs::read_to_string(rig.state().with_file_name("run.err")).expect("its standard error");
    assert!(wait_for(PATIENCE, || said().contains("auto ended: stand-by")), "{}", said());
    rig.fail("clamp_1", "advance clamp", "clear");
    operator.recover();
    let (code, report) = rig.ended();
    assert_eq!((code, &report["mode"], &report["cycles"]), (1, &"home".into(), &3.into()), "{report}");
}
