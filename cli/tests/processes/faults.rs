//! A mechanism of each station fails in auto, one after the other, and is recovered at its panel.
//!
//! ```text
//!   auto ── fault ──▶ its actuator off ── others finish ──▶ stand-by ── manual, advance ──▶ auto
//! ```

use linewright_msgs::{StationEvent, StationState};

use crate::support::operator::{Operator, STATIONS};
use crate::support::pause;
use crate::support::rig::{Rig, line};

/// Whose operation, which output drives it, and how it fails: by an SDO frame in the middle of its motion (3 breaks), or
/// by the command beforehand.
const FAULTS: [(&str, &str, &str, Option<u8>); 3] = [
    ("transfer", "advance transfer", "advance", Some(3)),
    ("clamp_1", "advance clamp", "close", None),
    ("mill_1", "feed main slide", "feed", Some(3)),
];

#[test]
fn a_fault_in_each_station_stops_it_and_the_line_is_recovered_by_topics() {
    let mut rig = Rig::new(&line(0.3));
    let operator = rig.in_stand_by();
    let counted_before = operator.counts();
    operator.order("auto", StationState::MODE_AUTO);
    for (station, operation, output, code) in FAULTS {
        operator.cycles(1);
        fails(&rig, &operator, station, operation, output, code);
        the_others_finish_and_nothing_starts(&rig, &operator, station, operation);
        let refusal = operator.refused("auto");
        assert!(refusal.contains(&format!("{station}: operation incomplete")), "{refusal}");
        rig.fail(station, operation, "clear");
        if station == "mill_1" { by_its_selector(&operator, station) } else { operator.recover() }
    }
    operator.cycles(2);
    operator.go_home();
    counts_are_what_was_seen(&rig, &operator, &counted_before);
    rig.signal("INT");
    let (code, report) = rig.ended();
    assert_eq!(code, 0, "{report}");
    for station in STATIONS {
        assert_eq!(report["stations"][station]["faults"], 1, "{report}");
    }
    assert_eq!(rig.eye.seen().conflicts(), [""; 0]);
}

fn fails(rig: &Rig, operator: &Operator, station: &str, operation: &str, output: &str, code: Option<u8>) {
    match code {
        Some(code) => {
            rig.eye.wait("off", |seen| !seen.output(station, output));
            rig.eye.wait(operation, |seen| seen.output(station, output));
            rig.fault(station, operation, code);
        }
        None => rig.fail(station, operation, "stick"),
    }
    let is_it = |event: &StationEvent| event.kind == StationEvent::KIND_FAULT && event.operation == operation;
    operator.wait(&format!("{operation} fails"), |heard| heard.events.iter().any(is_it));
    rig.eye.wait("its actuator is off", |seen| !seen.output(station, output));
    operator.wait("the station says what is wrong", |heard| !heard.station(station).fault.is_empty());
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
