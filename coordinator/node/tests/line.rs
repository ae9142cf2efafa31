//! What is noted of a station from one of its states to the next.

use linewright_coordinator_node::line::StationObserver;
use linewright_history::{MotionEnd, Note};
use linewright_line::Tick;
use linewright_msgs::StationState;

const AT: fn(u64) -> Tick = Tick::from_millis;

fn state(places: [u8; 2], started: [i32; 2]) -> StationState {
    StationState {
        boot_id: 1,
        generation: 5,
        mode: StationState::MODE_AUTO,
        places: places.to_vec(),
        started: started.to_vec(),
        ..StationState::default()
    }
}

fn motion(operation: u16, cycle: i32, (from, to): (u64, u64), end: MotionEnd) -> Note {
    Note::Motion { station: 3, operation, cycle, from: AT(from), to: AT(to), end }
}

/// All notes of these states, each at its time.
fn notes(observer: &mut StationObserver, states: &[(u64, StationState)]) -> Vec<Note> {
    let mut out = Vec::new();
    states.iter().for_each(|(at, state)| observer.state(3, AT(*at), state, &mut out));
    out
}

#[test]
fn a_motion_is_from_the_state_that_has_it_to_the_one_that_has_not() {
    let mut observer = StationObserver::new(2);
    let seen = [
        (10, state([0, 3], [0, 0])),
        (20, state([1, 0], [1, 0])),
        (25, state([1, 0], [1, 0])),
        (40, state([3, 0], [1, 0])),
        (50, state([0, 1], [1, 1])),
        (60, state([0, 2], [1, 1])),
        (70, state([0, 4], [1, 1])),
        (80, state([0, 6], [1, 1])),
    ];
    let expected = [
        motion(0, 1, (20, 40), MotionEnd::Done),
        motion(1, 1, (50, 60), MotionEnd::Stopped),
        motion(1, 1, (70, 80), MotionEnd::Undone),
    ];
    assert_eq!(notes(&mut observer, &seen), expected);
}

#[test]
fn a_motion_between_two_states_is_counted_without_times() {
    let mut observer = StationObserver::new(2);
    let whole = [(10, state([0, 3], [0, 0])), (90, state([3, 0], [1, 0]))];
    assert_eq!(notes(&mut observer, &whole), [motion(0, 1, (90, 90), MotionEnd::Unseen)]);
    // The end of one and the beginning of the next.
    let mut observer = StationObserver::new(2);
    let again = [(10, state([1, 0], [1, 0])), (90, state([1, 0], [2, 0])), (95, state([3, 0], [2, 0]))];
    let expected = [motion(0, 1, (90, 90), MotionEnd::Unseen), motion(0, 2, (90, 95), MotionEnd::Done)];
    assert_eq!(notes(&mut observer, &again), expected);
    // The counts of another life, or of another generation, say nothing of this.
    let other = StationState { boot_id: 2, ..state([3, 0], [7, 0]) };
    assert_eq!(notes(&mut observer, &[(99, other)]), []);
}

#[test]
fn a_wait_is_as_long_as_it_has_one_reason_in_auto() {
    let mut observer = StationObserver::new(2);
    let waits =
        |why: &str| StationState { blocked_by: vec![why.to_owned(), "its lock".to_owned()], ..state([0, 3], [0, 0]) };
    let waited = |why: &str, from, to| Note::Waited { station: 3, why: why.to_owned(), from: AT(from), to: AT(to) };
    let manual = StationState { mode: StationState::MODE_MANUAL, ..waits("a") };
    let seen = [
        (10, waits("a")),
        (15, StationState { blocked_by: vec!["a".to_owned()], ..waits("a") }),
        (20, waits("b")),
        (30, manual),
        (40, waits("b")),
    ];
    assert_eq!(notes(&mut observer, &seen), [waited("a", 10, 20), waited("b", 20, 30)]);
    // What goes on is noted now and then, and begins anew there.
    let mut out = Vec::new();
    observer.flush(3, AT(50), &mut out);
    observer.lost(3, AT(55), &mut out);
    observer.flush(3, AT(60), &mut out);
    assert_eq!(out, [waited("b", 40, 50), waited("b", 50, 55)]);
}

#[test]
fn a_fault_comes_and_goes_and_is_said_anew_where_the_observation_begins() {
    let mut observer = StationObserver::new(2);
    let failed = StationState { fault: "watchdog".to_owned(), ..state([2, 0], [1, 0]) };
    let fault = |text: &str| Note::Fault { station: 3, text: text.to_owned() };
    assert_eq!(notes(&mut observer, &[(10, failed.clone()), (20, failed)]), [fault("watchdog")]);
    let mut out = Vec::new();
    observer.begin(3, AT(30), &mut out);
    assert_eq!(out, [fault("watchdog")]);
    assert_eq!(notes(&mut observer, &[(40, state([3, 0], [1, 0]))]), [fault("")]);
}

#[test]
fn a_state_of_another_description_is_not_looked_at() {
    let mut observer = StationObserver::new(3);
    assert_eq!(notes(&mut observer, &[(10, state([1, 0], [1, 0])), (20, state([3, 0], [1, 0]))]), []);
}
