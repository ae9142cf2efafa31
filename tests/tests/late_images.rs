//! Input images that are late: what a motion may conclude from one that is older than itself.

use std::time::Duration;

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{OpId, Tick};
use linewright_station_logic::{Controller, ModeOrder, PanelCommand, Restore, Rules, StationInput, StationOutbox};
use linewright_tests::transfer_line;

fn manual() -> ModeOrder {
    ModeOrder { manual_all: true, ..ModeOrder::of(1, 1, ControlMode::Manual, Duration::from_secs(10)) }
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
    let line = transfer_line(1.0);
    let clamp = line.station_named("clamp_1").expect("a clamp");
    let described = line.station(clamp);
    let (open, advance) = (OpId(0), OpId(1));
    let mut controller =
        Controller::new(&line, clamp, 1, Restore::Fresh).expect("it compiles").with_rules(Rules::COUNTS);
    let mut snapshot = controller.snapshot();
    snapshot.marking = vec![StationPlace::incomplete(open)];
    (snapshot.cycle, snapshot.done, snapshot.started) = (2, vec![1, 1], vec![2, 1]);
    assert_eq!(described.operations[advance.index()].name, "advance clamp");
    controller =
        Controller::new(&line, clamp, 2, Restore::From(snapshot)).expect("it compiles").with_rules(Rules::COUNTS);

    let is_open = 1 << described.operations[open.index()].normal.complete.0;
    let mut out = StationOutbox::default();
    let mut now = Tick::from_millis(1000);
    let mut tell = |input: StationInput<'_>| {
        now = now + Duration::from_millis(5);
        controller.handle(now, input);
        controller.step(now, &mut out);
        (controller.marking().collect::<Vec<_>>(), out.number)
    };
    let image = |bits: u128, under: u64| StationInput::Inputs { bits, valid: true, until: Tick::NEVER, under };
    tell(StationInput::Order(manual()));
    tell(image(0, 0));
    let press = |advance: bool, held: bool| {
        StationInput::Panel(if advance { PanelCommand::Advance(held) } else { PanelCommand::Retract(held) })
    };
    let (opening, first) = tell(press(true, true));
    assert_eq!(opening, [StationPlace::operating(open)]);
    tell(press(true, false));
    assert_eq!(tell(press(false, true)).0, [StationPlace::undoing(open)], "it closes again");
    tell(press(false, false));
    let (opening, last) = tell(press(true, true));
    assert_eq!(opening, [StationPlace::operating(open)]);

    assert_eq!(tell(image(is_open, first)).0, [StationPlace::operating(open)], "that was the first opening");
    assert_eq!(tell(image(is_open, last)).0, [StationPlace::completed(open)], "this is the last");
}

/// The slide feeds in less time than the next image needs: the one at hand, from before it but under the same outputs, has
/// shown its switch off, and the next is from its end.
#[test]
fn a_motion_of_which_only_the_end_is_seen_has_arrived() {
    let line = transfer_line(1.0);
    let mill = line.station_named("mill_1").expect("a mill");
    let feed = OpId(2);
    let operations = &line.station(mill).operations;
    assert_eq!(operations[feed.index()].name, "feed main slide");
    let (fed, forward) = (1 << operations[2].normal.complete.0, 1 << operations[1].normal.complete.0);
    let decel = OpId(1);
    // What the image at hand shows, and how many numbers before the present one it was taken.
    for (at_start, age, arrives) in [(forward, 0, true), (forward | fed, 0, false), (forward, 1, false)] {
        let mut controller =
            Controller::new(&line, mill, 1, Restore::Fresh).expect("it compiles").with_rules(Rules::COUNTS);
        let mut snapshot = controller.snapshot();
        snapshot.marking = vec![StationPlace::completed(OpId(0))];
        (snapshot.cycle, snapshot.done, snapshot.started) = (1, vec![1, 0, 0, 0, 0], vec![1, 0, 0, 0, 0]);
        controller =
            Controller::new(&line, mill, 2, Restore::From(snapshot)).expect("it compiles").with_rules(Rules::COUNTS);
        let mut out = StationOutbox::default();
        let mut now = Tick::from_millis(1000);
        let mut tell = |input: StationInput<'_>| {
            now = now + Duration::from_millis(5);
            controller.handle(now, input);
            controller.step(now, &mut out);
            (controller.marking().collect::<Vec<_>>(), out.number)
        };
        let image = |bits: u128, under: u64| StationInput::Inputs { bits, valid: true, until: Tick::NEVER, under };
        let press = |held| StationInput::Panel(PanelCommand::Advance(held));
        tell(StationInput::Order(manual()));
        tell(image(0, 0));
        let (slowing, first) = tell(press(true));
        assert_eq!(slowing, [StationPlace::operating(decel)]);
        assert_eq!(tell(image(forward, first)).0, [StationPlace::completed(decel)]);
        let (_, standing) = tell(press(false));
        assert!(standing > first, "its output is off: another number");
        tell(image(at_start, standing - age));
        let (feeding, under) = tell(press(true));
        assert_eq!(feeding, [StationPlace::operating(feed)]);
        let (after, _) = tell(image(forward | fed, under));
        let expected = if arrives { StationPlace::completed(feed) } else { StationPlace::operating(feed) };
        assert_eq!(after, [expected], "shown {at_start:b}, {age} numbers before");
    }
}
