//! A drive on an axis that turns endlessly, and the manager's side of it: places on a circle, and positions that count within one turn.

use std::time::Duration;

use crate::drive_bench::Pair;
use linewright_line::{
    AtRest, AxisId, Drive as Described, DriveIndex, DriveMode, DriveTarget, Homing, InputId, OutputId, TurnDirection,
};
use linewright_plant::MotionFault;

const IN_PLACE: u128 = 1;
const FAULT: u128 = 1 << 4;
const TURN: u128 = 1;

/// A table of four places; turned by output 0 to the place in outputs 1 to 3, in place at input 0, its place in inputs 1 to 3.
fn table(direction: TurnDirection) -> Described {
    let bits = 1..4;
    let index = DriveIndex {
        places: 4,
        turn: 360.0,
        direction,
        to: bits.clone().map(OutputId).collect(),
        place: bits.map(InputId).collect(),
    };
    let target = |nth: u16| DriveTarget {
        output: OutputId(0),
        to: (index.sign() * 90.0 * f64::from(nth)).rem_euclid(360.0),
        at: InputId(0),
        velocity: 180.0,
    };
    Described {
        axis: AxisId(0),
        mode: DriveMode::Position,
        units_per_mm: 100.0,
        window: 0.5,
        velocity: 180.0,
        acceleration: 720.0,
        quick_stop: 1440.0,
        at_rest: AtRest::Hold,
        targets: (0..4).map(target).collect(),
        index: Some(index),
        fault: Some(InputId(4)),
        homing: None,
    }
}

fn homed(direction: TurnDirection, method: i8) -> Described {
    let homing =
        Homing { method, fast: 60.0, slow: 20.0, acceleration: 720.0, offset: 0.0, output: OutputId(0), done: None };
    Described { homing: Some(homing), ..table(direction) }
}

fn to(place: u128) -> u128 {
    TURN | place << 1
}

fn at(place: u128) -> u128 {
    IN_PLACE | place << 1
}

fn millis(millis: u64) -> Duration {
    Duration::from_millis(millis)
}

#[test]
fn over_several_turns_it_stops_at_each_place_whichever_way_it_turns() {
    for (direction, at_rest) in [
        (TurnDirection::Positive, AtRest::Hold),
        (TurnDirection::Negative, AtRest::Hold),
        (TurnDirection::Positive, AtRest::Off),
        (TurnDirection::Negative, AtRest::Off),
    ] {
        let mut pair = Pair::new(Described { at_rest, ..table(direction) }, 0.0, 1);
        let sign = table(direction).index.expect("it has one").sign();
        assert_eq!(pair.inputs(), at(1));
        for nth in 1..14u32 {
            let place = u128::from(nth % 4 + 1);
            let (from, end) = (sign * 90.0 * f64::from(nth - 1), sign * 90.0 * f64::from(nth));
            pair.set(to(place));
            pair.run(millis(1500), |pair| {
                let gone = (pair.place() - from) * sign;
                assert!((-0.01..=90.01).contains(&gone), "{direction:?} {nth}: {gone}");
                assert!(pair.inputs() != at(place) || (pair.place() - end).abs() <= 0.5);
            });
            assert_eq!(
                (pair.inputs(), pair.place()),
                (at(place), end),
                "{direction:?} {nth}: {}",
                pair.drive.explain()
            );
            // The same order again, as a message that comes late or after a restart gives it.
            for _ in 0..3 {
                pair.set(0);
                pair.run(millis(70), |_| {});
                pair.set(to(place));
                pair.run(millis(200), |_| {});
                assert_eq!((pair.inputs(), pair.place()), (at(place), end));
            }
            if nth % 2 == 0 {
                pair.set(0);
                pair.run(millis(100), |_| {});
            }
        }
    }
}

#[test]
fn a_hair_past_its_place_it_does_not_go_round_for_it() {
    for (direction, place, number) in [
        (TurnDirection::Positive, 90.4, 2),
        (TurnDirection::Positive, 89.6, 2),
        (TurnDirection::Positive, 0.4, 1),
        (TurnDirection::Positive, 359.7, 1),
        (TurnDirection::Negative, 269.6, 2),
        (TurnDirection::Negative, 359.7, 1),
    ] {
        let mut pair = Pair::new(table(direction), place, 1);
        assert_eq!(pair.inputs(), at(number));
        pair.set(to(number));
        pair.run(millis(1500), |pair| assert_eq!(pair.place(), place));
        assert_eq!(pair.inputs(), at(number), "{}", pair.drive.explain());
    }
}

#[test]
fn an_order_to_any_place_but_the_next_one_is_refused() {
    for (place, order) in [(0.0, 3), (0.0, 4), (45.0, 3), (45.0, 1), (92.0, 2), (300.0, 3), (300.0, 4)] {
        let mut pair = Pair::new(table(TurnDirection::Positive), place, 1);
        pair.set(to(order));
        pair.run(millis(1500), |pair| assert_eq!(pair.place(), place));
        assert_eq!(pair.inputs() & FAULT, FAULT);
        let explained = pair.drive.explain();
        assert!(explained.contains("which is not the next place from"), "{explained}");
        pair.set(0);
        pair.run(millis(100), |_| {});
        assert_eq!(pair.inputs() & FAULT, 0);
    }
    // To no place it is not turned, nor to one that it does not have.
    for order in [0, 5, 7] {
        let mut pair = Pair::new(table(TurnDirection::Positive), 45.0, 1);
        pair.set(to(order));
        pair.run(millis(1500), |pair| assert_eq!(pair.place(), 45.0));
        assert_eq!(pair.inputs(), 1 << 1, "it has left place 1");
    }
}

/// Let go at any moment, on a bus that loses and repeats frames: led on it ends at its place, or stays where it coasted to.
#[test]
fn let_go_on_the_way_it_goes_on_to_the_same_place_and_never_round() {
    let mut past = 0;
    for (quick_stop, at_rest) in [(1440.0, AtRest::Hold), (1440.0, AtRest::Off), (200.0, AtRest::Hold)] {
        for ms in (0..800u64).step_by(40) {
            let mut pair = Pair::new(Described { quick_stop, at_rest, ..table(TurnDirection::Positive) }, 0.0, ms + 1);
            pair.loss = 40;
            pair.set(to(2));
            pair.run(millis(ms), |_| {});
            pair.set(0);
            // Given anew while it still coasts, or when it stands.
            pair.run(millis(if ms % 80 == 0 { 10 } else { 1500 }), |_| {});
            pair.set(to(2));
            pair.run(millis(3000), |pair| assert!(pair.place() < 179.0, "{ms} ms: {}", pair.drive.explain()));
            let (place, inputs) = (pair.place(), pair.inputs());
            if (place - 90.0).abs() <= 0.5 {
                assert_eq!(inputs, at(2), "{ms} ms: {}", pair.drive.explain());
            } else {
                past += 1;
                assert!(place > 90.5, "{ms} ms: {place}, {}", pair.drive.explain());
                assert_eq!((inputs & IN_PLACE, inputs & FAULT), (0, FAULT), "{ms} ms: {}", pair.drive.explain());
            }
        }
    }
    assert!(past > 0, "some coast past their place");
}

/// The order comes back while it coasts through the window of its place.
#[test]
fn ordered_to_the_place_through_which_it_coasts_it_is_not_there_before_it_stands() {
    for at_rest in [AtRest::Hold, AtRest::Off] {
        let mut coasted = 0;
        for ms in 0..100u64 {
            // So wide that it is in there for a while.
            let table = Described { quick_stop: 200.0, at_rest, window: 20.0, ..table(TurnDirection::Positive) };
            let mut pair = Pair::new(table, 0.0, 1);
            pair.set(to(2));
            pair.run(millis(300 + 5 * ms), |_| {});
            pair.set(0);
            pair.run(millis(40), |_| {});
            let (begins, mut before) = (pair.place(), pair.place());
            pair.set(to(2));
            pair.run(millis(1500), |pair| {
                let moved = (pair.place() - before).abs();
                before = pair.place();
                assert!(pair.inputs() != at(2) || moved < 0.05, "{at_rest:?} {ms}: {moved}, {}", pair.drive.explain());
            });
            let is_there = (70.0..=110.0).contains(&pair.place());
            coasted += u32::from((70.0..=110.0).contains(&begins) && is_there && pair.place() - begins > 1.0);
            assert!(!is_there || pair.inputs() == at(2), "{at_rest:?} {ms}: {}", pair.drive.explain());
        }
        assert!(coasted > 0, "{at_rest:?}: some come to a stand within the window");
    }
}

#[test]
fn not_homed_it_knows_no_place_and_is_homed_by_an_order_to_none() {
    for (direction, method, end) in [(TurnDirection::Positive, 2, 360.0), (TurnDirection::Negative, 1, 0.0)] {
        let mut pair = Pair::new(homed(direction, method), 37.0, 1);
        assert_eq!(pair.inputs(), 0);
        pair.set(to(2));
        pair.run(millis(1500), |pair| assert_eq!(pair.place(), 37.0));
        assert_eq!(pair.inputs(), FAULT, "{}", pair.drive.explain());
        pair.set(0);
        pair.run(millis(100), |_| {});
        pair.set(to(0));
        pair.run(millis(9000), |pair| assert!(pair.inputs() == 0 || (pair.place() - end).abs() < 0.01));
        assert_eq!((pair.inputs(), pair.place().round()), (at(1), end), "{}", pair.drive.explain());
        // The same output, now with a place.
        pair.set(to(2));
        pair.run(millis(1500), |_| {});
        let sign = table(direction).index.expect("it has one").sign();
        assert_eq!((pair.inputs(), pair.place().round()), (at(2), end + sign * 90.0));
        // It was lost: what it knew is forgotten.
        pair.drive.lost(pair.now);
        assert_eq!(pair.inputs() & !FAULT, 0);
    }
}

#[test]
fn a_stuck_table_trips_wherever_it_goes() {
    let mut pair = Pair::new(table(TurnDirection::Positive), 0.0, 1);
    for place in [2, 3] {
        pair.set(to(place));
        pair.run(millis(300), |_| {});
        pair.fail_motion(0, Some(MotionFault::Stick));
        pair.run(millis(1500), |_| {});
        assert_eq!(pair.inputs(), FAULT | (place - 1) << 1, "{}", pair.drive.explain());
        pair.fail_motion(0, None);
        pair.set(0);
        pair.run(millis(1500), |_| {});
        pair.set(to(place));
        pair.run(millis(1500), |_| {});
        assert_eq!(pair.inputs(), at(place), "{}", pair.drive.explain());
    }
}
