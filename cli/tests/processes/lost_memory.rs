//! A station is killed, and its journal is gone when it comes back.
//!
//! ```text
//!   clamp_1  ── closed ── ✝ no journal ── comes back ── rejoin: it is closed ── manual ── led home ──▶ auto
//! ```

use linewright_msgs::StationState;

use crate::support::operator::Operator;
use crate::support::pause;
use crate::support::rig::{Rig, line};

#[test]
fn a_clamp_without_its_memory_does_not_move_and_is_led_back() {
    let mut rig = Rig::new(&line(1.0));
    let operator = rig.in_auto();
    operator.cycles(1);
    rig.eye.wait("the clamp is closed and the mill works", |seen| seen.output("mill_1", "feed"));
    let started = loses_its_memory(&rig, &operator);
    assert!(rig.eye.seen().input("clamp_1", "LS_closed"));
    refused(&rig, &operator, started);
    operator.wait("it asks where it stands", |heard| {
        heard.station("clamp_1").blocked_by.iter().any(|why| why.contains("confirm it with rejoin"))
    });
    let said = rig.said(&["rejoin"], &["clamp_1"]).expect("its switches tell where it stands");
    assert!(said.contains("advance clamp"), "{said}");
    lead_home(&operator);

    operator.cycles(1);
    operator.go_home();
    assert_eq!(rig.eye.seen().conflicts(), [""; 0]);
}

/// The clamp is killed without its journal and comes back; gives what had started before.
fn loses_its_memory(rig: &Rig, operator: &Operator) -> usize {
    let before = operator.station("clamp_1").boot_id;
    // Before its process, which would be started again at once.
    std::fs::remove_file(rig.state().join("clamp_1.journal")).expect("a journal");
    rig.kill(&["--station", "clamp_1"]);
    let started = rig.eye.seen().starts().len();
    operator.wait("it comes back", |heard| heard.station("clamp_1").boot_id != before);
    operator.wait_until_connected();
    started
}

/// Nothing of the clamp moves, and auto is refused with its name and the way back.
fn refused(rig: &Rig, operator: &Operator, started: usize) {
    operator.wait("nobody is in auto", |heard| heard.all(|state| state.mode != StationState::MODE_AUTO));
    operator.wait("everything stands", |heard| heard.all(|state| state.stopped));
    assert_eq!(operator.station("clamp_1").generation, 0);
    let refusal = operator.refused("auto");
    let way_back =
        "clamp_1: no generation in common with the other stations; lead all stations home in manual, then give auto";
    assert!(refusal.contains(way_back), "{refusal}");
    pause(1000);
    let seen = rig.eye.seen();
    assert!(!seen.starts()[started..].iter().any(|start| start.what.starts_with("clamp_1")), "{:?}", seen.starts());
    assert_eq!(seen.conflicts(), [""; 0]);
}

fn lead_home(operator: &Operator) {
    operator.order("manual", StationState::MODE_MANUAL);
    operator.lead_home();
    operator.order("auto", StationState::MODE_AUTO);
}
