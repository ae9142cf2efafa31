//! Resume at a console: when the order has it, and what is answered where it does not.

use std::time::Duration;

use linewright_coordinator_logic::{ModeCommand, ModeInput};
use linewright_line::StationId;
use linewright_line::net::ControlMode;

use crate::common::CoordinatorBench;

const CONSOLE: u64 = 11;
const OTHER: u64 = 12;

/// The refusal of a message, if there is one.
fn say(bench: &mut CoordinatorBench, console: u64, held: bool) -> Option<String> {
    bench.out.refusals.clear();
    bench.input(ModeInput::Resume(console, held));
    bench.out.refusals.first().map(|refusal| refusal.text(&bench.line))
}

fn resumes(bench: &CoordinatorBench) -> bool {
    bench.coordinator.order().resume
}

#[test]
fn in_a_commanded_manual_the_order_has_it_while_it_is_held_and_is_sent_at_once_when_it_is_not() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Manual);
    assert_eq!(say(&mut bench, CONSOLE, true), None);
    assert!(resumes(&bench) && bench.out.changed);
    bench.wait(Duration::from_millis(200));
    assert_eq!((say(&mut bench, CONSOLE, true), bench.out.changed), (None, false), "renewed");
    say(&mut bench, CONSOLE, false);
    assert!(!resumes(&bench) && bench.out.changed, "let go");
    say(&mut bench, CONSOLE, true);
    let deadline = bench.coordinator.next_deadline().expect("it runs out");
    assert!(deadline <= bench.now + Duration::from_millis(250));
    bench.wait(Duration::from_millis(250));
    assert!(!resumes(&bench) && bench.out.changed, "run out");
    let late = say(&mut bench, CONSOLE, true).expect("no new press");
    assert_eq!(late, "resume refused in manual: not seen released since it was held before; release it first");
    bench.beat();
    assert!(!resumes(&bench));
}

#[test]
fn in_every_other_mode_it_is_refused_and_held_on_into_manual_it_does_not_count() {
    for mode in ControlMode::ALL.into_iter().filter(|&mode| mode != ControlMode::Manual) {
        let mut bench = CoordinatorBench::in_mode(mode);
        let refusal = say(&mut bench, CONSOLE, true).expect("refused");
        assert!(refusal.contains("in manual only") && refusal.starts_with("resume refused in "), "{refusal}");
        assert_eq!((say(&mut bench, CONSOLE, true), resumes(&bench)), (None, false), "once a press, in {mode}");
    }
    let mut bench = CoordinatorBench::in_mode(ControlMode::StandBy);
    say(&mut bench, CONSOLE, true);
    assert_eq!(bench.command(ModeCommand::Manual), None);
    say(&mut bench, CONSOLE, true);
    bench.beat();
    assert!(bench.mode() == ControlMode::Manual && !resumes(&bench));
    say(&mut bench, CONSOLE, false);
    say(&mut bench, CONSOLE, true);
    assert!(resumes(&bench));
}

#[test]
fn it_ends_with_the_mode_and_with_what_keeps_the_mode_from_being_enabled() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Manual);
    say(&mut bench, CONSOLE, true);
    bench.input(ModeInput::Rival(99, bench.now + Duration::from_secs(1)));
    assert!(!resumes(&bench), "another coordinator gives orders");
    let mut bench = CoordinatorBench::in_mode(ControlMode::Manual);
    say(&mut bench, CONSOLE, true);
    bench.command(ModeCommand::EStop);
    assert!(!resumes(&bench));
    let mut bench = CoordinatorBench::in_mode(ControlMode::StandBy);
    bench.acknowledge = false;
    bench.command(ModeCommand::Manual);
    say(&mut bench, CONSOLE, true);
    assert!(!resumes(&bench), "not acknowledged by every station yet");
}

#[test]
fn where_selectors_have_led_to_manual_the_panels_are_not_the_consoles() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::StandBy);
    bench.heard[1].selector_manual = true;
    bench.beat();
    assert_eq!(bench.mode(), ControlMode::Manual);
    let refusal = say(&mut bench, CONSOLE, true).expect("refused");
    assert!(refusal.contains("manual by selectors"), "{refusal}");
    assert!(!resumes(&bench));
}

#[test]
fn two_consoles_hold_nothing() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Manual);
    say(&mut bench, CONSOLE, true);
    let refusal = say(&mut bench, OTHER, false).expect("reported");
    assert!(refusal.contains("two consoles"), "{refusal}");
    assert!(!resumes(&bench) && bench.out.changed);
    assert_eq!(say(&mut bench, CONSOLE, true), None, "reported once");
    assert!(!resumes(&bench));
}

#[test]
fn what_waited_while_the_process_stood_still_is_no_press() {
    let mut bench = CoordinatorBench::in_mode(ControlMode::Manual);
    bench.input(ModeInput::LateResume(CONSOLE, true));
    say(&mut bench, CONSOLE, true);
    assert!(!resumes(&bench));
    say(&mut bench, CONSOLE, false);
    say(&mut bench, CONSOLE, true);
    assert!(resumes(&bench));
}

#[test]
fn a_station_that_is_lost_ends_nothing_at_the_others() {
    // Each station judges for itself: one that stands in its way and is not received keeps it where it is.
    let mut bench = CoordinatorBench::in_mode(ControlMode::Manual);
    say(&mut bench, CONSOLE, true);
    for _ in 0..5 {
        bench.wait(Duration::from_millis(100));
        for station in [0, 2] {
            bench.say(station);
        }
        say(&mut bench, CONSOLE, true);
    }
    assert!(!bench.coordinator.hears(StationId(1)) && resumes(&bench));
}
