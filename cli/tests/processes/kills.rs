//! Processes killed by SIGKILL: in the middle of a motion, the coordinator, one whose journal is gone when it comes back;
//! and processes stopped for a moment.
//!
//! ```text
//!   mill_1       ── feed ──✝  run starts it again ── "goes on from its journal" ──▶ incomplete ── advance ──▶
//!   its output   ──────────┘ off
//!   the others   ─ finishes ── stand-by until an operator has looked ─────────────────────────────────────▶ auto
//! ```

use linewright_msgs::StationState;

use super::operated::counts_are_what_was_seen;
use crate::support::operator::Operator;
use crate::support::pause;
use crate::support::rig::{Rig, line, send_signal};

#[test]
fn a_station_and_the_coordinator_killed_come_back_and_no_count_is_lost() {
    // Slow enough to be hit in the middle: the feed takes longer than it takes to see that the mill is gone.
    let mut rig = Rig::new(&line(2.0));
    let operator = rig.in_stand_by();
    let counted_before = operator.counts();
    operator.order("auto", StationState::MODE_AUTO);

    a_moving_station(&rig, &operator);
    operator.cycles(1);
    the_coordinator(&rig, &operator);
    operator.cycles(1);

    operator.go_home();
    counts_are_what_was_seen(&rig, &operator, &counted_before);

    operator.order("start", StationState::MODE_STANDBY);
    operator.order("auto", StationState::MODE_AUTO);
    a_station_whose_journal_is_gone(&rig, &operator);
    operator.cycles(1);
    operator.go_home();
    let report = rig.ends_well(3);
    assert!(report["cycles"].as_u64().is_some_and(|cycles| cycles >= 2), "{report}");
}

/// The middleware does not survive a stop and a continuation; a deaf node must not stay.
#[test]
fn a_process_stopped_for_a_moment_is_started_again() {
    let mut rig = Rig::new(&line(0.3));
    let operator = rig.in_stand_by();
    for words in [&["--station", "clamp_1"][..], &["coordinator"]] {
        // Until its threads are listed.
        pause(1500);
        let before = operator.heard().boot_ids();
        let process = rig.process(words).expect("a process");
        send_signal("STOP", process);
        pause(50);
        send_signal("CONT", process);
        operator.wait("another process", |heard| heard.boot_ids() != before);
        operator.wait_until_connected();
    }
    assert!(["clamp_1", "coordinator"].iter().all(|name| rig.log(name).contains("middleware thread ended")));
    operator.recover();
    operator.cycles(1);
    operator.go_home();
    rig.ends_well(2);
}

fn a_moving_station(rig: &Rig, operator: &Operator) {
    rig.eye.wait("the mill feeds", |seen| seen.output("mill_1", "feed"));
    // The frame is seen before the state is received.
    operator.wait("and says so", |heard| heard.station("mill_1").places[2] == StationState::PLACE_OPERATING);
    let before = operator.station("mill_1");
    let killed = rig.kill(&["--station", "mill_1"]);
    rig.eye.wait("its output is off", |seen| !seen.output("mill_1", "feed"));
    comes_back(operator, "mill_1", &before);
    assert_ne!(rig.process(&["--station", "mill_1"]), Some(killed));
    assert!(rig.log("mill_1").contains("continued from its journal"));
    nothing_starts(rig, operator);
    let after = operator.station("mill_1");
    assert_eq!((after.cycle, &after.done), (before.cycle, &before.done), "it knows where it was");
    assert_eq!(after.incomplete, [2], "and that its feed was cut short");
    let refusal = operator.refused("auto");
    assert!(refusal.contains("mill_1"), "{refusal}");
    operator.recover();
}

fn the_coordinator(rig: &Rig, operator: &Operator) {
    rig.eye.wait("the bar advances", |seen| seen.output("transfer", "advance"));
    let before = operator.heard().line.clone();
    rig.kill(&["coordinator"]);
    rig.eye.wait("every output is off", |seen| seen.energised().is_empty());
    operator.wait("another coordinator", |heard| heard.line.boot_id != before.boot_id);
    operator.wait("above every epoch before it", |heard| heard.line.epoch > before.epoch);
    operator.wait_until_connected();
    assert_ne!(operator.heard().line.mode, StationState::MODE_AUTO, "nobody has asked for auto");
    nothing_starts(rig, operator);
    operator.recover();
}

/// The clamp does not move, and auto is refused with its name and the way back: it is confirmed where it stands, and all
/// stations are led home.
fn a_station_whose_journal_is_gone(rig: &Rig, operator: &Operator) {
    rig.eye.wait("the clamp is closed and the mill works", |seen| seen.output("mill_1", "feed"));
    let before = operator.station("clamp_1");
    // Before its process, which is started again at once.
    std::fs::remove_file(rig.state().join("clamp_1.journal")).expect("a journal");
    rig.kill(&["--station", "clamp_1"]);
    let started = rig.eye.seen().starts().len();
    comes_back(operator, "clamp_1", &before);
    nothing_starts(rig, operator);
    assert!(!rig.eye.seen().starts()[started..].iter().any(|start| start.what.starts_with("clamp_1")));
    let refusal = operator.refused("auto");
    let way_back = "clamp_1: no memory of the cycle; lead all stations home in manual, then give auto";
    assert!(refusal.contains(way_back), "{refusal}");
    let said = rig.said(&["rejoin"], &["clamp_1"]).expect("its switches tell where it stands");
    assert!(said.contains("advance clamp"), "{said}");
    operator.order("manual", StationState::MODE_MANUAL);
    operator.lead_home();
    operator.order("auto", StationState::MODE_AUTO);
}

fn comes_back(operator: &Operator, station: &str, before: &StationState) {
    operator.wait("it comes back", |heard| heard.station(station).boot_id != before.boot_id);
    operator.wait_until_connected();
}

/// Once every node has received it, nothing starts by itself.
fn nothing_starts(rig: &Rig, operator: &Operator) {
    operator.wait("nobody is in auto", |heard| heard.all(|state| state.mode != StationState::MODE_AUTO));
    pause(200);
    let started = rig.eye.seen().starts().len();
    operator.wait("everything stands", |heard| heard.all(|state| state.stopped));
    pause(700);
    assert_eq!(&rig.eye.seen().starts()[started..], []);
}
