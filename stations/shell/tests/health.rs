//! The checks of a station for diagnostics: their levels, and that nothing is ok which is not known.

use std::time::Duration;

use linewright_lifecycle::LifecycleState;
use linewright_line::Tick;
use linewright_line::net::ControlMode::{Auto, Manual};
use linewright_station_shell::{
    HealthCheck, HealthLevel, JournalFacts, RecentGrowth, StationFacts, journal_check, messages_check,
};

use crate::rig::{FOLLOWED, OTHER, Rig};

const QUIET: StationFacts<'static> = StationFacts { operation: "return clamp", fault: "", waits_for: &[] };

fn check(rig: &Rig, name: &str, facts: StationFacts<'_>) -> HealthCheck {
    let checks = rig.shell.health(&rig.line, rig.now, facts);
    checks.into_iter().find(|check| check.name == name).expect("a check of this name")
}

fn value<'a>(check: &'a HealthCheck, name: &str) -> &'a str {
    check.values.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str()).expect("a value of this name")
}

#[test]
fn a_station_that_has_received_nothing_says_so_and_is_in_no_check_ok() {
    let mut rig = Rig::new();
    rig.restart();
    let checks = rig.shell.health(&rig.line, rig.now, QUIET);
    assert!(checks.iter().all(|check| check.level != HealthLevel::Ok), "{checks:?}");
    assert_eq!(
        check(&rig, "coordinator", QUIET).message,
        "no order of the mode received for this start of the station"
    );
    assert_eq!(value(&check(&rig, "operation", QUIET), "age of the input image"), "none received");
    assert_eq!(check(&rig, "stations", QUIET).message, "not received: transfer, mill_1");
}

#[test]
fn a_station_that_works_is_ok_and_each_thing_that_goes_is_named() {
    let mut rig = Rig::new();
    rig.refresh(6, Manual);
    rig.inputs(true);
    rig.act();
    let checks = rig.shell.health(&rig.line, rig.now, QUIET);
    assert!(checks.iter().all(|check| check.level == HealthLevel::Ok), "{checks:?}");
    assert_eq!(check(&rig, "operation", QUIET).message, "manual: return clamp");
    // What it waits for is no fault: the others have their turn.
    let waits = ["transfer: lift done".to_owned()];
    let waiting = check(&rig, "operation", StationFacts { waits_for: &waits, ..QUIET });
    assert_eq!((waiting.level, value(&waiting, "waits for")), (HealthLevel::Ok, "transfer: lift done"));
    let fault = check(&rig, "operation", StationFacts { fault: "advance clamp: watchdog", ..QUIET });
    assert_eq!((fault.level, fault.message.as_str()), (HealthLevel::Error, "advance clamp: watchdog"));

    let (lease, stale) = (rig.timing().lease, rig.timing().stale);
    rig.pass(stale);
    assert_eq!(check(&rig, "stations", QUIET).level, HealthLevel::Warn);
    assert_eq!(check(&rig, "operation", QUIET).level, HealthLevel::Error, "its image is too old");
    assert_eq!(check(&rig, "coordinator", QUIET).level, HealthLevel::Ok, "its lease is longer");
    rig.pass(lease - stale);
    let silent = check(&rig, "coordinator", QUIET);
    assert_eq!(silent.level, HealthLevel::Error);
    assert!(silent.message.ends_with("the lease has run out"), "{}", silent.message);
}

#[test]
fn a_node_that_is_not_active_is_to_be_looked_at_and_says_what_leads_on() {
    let mut rig = Rig::new();
    rig.shell.deactivate(LifecycleState::Inactive, &mut rig.effects);
    let inactive = check(&rig, "operation", QUIET);
    assert_eq!(
        (inactive.level, inactive.message.as_str()),
        (HealthLevel::Warn, "node inactive: activate it (ros2 lifecycle set)")
    );
    rig.pass(rig.timing().lease);
    assert_eq!(check(&rig, "coordinator", QUIET).level, HealthLevel::Warn, "it hears no mode, as it is to");
}

#[test]
fn two_coordinators_and_orders_that_are_missed_are_seen() {
    let mut rig = Rig::new();
    rig.order_numbered(100, FOLLOWED, 5, Auto);
    assert_eq!(value(&check(&rig, "coordinator", QUIET), "orders missed"), "98");
    for at in 0..4 {
        rig.now = rig.now + rig.timing().refresh;
        rig.order_numbered(101 + at, FOLLOWED, 5, Auto);
        rig.order_numbered(1 + at, OTHER, 9, Auto);
        rig.act();
    }
    let contested = check(&rig, "coordinator", QUIET);
    assert_eq!(contested.level, HealthLevel::Error);
    assert_eq!(contested.message, format!("two coordinators give orders, boot ids {FOLLOWED} and {OTHER}"));
}

#[test]
fn a_journal_that_is_missing_slow_or_lost_is_not_ok() {
    let period = Duration::from_millis(50);
    let kept = |last: u64| JournalFacts::Kept {
        records: 3,
        last: Duration::from_millis(last),
        longest: Duration::from_millis(400),
    };
    let level = |facts| journal_check(facts, period).level;
    assert_eq!(level(JournalFacts::None), HealthLevel::Warn);
    assert_eq!(level(JournalFacts::Lost), HealthLevel::Error);
    assert_eq!(level(kept(51)), HealthLevel::Warn);
    let written = journal_check(kept(50), period);
    assert_eq!((written.level, value(&written, "longest record took")), (HealthLevel::Ok, "400 ms"));
}

#[test]
fn messages_that_were_lost_are_to_be_looked_at_for_a_minute() {
    let mut growth = RecentGrowth::default();
    let mut at = |seconds: u64, count: u64| {
        let is_recent = growth.offer(Tick::from_millis(seconds * 1000), count);
        messages_check((count, 0), is_recent).level
    };
    assert_eq!(at(0, 0), HealthLevel::Ok);
    assert_eq!(at(1, 2), HealthLevel::Warn);
    assert_eq!(at(60, 2), HealthLevel::Warn);
    assert_eq!(at(61, 2), HealthLevel::Ok);
    assert_eq!(at(62, 3), HealthLevel::Warn);
}
