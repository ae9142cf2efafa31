//! *Resume* held by message, by one console at a time; when the order has it is in `resume.rs`.

use std::time::Duration;

use linewright_coordinator_logic::ResumeButton;
use linewright_line::Tick;

const TERM: Duration = Duration::from_millis(250);
const A: u64 = 1;
const B: u64 = 2;

fn at(millis: u64) -> Tick {
    Tick::from_millis(millis)
}

#[test]
fn held_while_one_console_renews_it() {
    let mut button = ResumeButton::default();
    assert!(button.hear(at(1000), A, true, TERM), "a press");
    assert!(!button.hear(at(1200), A, true, TERM), "renewed");
    assert!(button.is_held(at(1449)) && !button.is_held(at(1450)));
    button.hear(at(1500), A, true, TERM);
    assert!(!button.is_held(at(1500)), "silence is no release");
    button.hear(at(1550), A, false, TERM);
    assert!(button.hear(at(1600), A, true, TERM) && button.is_held(at(1600)));
}

#[test]
fn a_second_console_ends_it_whatever_it_sends() {
    for second in [true, false] {
        let mut button = ResumeButton::default();
        button.hear(at(1000), A, true, TERM);
        assert!(button.hear(at(1050), B, second, TERM), "to be reported");
        assert!(!button.is_held(at(1050)));
        for millis in [1100, 1200, 1300, 1400, 1500] {
            assert!(!button.hear(at(millis), A, true, TERM), "once");
            assert!(!button.is_held(at(millis)), "held on, {millis} ms");
        }
        button.hear(at(1550), A, false, TERM);
        assert!(button.hear(at(1600), A, true, TERM) && button.is_held(at(1600)), "alone again, and pressed anew");
    }
}

#[test]
fn while_two_send_neither_holds_it() {
    let mut button = ResumeButton::default();
    for step in 0..40 {
        let now = at(1000 + step * 50);
        // One that stands idle, and one that presses again and again.
        button.hear(now, A, false, TERM);
        button.hear(now, B, step % 4 != 0, TERM);
        assert!(!button.is_held(now), "step {step}");
    }
}

#[test]
fn a_console_that_takes_over_what_another_held_has_to_release_it_first() {
    let mut button = ResumeButton::default();
    button.hear(at(1000), A, true, TERM);
    button.hear(at(5000), B, true, TERM);
    assert!(!button.is_held(at(5000)));
    button.hear(at(5050), B, false, TERM);
    button.hear(at(5100), B, true, TERM);
    assert!(button.is_held(at(5100)));
}

#[test]
fn a_message_from_an_unknown_time_and_a_change_of_mode_count_for_nothing() {
    let mut button = ResumeButton::default();
    button.hear_late(at(1000), A, true, TERM);
    button.hear(at(1050), A, true, TERM);
    assert!(!button.is_held(at(1050)));
    button.hear(at(1100), A, false, TERM);
    button.hear(at(1150), A, true, TERM);
    button.disarm();
    button.hear(at(1200), A, true, TERM);
    assert!(!button.is_held(at(1200)));
}
