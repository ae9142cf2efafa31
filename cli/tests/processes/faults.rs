//! A mechanism fails in auto and is recovered at its panel.
//!
//! ```text
//!   auto ── fault ──▶ its actuator off ── others finish ──▶ stand-by ── manual, advance ──▶ auto
//! ```

use linewright_msgs::{StationEvent, StationState};

use crate::support::operator::{Operator, STATIONS};
use crate::support::pause;
use crate::support::rig::{Rig, line};

#[test]
fn a_fault_stops_its_station_and_the_line_is_recovered_by_topics() {
    let (station, operation, output) = ("mill_1", "feed main slide", "feed");
    let mut rig = Rig::new(&line(0.3));
    let operator = rig.in_stand_by();
    let counted_before = operator.counts();
    operator.order("auto", StationState::MODE_AUTO);
    operator.cycles(1);
    // It breaks in the middle of its motion.
    rig.eye.wait("off", |seen| !seen.output(station, output));
    rig.eye.wait(operation, |seen| seen.output(station, output));
    rig.fault(station, operation, 3);
    let is_it = |event: &StationEvent| event.kind == StationEvent::KIND_FAULT && event.operation == operation;
    operator.wait(&format!("{operation} fails"), |heard| heard.events.iter().any(is_it));
    rig.eye.wait("its actuator is off", |seen| !seen.output(station, output));
    operator.wait("the station says what is wrong", |heard| !heard.station(station).fault.is_empty());
    the_others_finish_and_nothing_starts(&rig, &operator, station, operation);
    let refusal = operator.refused("auto");
    assert!(refusal.contains(&format!("{station}: operation incomplete")), "{refusal}");
    rig.fail(station, operation, "clear");
    by_its_selector(&operator, station);
    operator.cycles(1);
    operator.go_home();
    counts_are_what_was_seen(&rig, &operator, &counted_before);
    rig.signal("INT");
    let (code, report) = rig.ended();
    assert_eq!((code, &report["stations"][station]["faults"]), (0, &1.into()), "{report}");
    assert_eq!(rig.eye.seen().conflicts(), [""; 0]);
}

fn the_others_finish_and_nothing_starts(rig: &Rig, operator: &Operator, station: &str, operation: &str) {
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
}

/// One station alone is turned to manual at its panel; the others stay as they are.
fn by_its_selector(operator: &Operator, station: &str) {
    operator.select(station, "manual");
    operator.wait("manual", |heard| heard.in_mode(StationState::MODE_MANUAL));
    assert!(!operator.jog("clamp_1", "return") && !operator.jog("transfer", "return"), "their selectors stand at auto");
    operator.complete();
    let refusal = operator.refused("auto");
    assert!(refusal.contains(&format!("{station}: selector at manual")), "{refusal}");
    operator.select(station, "auto");
    operator.wait("stand-by", |heard| heard.in_mode(StationState::MODE_STANDBY));
    operator.order("auto", StationState::MODE_AUTO);
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
