//! Input images that are late: what a motion may conclude from one that is older than itself.

use std::time::Duration;

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{OpId, Tick};
use linewright_station_logic::{Controller, ModeOrder, PanelCommand, Restore, Rules, StationInput, StationOutbox};
use linewright_tests::transfer_line;

fn manual() -> ModeOrder {
    ModeOrder { manual_all: true, ..ModeOrder::of(1, 1, ControlMode::Manual, Duration::from_secs(10)) }
}

fn press(advance: bool, held: bool) -> StationInput<'static> {
    StationInput::Panel(if advance { PanelCommand::Advance(held) } else { PanelCommand::Retract(held) })
}

fn image(bits: u128, under: u64) -> StationInput<'static> {
    StationInput::Inputs { bits, valid: true, until: Tick::NEVER, under }
}

/// A controller by itself, every 5 ms.
struct LateImagesBench {
    controller: Controller,
    out: StationOutbox,
    now: Tick,
}

impl LateImagesBench {
    /// A station in manual mode with this marking and these counts, whose last image shows no switch.
    fn new(station: &str, marking: StationPlace, cycle: i32, done: &[i32], started: &[i32]) -> Self {
        let line = transfer_line(1.0);
        let id = line.station_named(station).expect("a station");
        let fresh = Controller::new(&line, id, 1, Restore::Fresh).expect("it compiles");
        let mut snapshot = fresh.with_rules(Rules::COUNTS).snapshot();
        snapshot.marking = vec![marking];
        (snapshot.cycle, snapshot.done, snapshot.started) = (cycle, done.to_vec(), started.to_vec());
        let restored = Controller::new(&line, id, 2, Restore::From(snapshot)).expect("it compiles");
        let controller = restored.with_rules(Rules::COUNTS);
        let mut bench = LateImagesBench { controller, out: StationOutbox::default(), now: Tick::from_millis(1000) };
        bench.step(StationInput::Order(manual()));
        let number = bench.out.number;
        bench.step(image(0, number));
        bench
    }

    /// The marking after an input, and the number of the outputs.
    fn step(&mut self, input: StationInput<'_>) -> (Vec<StationPlace>, u64) {
        self.now = self.now + Duration::from_millis(5);
        self.controller.handle(self.now, input);
        self.controller.step(self.now, &mut self.out);
        (self.controller.marking().collect(), self.out.number)
    }
}

/// The bit of the switch at the end of an operation of a station.
fn switch(station: &str, operation: &str) -> (OpId, u128) {
    let line = transfer_line(1.0);
    let station = line.station(line.station_named(station).expect("a station"));
    let op = station.operation_named(operation).expect("an operation");
    (op, 1 << station.operations[op.index()].normal.complete.0)
}

/// A clamp that stands half open is opened, taken back and opened again, faster than its images come. The one at hand
/// is from before all that and shows the switch off; the next one is from the end of the *first* opening and shows it
/// on. Off and then on looks like an arrival, but neither was taken under the outputs of the motion they are judged for:
/// the clamp has closed again in between. (With 150 ms between gateway and station, one seed in some ten thousand of
/// `three_operators_at_three_panels_at_once` lifts the bar under it: 10947.)
///
/// An image older than the motion may neither end it nor count as having seen the switch off.
#[test]
fn neither_off_nor_on_counts_in_an_image_from_before_the_motion() {
    let (open, is_open) = switch("clamp_1", "return clamp");
    let mut bench = LateImagesBench::new("clamp_1", StationPlace::incomplete(open), 2, &[1, 1], &[2, 1]);
    let (opening, first) = bench.step(press(true, true));
    assert_eq!(opening, [StationPlace::operating(open)]);
    bench.step(press(true, false));
    assert_eq!(bench.step(press(false, true)).0, [StationPlace::undoing(open)], "it closes again");
    bench.step(press(false, false));
    let (opening, last) = bench.step(press(true, true));
    assert_eq!(opening, [StationPlace::operating(open)]);

    assert_eq!(bench.step(image(is_open, first)).0, [StationPlace::operating(open)], "that was the first opening");
    assert_eq!(bench.step(image(is_open, last)).0, [StationPlace::completed(open)], "this is the last");
}

/// The slide feeds in less time than the next image needs: the one at hand, from before it but under the same outputs, has
/// shown its switch off, and the next is from its end.
#[test]
fn a_motion_of_which_only_the_end_is_seen_has_arrived() {
    let (advance, _) = switch("mill_1", "rapid advance positioning slide");
    let ((decel, forward), (feed, fed)) = (switch("mill_1", "decel"), switch("mill_1", "feed main slide"));
    // The image at hand, and its age in image numbers.
    for (at_start, age, arrives) in [(forward, 0, true), (forward | fed, 0, false), (forward, 1, false)] {
        let mut bench =
            LateImagesBench::new("mill_1", StationPlace::completed(advance), 1, &[1, 0, 0, 0, 0], &[1, 0, 0, 0, 0]);
        let (slowing, first) = bench.step(press(true, true));
        assert_eq!(slowing, [StationPlace::operating(decel)]);
        assert_eq!(bench.step(image(forward, first)).0, [StationPlace::completed(decel)]);
        let (_, standing) = bench.step(press(true, false));
        assert!(standing > first, "its output is off: another number");
        bench.step(image(at_start, standing - age));
        let (feeding, under) = bench.step(press(true, true));
        assert_eq!(feeding, [StationPlace::operating(feed)]);
        let (after, _) = bench.step(image(forward | fed, under));
        let expected = if arrives { StationPlace::completed(feed) } else { StationPlace::operating(feed) };
        assert_eq!(after, [expected], "shown {at_start:b}, {age} numbers before");
    }
}
