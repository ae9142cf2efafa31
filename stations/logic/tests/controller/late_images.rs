//! Input images that are late: what a motion may conclude from one that is older than itself.

use std::time::Duration;

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{OpId, Tick};
use linewright_station_logic::{Controller, Restore, Rules, StationInput};

use super::rig::Rig;
use linewright_testkit::built::transfer_line;

/// A station in manual mode with this marking and these counts, whose last image shows no switch.
fn stopped(station: &str, marking: StationPlace, cycle: i32, done: &[i32], started: &[i32]) -> Rig {
    let line = transfer_line();
    let id = line.station_named(station).expect("a station");
    let fresh = Controller::new(&line, id, 1, Restore::Fresh).expect("it compiles");
    let mut snapshot = fresh.with_rules(Rules::COUNTS).snapshot();
    snapshot.marking = vec![marking];
    (snapshot.cycle, snapshot.done, snapshot.started) = (cycle, done.to_vec(), started.to_vec());
    let mut rig = Rig::standing(line, id, 2, Restore::From(snapshot), 0);
    rig.mode(ControlMode::Manual);
    let number = rig.out.number;
    see(&mut rig, 0, number);
    rig
}

/// The marking after an image that was taken under the outputs of that number.
fn see(rig: &mut Rig, bits: u128, under: u64) -> Vec<StationPlace> {
    rig.now = rig.now + Duration::from_millis(5);
    rig.controller.handle(rig.now, StationInput::Inputs { bits, valid: true, until: Tick::NEVER, under });
    rig.step();
    rig.marking()
}

/// The marking with advance held, and the number of the outputs.
fn advanced(rig: &mut Rig) -> (Vec<StationPlace>, u64) {
    rig.advance(true);
    (rig.marking(), rig.out.number)
}

/// The bit of the switch at the end of an operation of a station.
fn switch(station: &str, operation: &str) -> (OpId, u128) {
    let line = transfer_line();
    let station = line.station(line.station_named(station).expect("a station"));
    let op = station.operation_named(operation).expect("an operation");
    (op, 1 << station.operations[op.index()].normal.complete.0)
}

/// A clamp that stands half open is opened, taken back and opened again, faster than its images come. The one at hand
/// is from before all that and shows the switch off; the next one is from the end of the *first* opening and shows it
/// on. Off and then on looks like an arrival, but neither was taken under the outputs of the motion they are judged for:
/// the clamp has closed again in between. (With 150 ms between gateway and station, one seed in some ten thousand of
/// `three_operators_at_three_panels_at_once` of `tests` lifts the bar under it: 10947.)
///
/// An image older than the motion may neither end it nor count as having seen the switch off.
#[test]
fn neither_off_nor_on_counts_in_an_image_from_before_the_motion() {
    let (open, is_open) = switch("clamp_1", "return clamp");
    let mut rig = stopped("clamp_1", StationPlace::incomplete(open), 2, &[1, 1], &[2, 1]);
    let (opening, first) = advanced(&mut rig);
    assert_eq!(opening, [StationPlace::operating(open)]);
    rig.advance(false);
    rig.retract(true);
    assert_eq!(rig.marking(), [StationPlace::undoing(open)], "it closes again");
    rig.retract(false);
    let (opening, last) = advanced(&mut rig);
    assert_eq!(opening, [StationPlace::operating(open)]);

    assert_eq!(see(&mut rig, is_open, first), [StationPlace::operating(open)], "that was the first opening");
    assert_eq!(see(&mut rig, is_open, last), [StationPlace::completed(open)], "this is the last");
}

/// The slide feeds in less time than the next image needs: the one at hand, from before it but under the same outputs, has
/// shown its switch off, and the next is from its end.
#[test]
fn a_motion_of_which_only_the_end_is_seen_has_arrived() {
    let (advance, _) = switch("mill_1", "rapid advance positioning slide");
    let ((decel, forward), (feed, fed)) = (switch("mill_1", "decel"), switch("mill_1", "feed main slide"));
    // The image at hand, and its age in image numbers.
    for (at_start, age, arrives) in [(forward, 0, true), (forward | fed, 0, false), (forward, 1, false)] {
        let mut rig = stopped("mill_1", StationPlace::completed(advance), 1, &[1, 0, 0, 0, 0], &[1, 0, 0, 0, 0]);
        let (slowing, first) = advanced(&mut rig);
        assert_eq!(slowing, [StationPlace::operating(decel)]);
        assert_eq!(see(&mut rig, forward, first), [StationPlace::completed(decel)]);
        rig.advance(false);
        let standing = rig.out.number;
        assert!(standing > first, "its output is off: another number");
        see(&mut rig, at_start, standing - age);
        let (feeding, under) = advanced(&mut rig);
        assert_eq!(feeding, [StationPlace::operating(feed)]);
        let after = see(&mut rig, forward | fed, under);
        let expected = if arrives { StationPlace::completed(feed) } else { StationPlace::operating(feed) };
        assert_eq!(after, [expected], "shown {at_start:b}, {age} numbers before");
    }
}
