//! A button that is held by message, by one console at a time.

use std::time::Duration;

use linewright_line::Tick;
use linewright_station_logic::PanelCommand;
use linewright_station_shell::{HeldByOne, HeldPass, StationArrival};

use crate::rig::{ADVANCE, CONSOLE, Rig};

const TERM: Duration = Duration::from_millis(250);
const A: u64 = 1;
const B: u64 = 2;

fn at(millis: u64) -> Tick {
    Tick::from_millis(millis)
}

#[test]
fn one_console_holds_it_and_another_one_holds_it_afterwards() {
    let mut button = HeldByOne::default();
    assert_eq!(button.offer(at(1000), A, true, TERM), HeldPass::Taken);
    assert_eq!(button.offer(at(1200), A, true, TERM), HeldPass::Taken);
    assert_eq!(button.offer(at(1250), A, false, TERM), HeldPass::Taken);
    // As soon as it was let go: scripts press with one process after the other.
    assert_eq!(button.offer(at(1251), B, false, TERM), HeldPass::Taken);
    assert_eq!(button.offer(at(1252), B, true, TERM), HeldPass::Taken);
}

#[test]
fn a_second_console_ends_it_whatever_it_sends_and_both_have_to_let_go() {
    for second in [true, false] {
        let mut button = HeldByOne::default();
        button.offer(at(1000), A, true, TERM);
        assert_eq!(button.offer(at(1050), B, second, TERM), HeldPass::Second);
        for millis in [1100, 1200, 9000] {
            assert_eq!(button.offer(at(millis), A, true, TERM), HeldPass::Unreleased, "held on, {millis} ms");
        }
        if second {
            assert_eq!(button.offer(at(9010), B, true, TERM), HeldPass::Unreleased);
            assert_eq!(button.offer(at(9020), B, false, TERM), HeldPass::Taken);
        }
        assert_eq!(button.offer(at(9050), A, false, TERM), HeldPass::Taken);
        assert_eq!(button.offer(at(9100), A, true, TERM), HeldPass::Taken, "alone, and pressed anew");
    }
}

#[test]
fn while_two_send_a_press_lasts_until_the_next_message_of_the_other() {
    let mut button = HeldByOne::default();
    for step in 0..40 {
        let now = at(1000 + step * 50);
        // One that sends all the time that it is released, and one that presses again and again.
        assert_eq!(button.offer(now, B, step % 4 != 0, TERM) == HeldPass::Taken, step % 4 <= 1, "step {step}");
        let is_ended = button.offer(now, A, false, TERM) == HeldPass::Second;
        assert_eq!(is_ended, step % 4 == 1, "step {step}");
    }
}

/// The finger never left it while its messages did not come, and another console has let go meanwhile.
#[test]
fn a_release_is_one_of_its_own_console_alone() {
    let mut button = HeldByOne::default();
    button.offer(at(1000), A, true, TERM);
    assert_eq!(button.offer(at(5000), B, false, TERM), HeldPass::Taken, "it counts no more, and nothing is ended");
    assert_eq!(button.offer(at(5050), A, true, TERM), HeldPass::Unreleased);
    button.offer(at(5100), A, false, TERM);
    assert_eq!(button.offer(at(5150), A, true, TERM), HeldPass::Taken);
}

#[test]
fn what_is_of_an_unknown_time_has_to_be_released_first() {
    let mut button = HeldByOne::default();
    button.offer_late(at(900), A, true, TERM);
    assert_eq!(button.offer(at(1000), A, true, TERM), HeldPass::Unreleased);
    button.offer_late(at(1040), A, false, TERM);
    assert_eq!(button.offer(at(1050), A, true, TERM), HeldPass::Unreleased, "nor is such a release one");
    button.offer(at(1100), A, false, TERM);
    assert_eq!(button.offer(at(1150), A, true, TERM), HeldPass::Taken);
}

/// A key that is stuck, or a page left with a finger on it: beside it a press would be a motion as short as the time between messages.
#[test]
fn beside_one_that_is_held_and_does_not_count_no_other_is_pressed() {
    let mut button = HeldByOne::default();
    button.offer(at(1000), A, true, TERM);
    button.offer(at(1050), B, false, TERM);
    for step in 0..20 {
        let now = 1100 + step * 50;
        assert_eq!(button.offer(at(now), A, true, TERM), HeldPass::Unreleased, "{now}");
        button.offer(at(now + 1), B, false, TERM);
        assert_eq!(button.offer(at(now + 2), B, true, TERM), HeldPass::Second, "{now}");
        button.offer(at(now + 3), B, false, TERM);
    }
    button.offer(at(5000), A, false, TERM);
    assert_eq!(button.offer(at(5001), B, true, TERM), HeldPass::Taken);
}

/// Many that press once and are gone do not make one forgotten that is still held.
#[test]
fn one_that_is_held_on_is_remembered_whoever_presses_beside_it() {
    let mut button = HeldByOne::default();
    button.offer(at(1000), A, true, TERM);
    button.offer(at(1001), B, false, TERM);
    for other in 0..100 {
        let now = 2000 + other * 1000;
        button.offer(at(now), 100 + other, true, TERM);
        assert_ne!(button.offer(at(now + 1), A, true, TERM), HeldPass::Taken, "{other}");
    }
    assert_eq!(button.offer(at(200_000), A, true, TERM), HeldPass::Unreleased);
}

/// Whatever any number of consoles send, memory is bounded, and one that holds it alone after its release has it.
#[test]
fn many_consoles_are_bounded() {
    let mut button = HeldByOne::default();
    for console in 0..1000 {
        button.offer(at(1000 + console), console, true, TERM);
    }
    assert!(format!("{button:?}").len() < 300, "{button:?}");
    button.offer(at(5000), A, false, TERM);
    assert_eq!(button.offer(at(5001), A, true, TERM), HeldPass::Taken);
}

/// Two consoles at the panel of a clamp that closes.
#[test]
fn a_motion_at_a_panel_stops_when_a_second_console_sends_and_does_not_begin_again() {
    for second in [true, false] {
        let mut rig = Rig::new();
        let press = |rig: &mut Rig, console, held| {
            rig.take(StationArrival::Panel { console, command: PanelCommand::Advance(held) });
            rig.act();
            rig.shell.controller().marking().any(|place| place.is_operating() && place.op == ADVANCE)
        };
        rig.close();
        assert!(press(&mut rig, CONSOLE, true), "it moves");
        assert!(!press(&mut rig, B, second), "it stands: {second}");
        let why = rig.shell.controller().blocked_by(&rig.line, rig.now);
        assert!(why.iter().any(|of| of.contains("two consoles")), "{why:?}");
        for _ in 0..3 {
            assert!(!press(&mut rig, CONSOLE, true), "held on");
        }
        if second {
            press(&mut rig, B, false);
        }
        press(&mut rig, CONSOLE, false);
        assert!(press(&mut rig, CONSOLE, true), "let go, and pressed anew: {second}");
    }
}
