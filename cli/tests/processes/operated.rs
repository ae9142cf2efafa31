//! A shift of one operator, over ROS topics alone: a fault in auto, an emergency stop in mid-motion, and hand mode.
//!
//! ```text
//!   auto ── fault ──▶ stand-by, the others finish ── selector at manual, advance ──▶ auto
//!        ── estop ──▶ every output off ── reset ──▶ still e-stop ── manual ──▶ auto ── stop ──▶ home
//!        ── hand: a step of the cycle forward and back
//! ```

use std::time::Duration;

use linewright_msgs::{StationEvent, StationState};

use crate::support::operator::{Operator, STATIONS};
use crate::support::pause;
use crate::support::rig::{Rig, line};

/// Switching off takes milliseconds; this is for a machine that is busy with other things.
const PROMPTLY: Duration = Duration::from_millis(1500);

#[test]
fn a_line_is_operated_by_topics_through_fault_emergency_stop_and_hand_mode() {
    let (station, operation) = ("mill_1", "feed main slide");
    // Slow enough that a motion is still under way when a stop arrives.
    let mut rig = Rig::new(&line(1.0));
    let operator = rig.in_stand_by();
    let counted_before = operator.counts();
    operator.order("auto", StationState::MODE_AUTO);
    operator.cycles(1);
    a_fault_stops_its_station(&rig, &operator, station, operation, "feed");
    by_its_selector(&rig, &operator, station);
    operator.cycles(1);
    an_emergency_stop_switches_everything_off_and_only_manual_leads_out(&rig, &operator);
    operator.cycles(1);
    two_commands_lead_to_manual_from_wherever_the_line_is(&rig, &operator);
    operator.go_home();
    a_reader_that_comes_late_hears_the_last_cycle_time(&rig);
    counts_are_what_was_seen(&rig, &operator, &counted_before);
    a_held_button_runs_a_step_and_its_partner_runs_it_back(&rig, &operator);
    let report = rig.ends_well(0);
    // The broken motion, and the one that the emergency stop ended half-way.
    assert_eq!(report["stations"][station]["faults"], 2, "{report}");
    stops_are_reported(&rig, station);
}

/// By cause: the alarm, the emergency stop, and what the operator did.
fn stops_are_reported(rig: &Rig, station: &str) {
    let reported: serde_json::Value = serde_json::from_str(&rig.reported(&["--json"])).expect("JSON");
    let stops = reported["stops"].as_array().expect("a list");
    for (kind, of) in [("alarm", station), ("emergency stop", ""), ("operator", "")] {
        let is_it = |stop: &&serde_json::Value| {
            stop["kind"] == kind && stop["cause"].as_str().is_some_and(|cause| cause.contains(of))
        };
        let stop = stops.iter().find(is_it).unwrap_or_else(|| panic!("{kind}: {reported}"));
        assert!(stop["total_s"].as_f64().is_some_and(|total| total > 0.1), "{stop}");
    }
}

/// It breaks in the middle of its motion; the others finish theirs, and nothing new starts.
fn a_fault_stops_its_station(rig: &Rig, operator: &Operator, station: &str, operation: &str, output: &str) {
    rig.eye.wait("off", |seen| !seen.output(station, output));
    rig.eye.wait(operation, |seen| seen.output(station, output));
    rig.fault(station, operation, 3);
    let is_it = |event: &StationEvent| event.kind == StationEvent::KIND_FAULT && event.operation == operation;
    operator.wait(&format!("{operation} fails"), |heard| heard.events.iter().any(is_it));
    rig.eye.wait("its actuator is off", |seen| !seen.output(station, output));
    operator.wait("the station says what is wrong", |heard| !heard.station(station).fault.is_empty());
    let why = rig.said(&["why"], &[]).expect("every station is heard");
    assert!(why.contains("mode: stand-by") && why.contains(&format!("FAULT {operation}: ")), "{why}");
    assert!(why.lines().any(|line| line.trim_start().starts_with("waits for ")), "{why}");
    let of_one = rig.said(&["why"], &[station]).expect("a station can be named");
    assert!(of_one.starts_with(station) && !of_one.contains("transfer "), "{of_one}");
    operator.wait("stand-by everywhere", |heard| heard.in_mode(StationState::MODE_STANDBY));
    let started = rig.eye.seen().starts().len();
    operator.wait("everything stands", |heard| heard.all(|state| state.stopped));
    pause(700);
    let seen = rig.eye.seen();
    assert_eq!(seen.energised(), [""; 0]);
    assert_eq!(&seen.starts()[started..], [], "nothing new starts after {operation} has failed");
    drop(seen);
    for other in STATIONS.iter().filter(|other| **other != station) {
        assert!(operator.station(other).incomplete.is_empty(), "{other} has finished what it did");
    }
    let refusal = operator.refused("auto");
    assert!(refusal.contains(&format!("{station}: operation incomplete")), "{refusal}");
    rig.fail(station, operation, "clear");
}

/// One station alone is turned to manual at its panel; the others stay as they are.
fn by_its_selector(rig: &Rig, operator: &Operator, station: &str) {
    operator.select(station, "manual");
    operator.wait("manual", |heard| heard.in_mode(StationState::MODE_MANUAL));
    assert!(!operator.jog("transfer", "return"), "its selector stands at auto");
    let press = |station: &str, button: &str| rig.said(&["press"], &[button, "--station", station, "--for", "1.5"]);
    let refusal = press("clamp_1", "return").expect_err("its selector stands at auto");
    assert!(refusal.contains("return refused: clamp_1 waits for its selector at manual"), "{refusal}");
    let said = press(station, "advance").expect("it goes on");
    assert!(said.starts_with(station), "{said}");
    operator.complete();
    let mode: serde_json::Value =
        serde_json::from_str(&rig.said(&["mode"], &["--json"]).expect("the mode")).expect("JSON");
    assert_eq!((&mode["mode"], &mode["enabled"]), (&"manual".into(), &true.into()), "{mode}");
    let refusal = operator.refused("auto");
    assert!(refusal.contains(&format!("{station}: selector at manual")), "{refusal}");
    operator.select(station, "auto");
    operator.wait("stand-by", |heard| heard.in_mode(StationState::MODE_STANDBY));
    operator.order("auto", StationState::MODE_AUTO);
}

fn an_emergency_stop_switches_everything_off_and_only_manual_leads_out(rig: &Rig, operator: &Operator) {
    // The bar runs back while the mill works: two motions at once.
    rig.eye.wait("two motions", |seen| seen.energised().len() == 2);
    operator.say("estop");
    rig.eye.within(PROMPTLY, "every output off", |seen| seen.energised().is_empty());
    operator.wait("e-stop", |heard| heard.all(|state| state.mode == StationState::MODE_ESTOP));
    let stopped = ["transfer", "mill_1"].map(|name| operator.station(name).incomplete);
    assert!(stopped.iter().all(|incomplete| !incomplete.is_empty()), "both were stopped on their way: {stopped:?}");
    let started = rig.eye.seen().starts().len();
    let refusal = operator.refused("auto");
    assert!(refusal.contains("emergency stop"), "{refusal}");
    operator.say("reset");
    pause(500);
    assert_eq!(operator.heard().line.mode, StationState::MODE_ESTOP, "a reset leads nowhere");
    assert_eq!(&rig.eye.seen().starts()[started..], [], "and nothing has moved");
    operator.recover();
}

/// `stop --wait`, then `manual`: out of auto, and again out of manual and home.
fn two_commands_lead_to_manual_from_wherever_the_line_is(rig: &Rig, operator: &Operator) {
    assert!(!operator.refused("hand").is_empty());
    for _ in 0..2 {
        let stopped = rig.said(&["mode"], &["stop", "--wait"]).expect("it stops");
        assert!(stopped.starts_with("home"), "{stopped}");
        assert!(operator.heard().all(|state| state.stopped));
        assert_eq!(operator.heard().line.refusal, "", "a command was obeyed since");
        let manual = rig.said(&["mode"], &["manual"]).expect("it is obeyed at home");
        assert!(manual.starts_with("manual"), "{manual}");
    }
    // What is so already is no failure, and is said.
    let again = rig.command(&["mode"], &["manual"]).output().expect("the command starts");
    assert!(again.status.success(), "{again:?}");
    assert!(String::from_utf8_lossy(&again.stderr).contains("manual: so it was already"), "{again:?}");
    let odd = rig.said(&["mode"], &["auto", "--wait"]).expect_err("there is nothing to wait for");
    assert!(odd.contains("--wait goes with stop"), "{odd}");
}

fn a_held_button_runs_a_step_and_its_partner_runs_it_back(rig: &Rig, operator: &Operator) {
    operator.order("start", StationState::MODE_STANDBY);
    operator.order("hand", StationState::MODE_HAND);
    let (started, done) = (rig.eye.seen().starts().len(), operator.station("transfer").done);
    for (button, end) in [("PB_2", "LS_vertical_200"), ("PB_4", "LS_vertical_0")] {
        let finger = operator.hold_buttons(button);
        rig.eye.wait(end, |seen| seen.input("transfer", end) && seen.energised().is_empty());
        drop(finger);
        pause(300);
    }
    let order: Vec<String> = rig.eye.seen().starts()[started..].iter().map(|start| start.what.clone()).collect();
    let step = ["lift_to_50", "lift_to_100", "lift_to_150", "lift_to_200"];
    let back = ["lower_to_150", "lower_to_100", "lower_to_50", "lower_to_0"];
    let expected: Vec<String> = step.iter().chain(&back).map(|output| format!("transfer: {output}")).collect();
    assert_eq!(order, expected);
    assert_eq!(operator.station("transfer").done, done, "taken back, counts and all");
}

/// Latched: the line stands, and nothing more is sent.
fn a_reader_that_comes_late_hears_the_last_cycle_time(rig: &Rig) {
    let late = Operator::join(rig);
    late.wait("the last cycle time", |heard| heard.cycle_time.is_some());
    let cycle = late.heard().cycle_time.clone().expect("it was heard");
    let rounds = late.station("mill_1").round;
    assert!((1..=rounds).contains(&cycle.number) && cycle.duration_s > 0.0, "{cycle:?} at the end of round {rounds}");
}

/// Every count is how often the mechanism was seen to arrive, no less and no more.
pub fn counts_are_what_was_seen(rig: &Rig, operator: &Operator, before: &[Vec<i32>]) {
    let after = operator.counts();
    let seen = rig.eye.seen();
    for ((station, before), after) in STATIONS.iter().zip(before).zip(&after) {
        let operations = rig.plan.operations.iter().filter(|operation| operation.station == *station);
        for (operation, (before, after)) in operations.zip(before.iter().zip(after)) {
            let arrived = seen.arrivals(station, &operation.name);
            assert_eq!(after - before, arrived, "{station}: {}", operation.name);
        }
    }
}
