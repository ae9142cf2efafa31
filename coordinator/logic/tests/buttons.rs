//! Hand-mode buttons held by message.

use std::time::Duration;

use linewright_coordinator_logic::Buttons;
use linewright_line::Tick;

const TERM: Duration = Duration::from_millis(250);

fn at(millis: u64) -> Tick {
    Tick::from_millis(millis)
}

#[test]
fn held_while_refreshed() {
    let mut buttons = Buttons::default();
    assert!(buttons.hear(at(1000), 0b11, TERM));
    assert!(!buttons.hear(at(1200), 0b11, TERM));
    assert_eq!(buttons.held(at(1449)), 0b11);
    assert_eq!(buttons.held(at(1450)), 0);
    assert_eq!(buttons.until(), at(1450));
}

#[test]
fn a_late_refresh_is_no_new_press_until_the_button_was_released() {
    let mut buttons = Buttons::default();
    buttons.hear(at(1000), 0b01, TERM);
    assert!(buttons.hear(at(1300), 0b11, TERM));
    assert_eq!(buttons.held(at(1300)), 0b10, "the other button is pressed, this one lapsed");
    buttons.hear(at(1350), 0b11, TERM);
    assert_eq!(buttons.held(at(1350)), 0b10, "and stays so however often it is said");
    buttons.hear(at(1400), 0b10, TERM);
    buttons.hear(at(1450), 0b11, TERM);
    assert_eq!(buttons.held(at(1450)), 0b11, "released and pressed again");
}

#[test]
fn no_silence_is_a_release() {
    let mut buttons = Buttons::default();
    buttons.hear(at(1000), 1, TERM);
    for late in [2000, 4000, 3_600_000] {
        buttons.hear(at(late), 1, TERM);
        assert_eq!(buttons.held(at(late)), 0, "after {late} ms");
    }
    buttons.hear(at(3_600_100), 0, TERM);
    buttons.hear(at(3_600_200), 1, TERM);
    assert_eq!(buttons.held(at(3_600_200)), 1);
}
