//! The checks of the coordinator for diagnostics.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_coordinator_shell::{CoordinatorRecord, RefusalFacts, commands_check};
use linewright_lifecycle::LifecycleState;
use linewright_station_shell::{HealthCheck, HealthLevel};

use crate::rig::Rig;

fn check(rig: &Rig, name: &str) -> HealthCheck {
    let text = rig.shell.coordinator().text();
    let checks = rig.shell.health(&rig.line, rig.now, &text);
    checks.into_iter().find(|check| check.name == name).expect("a check of this name")
}

fn level(rig: &Rig, name: &str) -> HealthLevel {
    check(rig, name).level
}

#[test]
fn stations_that_were_never_received_or_have_gone_are_errors_and_named() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    let none = check(&rig, "stations");
    assert_eq!((none.level, none.message.as_str()), (HealthLevel::Error, "not received: transfer, clamp_1, mill_1"));
    assert!(none.values.contains(&("mill_1: age of the state".to_owned(), "none received".to_owned())));
    rig.in_auto();
    assert_eq!((level(&rig, "stations"), level(&rig, "mode")), (HealthLevel::Ok, HealthLevel::Ok));
    rig.now = rig.now + rig.line.timing.stale;
    rig.act();
    assert_eq!(level(&rig, "stations"), HealthLevel::Error);
    assert_eq!(level(&rig, "mode"), HealthLevel::Warn, "{}", rig.shell.coordinator().text());
}

#[test]
fn a_node_that_is_not_active_is_no_silent_one() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.refresh();
    rig.heard[1].inactive = Some(LifecycleState::Inactive);
    rig.refresh();
    let found = check(&rig, "stations");
    assert_eq!((found.level, found.message.as_str()), (HealthLevel::Warn, "node not active: clamp_1"));
    rig.shell.follow_lifecycle(rig.now, LifecycleState::Inactive);
    rig.act();
    assert_eq!(level(&rig, "mode"), HealthLevel::Error, "no motion while the coordinator is not active");
}

#[test]
fn an_emergency_stop_and_a_journal_that_cannot_be_written_are_errors() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.in_auto();
    assert!(!rig.shell.is_unwritten());
    rig.command(ModeCommand::EStop);
    rig.disk_is_full = true;
    // Until the next attempt to write.
    rig.shell.act(rig.now, &mut rig.effects);
    let record = rig.shell.to_remember();
    rig.shell.remembered(rig.now, record, false);
    assert!(rig.shell.is_unwritten());
    assert_eq!(level(&rig, "mode"), HealthLevel::Error);
    assert_eq!(check(&rig, "mode").message, rig.shell.coordinator().text());
}

#[test]
fn a_restart_of_a_station_and_states_that_are_missed_are_counted() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.refresh();
    rig.heard[2].boot_id = 8;
    rig.now = rig.now + rig.line.timing.stale + Duration::from_millis(50);
    rig.refresh();
    let found = check(&rig, "stations");
    let value = |name: &str| found.values.iter().find(|(known, _)| known == name).map(|(_, value)| value.clone());
    assert_eq!(value("mill_1: restarts seen").as_deref(), Some("1"));
    assert_eq!(value("clamp_1: restarts seen").as_deref(), Some("0"));
    // One counter numbers the messages of all three here.
    assert_eq!(value("clamp_1: states missed").as_deref(), Some("2"));
}

#[test]
fn a_command_gives_its_own_refusal() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.refresh();
    let judge = |rig: &mut Rig, command| {
        let arrival = linewright_coordinator_shell::CoordinatorArrival::Command(command);
        rig.shell.command(rig.now, arrival).map(|refused| refused.command.name())
    };
    assert_eq!(judge(&mut rig, ModeCommand::Auto), Some("auto"));
    assert_eq!(judge(&mut rig, ModeCommand::Reset), Some("reset"));
    assert_eq!(judge(&mut rig, ModeCommand::Start), None);
    assert_eq!(judge(&mut rig, ModeCommand::Stop), None);
    let refused = rig.act().iter().filter(|effect| format!("{effect:?}").starts_with("Refused")).count();
    assert_eq!(refused, 2, "each is published as well");
}

#[test]
fn refused_commands_are_counted_by_sender_and_one_that_stands_is_to_be_looked_at() {
    let senders = [("01.10.5e".to_owned(), 2)];
    let standing = RefusalFacts { count: 2, standing: "auto refused", senders: &senders };
    let found = commands_check(standing);
    assert_eq!((found.level, found.message.as_str()), (HealthLevel::Warn, "refused: auto refused"));
    assert!(found.values.contains(&("refused of 01.10.5e".to_owned(), "2".to_owned())));
    assert_eq!(commands_check(RefusalFacts { standing: "", ..standing }).level, HealthLevel::Ok);
}
