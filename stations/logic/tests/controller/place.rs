//! The index of an endless axis that a drive turns: it is an order to a place, and the place is measured.

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{Line, OpId, StationId, parse};
use linewright_station_logic::{Controller, Restore};

use super::rig::Rig;

const INDEX: OpId = OpId(0);
const IN_PLACE: u128 = 1 << 3;
const FAULT: u128 = 1 << 7;
const TURN: u128 = 1 << 1;

/// The inputs of a drive that is at a place.
fn at(place: u128) -> u128 {
    IN_PLACE | after(place)
}

/// Of one that has left it, and is on the way to the next one.
fn after(place: u128) -> u128 {
    place << 4
}

/// The outputs of an order to a place.
fn order(place: u128) -> u128 {
    TURN | place << 2
}

/// The example, whose first station is the table.
fn line() -> Line {
    let text = include_str!("../../../../examples/driven-table.toml");
    parse("driven-table.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

fn up(restore: Restore, image: u128) -> Rig {
    let mut rig = Rig::alone(line(), StationId(0), restore, image);
    rig.refresh();
    rig
}

fn see(rig: &mut Rig, image: u128) {
    rig.image = image;
    rig.set(0, true);
}

/// In auto, under way from a place.
fn under_way(from: u128) -> Rig {
    let mut rig = up(Restore::Fresh, at(from));
    rig.mode(ControlMode::Auto);
    see(&mut rig, after(from));
    rig
}

#[test]
fn an_index_is_an_order_to_the_next_place_and_past_the_last_one_to_the_first() {
    for (from, to) in [(1, 2), (3, 4), (4, 1)] {
        let mut rig = up(Restore::Fresh, at(from));
        rig.mode(ControlMode::Auto);
        assert_eq!(rig.outputs, order(to), "before it has moved");
        see(&mut rig, after(from));
        assert_eq!(rig.outputs, order(to), "and on its way");
        rig.mode(ControlMode::StandBy);
        see(&mut rig, at(to));
        assert_eq!((rig.outputs, rig.report().done[0]), (0, 1));
        assert!(rig.report().at_home);
        rig.mode(ControlMode::Auto);
        assert_eq!(rig.outputs, order(to % 4 + 1), "the next one goes on from there");
    }
}

#[test]
fn restarted_at_any_moment_of_an_index_it_knows_whether_it_is_done() {
    let kept = under_way(2).controller.snapshot();
    // It had not left, it was half-way, it had arrived meanwhile: an order to place 3 is right in each case.
    for (image, driven) in [(at(2), order(3)), (after(2), order(3)), (at(3), 0)] {
        let mut rig = up(Restore::From(kept.clone()), image);
        assert_eq!((rig.outputs & TURN, rig.controller.position_lost()), (0, None));
        rig.manual();
        assert_eq!(rig.outputs, driven);
        see(&mut rig, at(3));
        assert_eq!((rig.outputs, rig.report().done[0]), (0, 1), "once, whatever it was");
    }
    // Anywhere else it was turned by something else.
    for image in [at(4), after(4), at(1), after(1), after(3)] {
        let mut rig = up(Restore::From(kept.clone()), image);
        assert!(rig.is_doubtful(), "{image:b}");
        rig.manual();
        assert_eq!(rig.outputs & TURN, 0);
        assert!(up(Restore::From(rig.controller.snapshot()), at(3)).controller.position_lost().is_some(), "it lasts");
    }
}

#[test]
fn turned_by_hand_while_it_was_off_it_is_in_doubt_and_a_person_confirms_the_new_place() {
    let mut before = under_way(2);
    before.mode(ControlMode::StandBy);
    see(&mut before, at(3));
    let kept = before.controller.snapshot();
    assert_eq!(kept.place, 3);
    assert_eq!(up(Restore::From(kept.clone()), at(3)).controller.position_lost(), None);
    // The switch of a place alone could not tell this.
    let mut rig = up(Restore::From(kept), at(1));
    assert!(rig.is_doubtful());
    let doubt = "index in doubt: measured at or after place 1, last known at place 3; look at the mechanism, then confirm with \
                 rejoin";
    assert_eq!(rig.fault(), doubt);
    assert_eq!(rig.events(), [doubt]);
    let confirm = "rejoin: at another place than expected; look at the mechanism, then confirm its place with rejoin";
    assert_eq!(rig.blocked_by()[..2], [doubt, confirm]);
    rig.manual();
    assert_eq!(rig.outputs & TURN, 0);
    rig.advance(false);
    assert!(rig.rejoin(None).is_taken());
    assert_eq!((rig.controller.position_lost(), rig.controller.is_at_home()), (None, true));
    rig.manual();
    assert_eq!(rig.outputs, order(2));
}

#[test]
fn turned_by_hand_while_it_stands_it_is_in_doubt_on_a_place_and_off_it() {
    for image in [after(2), at(3), after(1)] {
        let mut rig = up(Restore::Fresh, at(2));
        see(&mut rig, image);
        assert!(rig.is_doubtful(), "{image:b}");
        see(&mut rig, at(2));
        assert!(rig.is_doubtful(), "a doubt ends by a person");
    }
    // Off a place, named as under way: it is led on to the place after the one that it has left.
    let mut rig = up(Restore::Fresh, at(2));
    see(&mut rig, after(3));
    assert!(rig.rejoin(Some(INDEX)).is_taken());
    rig.manual();
    assert_eq!(rig.outputs, order(4));
    see(&mut rig, at(4));
    assert!(rig.controller.is_at_home());
}

#[test]
fn a_drive_that_overshoots_may_come_back_and_one_that_stays_past_its_place_is_in_doubt() {
    let mut rig = under_way(2);
    see(&mut rig, after(3));
    assert_eq!((rig.outputs, rig.controller.position_lost()), (order(3), None), "it is still regulating");
    see(&mut rig, at(3));
    assert_eq!(rig.report().done[0], 1);

    let mut rig = under_way(2);
    see(&mut rig, after(3));
    see(&mut rig, after(3) | FAULT);
    rig.wait_ms(400);
    assert_eq!(rig.outputs & TURN, 0);
    assert!(rig.is_doubtful(), "{}", rig.fault());
    // Gone on past the next place as well.
    let mut rig = under_way(2);
    see(&mut rig, at(4));
    assert!(rig.is_doubtful());
}

#[test]
fn half_way_it_is_stopped_and_led_on_to_the_same_place_however_long_that_takes() {
    let mut rig = under_way(4);
    see(&mut rig, after(4) | FAULT);
    assert_eq!((rig.outputs & TURN, rig.marking()), (0, vec![StationPlace::incomplete(INDEX)]));
    see(&mut rig, after(4));
    rig.wait_ms(60_000);
    for _ in 0..3 {
        rig.manual();
        assert_eq!(rig.outputs, order(1));
        rig.advance(false);
    }
    // The watchdog leaves no doubt either.
    rig.manual();
    rig.wait_ms(3_000);
    assert_eq!((rig.outputs & TURN, rig.controller.position_lost()), (0, None));
    rig.advance(false);
    rig.advance(true);
    assert_eq!(rig.outputs, order(1));
    see(&mut rig, at(1));
    assert!(rig.controller.is_at_home());
}

#[test]
fn a_drive_that_has_lost_its_zero_is_homed_by_a_person_and_never_in_auto() {
    // Under way in auto: it is ordered on to its place, which a drive that is not homed refuses.
    let mut rig = under_way(2);
    see(&mut rig, 0);
    assert_eq!(rig.outputs, order(3));
    // At rest its place is lost with it.
    let mut rig = up(Restore::Fresh, at(2));
    see(&mut rig, 0);
    assert!(rig.is_doubtful());
    assert!(rig.rejoin(Some(INDEX)).is_taken());
    rig.manual();
    assert_eq!(rig.outputs, TURN, "to no place: it is homed");
    see(&mut rig, after(3));
    assert_eq!(rig.outputs, order(4), "and led on from where it finds itself");
    see(&mut rig, at(4));
    assert!(rig.controller.is_at_home());
    // Switched on for the first time, not homed: homed at place 1, it is at home.
    let mut rig = up(Restore::Fresh, 0);
    assert_eq!(rig.marking(), [StationPlace::incomplete(INDEX)]);
    rig.manual();
    assert_eq!(rig.outputs, TURN);
    see(&mut rig, at(1));
    assert_eq!((rig.outputs & TURN, rig.controller.is_at_home()), (0, true));
}

#[test]
fn devices_that_are_lost_at_any_moment_are_believed_again_where_they_measure() {
    for (back, lost) in [(at(2), false), (after(2), false), (at(3), false), (at(4), true)] {
        let mut rig = under_way(2);
        rig.devices(false);
        rig.wait_ms(300);
        assert_eq!((rig.outputs & TURN, rig.controller.position_lost()), (0, None));
        rig.image = back;
        rig.devices(true);
        assert_eq!(rig.is_doubtful(), lost, "{back:b}");
    }
}

#[test]
fn a_place_that_the_axis_does_not_have_is_no_memory() {
    let rig = under_way(2);
    let mut kept = rig.controller.snapshot();
    kept.place = 5;
    assert!(Controller::new(&rig.line, StationId(0), 1, Restore::From(kept)).is_err());
}
