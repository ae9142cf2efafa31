//! Lanes: what an operation did, and nothing that is not known.

use linewright_console_view::{LANE_WINDOW, LaneStretch, STRETCHES_MAX, StretchKind};
use linewright_line::StationId;
use linewright_msgs::StationState;

use crate::bench::{ViewBench, ms};

const OP: usize = 1;
const STATION: StationId = StationId(0);

fn state(bench: &ViewBench, place: u8, boot_id: u64) -> StationState {
    let mut state = bench.at_rest(STATION);
    state.places[OP] = place;
    state.stopped = !matches!(place, StationState::PLACE_OPERATING | StationState::PLACE_UNDOING);
    StationState { boot_id, ..state }
}

/// Takes a state that is received now.
fn take(bench: &mut ViewBench, now: u64, place: u8, boot_id: u64) {
    let state = state(bench, place, boot_id);
    bench.view.take_station(ms(now), STATION, &state);
    bench.stations[STATION.index()] = Some((state, now));
}

fn stretches(bench: &mut ViewBench, now: u64) -> Vec<(StretchKind, u64, Option<u64>)> {
    let page = bench.page(now);
    page.lanes[STATION.index()].lanes[OP].stretches.iter().map(|of| (of.kind, of.from_ms, of.to_ms)).collect()
}

use StretchKind::{Halted, Moving, Stopped, Undoing, Unknown};

#[test]
fn an_operation_is_drawn_from_its_states_also_between_two_pages() {
    let mut bench = ViewBench::new(false);
    take(&mut bench, 100, StationState::PLACE_COMPLETED, 1);
    take(&mut bench, 200, StationState::PLACE_OPERATING, 1);
    take(&mut bench, 230, StationState::PLACE_COMPLETED, 1);
    take(&mut bench, 300, StationState::PLACE_UNDOING, 1);
    take(&mut bench, 350, StationState::PLACE_INCOMPLETE, 1);
    let expected = [(Unknown, 0, Some(100)), (Moving, 200, Some(230)), (Undoing, 300, Some(350)), (Stopped, 350, None)];
    assert_eq!(stretches(&mut bench, 400), expected);
}

#[test]
fn an_operation_that_is_held_stands() {
    let mut bench = ViewBench::new(false);
    let held = StationState { stopped: true, ..state(&bench, StationState::PLACE_OPERATING, 1) };
    bench.view.take_station(ms(100), STATION, &held);
    bench.stations[STATION.index()] = Some((held, 100));
    assert_eq!(stretches(&mut bench, 120)[1], (Halted, 100, None));
}

/// The motion ends at its last state, not when that is found to be too old.
#[test]
fn a_motion_that_is_not_received_any_more_does_not_go_on() {
    let mut bench = ViewBench::new(false);
    take(&mut bench, 100, StationState::PLACE_OPERATING, 1);
    let lost = 100 + bench.fresh();
    assert_eq!(stretches(&mut bench, lost - 1).last(), Some(&(Moving, 100, None)));
    // Only the state of 100 was ever received: not even a ms of the motion is known.
    assert_eq!(stretches(&mut bench, lost), [(Unknown, 0, Some(100)), (Unknown, 100, None)]);
    take(&mut bench, lost + 500, StationState::PLACE_OPERATING, 1);
    assert_eq!(stretches(&mut bench, lost + 510).last(), Some(&(Moving, lost + 500, None)));
    take(&mut bench, lost + 600, StationState::PLACE_OPERATING, 1);
    let later = lost + 600 + bench.fresh();
    let all = stretches(&mut bench, later);
    assert_eq!(all[2..], [(Moving, lost + 500, Some(lost + 600)), (Unknown, lost + 600, None)]);
}

#[test]
fn between_two_lives_of_a_process_nothing_is_known() {
    let mut bench = ViewBench::new(false);
    take(&mut bench, 100, StationState::PLACE_OPERATING, 1);
    take(&mut bench, 150, StationState::PLACE_OPERATING, 1);
    take(&mut bench, 220, StationState::PLACE_OPERATING, 2);
    let expected = [(Unknown, 0, Some(100)), (Moving, 100, Some(150)), (Unknown, 150, Some(220)), (Moving, 220, None)];
    assert_eq!(stretches(&mut bench, 230), expected);
}

#[test]
fn a_place_that_is_not_known_here_is_unknown() {
    let mut bench = ViewBench::new(false);
    take(&mut bench, 100, 77, 1);
    assert_eq!(stretches(&mut bench, 120), [(Unknown, 0, None)]);
}

#[test]
fn lanes_are_bounded_and_what_is_left_out_is_unknown() {
    let mut bench = ViewBench::new(false);
    for cycle in 0..10 * STRETCHES_MAX as u64 {
        take(&mut bench, 100 + cycle * 10, StationState::PLACE_OPERATING, 1);
        take(&mut bench, 105 + cycle * 10, StationState::PLACE_COMPLETED, 1);
    }
    let now = 100 + 10_000;
    let all = stretches(&mut bench, now);
    assert_eq!(all.len(), STRETCHES_MAX);
    let (kind, from, to) = all[0];
    assert!(kind == Unknown && from == 0 && to.is_some_and(|to| to > 8_000), "{:?}", all[0]);
    assert!(all[1..].iter().all(|of| of.0 == Moving));
    take(&mut bench, now + 10, StationState::PLACE_OPERATING, 1);
    let window = u64::try_from(LANE_WINDOW.as_millis()).expect("short");
    take(&mut bench, now + window, StationState::PLACE_OPERATING, 1);
    let page = bench.page(now + window + 1);
    let left: &[LaneStretch] = &page.lanes[STATION.index()].lanes[OP].stretches;
    assert!(left.iter().all(|of| of.to_ms.is_none_or(|to| to > now)) && !left.is_empty(), "{left:?}");
}
