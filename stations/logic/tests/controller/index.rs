//! The index of an endless axis: its switch goes off and comes on again. What is known of it when it does not, and before a
//! person has looked.

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{Line, OpId, StationId, parse};
use linewright_station_logic::{Controller, Handled, Ignored, Restore};

use super::rig::Rig;

const INDEX: OpId = OpId(0);
const IN_PLACE: u128 = 1;
const TURN: u128 = 1;

/// The example, whose first station is the table.
fn line() -> Line {
    let text = include_str!("../../../../examples/rotary-table.toml");
    parse("rotary-table.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

fn up(restore: Restore, image: u128) -> Rig {
    Rig::alone(line(), StationId(0), restore, image)
}

/// At home, the switch on.
fn table() -> Rig {
    up(Restore::Fresh, IN_PLACE)
}

/// In auto, under way.
fn under_way() -> Rig {
    let mut rig = table();
    rig.mode(ControlMode::Auto);
    rig.wait_ms(50);
    rig.set(IN_PLACE, false);
    rig.wait_ms(550);
    rig
}

fn done(rig: &Rig) -> i32 {
    rig.report().done[0]
}

/// It moves in no mode, whatever is pressed.
fn stays(rig: &mut Rig) {
    rig.mode(ControlMode::Auto);
    rig.wait_ms(100);
    assert_eq!(rig.outputs & TURN, 0);
    rig.mode(ControlMode::Manual);
    for _ in 0..2 {
        rig.advance(true);
        rig.wait_ms(100);
        assert_eq!((rig.outputs & TURN, done(rig)), (0, 0), "{}", rig.doing());
        rig.advance(false);
    }
}

#[test]
fn an_index_is_complete_when_its_switch_went_off_and_on_again() {
    let mut rig = table();
    rig.mode(ControlMode::Auto);
    assert_eq!(rig.outputs, TURN);
    rig.wait_ms(100);
    assert_eq!((rig.outputs, done(&rig)), (TURN, 0), "on from the start is no arrival");
    rig.set(IN_PLACE, false);
    rig.wait_ms(800);
    rig.mode(ControlMode::StandBy);
    assert_eq!((rig.outputs, done(&rig)), (TURN, 0), "what runs is finished");
    rig.set(IN_PLACE, true);
    assert_eq!((rig.outputs, done(&rig)), (0, 1));
    assert!(rig.report().at_home);
}

#[test]
fn a_switch_that_never_goes_off_is_found_by_the_watchdog_and_one_that_never_comes_on_too() {
    let mut on = table();
    on.mode(ControlMode::Auto);
    on.wait_ms(2000);
    assert_eq!((on.outputs & TURN, done(&on)), (0, 0));
    let fault = "index: watchdog: LS_in_place (table io, node 11h, 6000h:01 bit 0) was on all the time for 1.8 s; check drive \
                 and switch";
    assert!(on.fault().starts_with(fault), "{}", on.fault());
    let doubt =
        "index in doubt: LS_in_place (table io, node 11h, 6000h:01 bit 0) does not tell whether `index` is done";
    assert!(on.fault().contains(doubt), "{}", on.fault());
    assert!(on.is_doubtful(), "it may stand where it began, and at the next place");
    stays(&mut on);

    let mut off = under_way();
    off.wait_ms(1500);
    assert_eq!((off.outputs & TURN, done(&off)), (0, 0));
    assert!(off.controller.fault_text(&off.line).contains("not on within 1.8 s"));
    assert!(off.is_doubtful(), "its switch may be stuck, and the place passed");
    stays(&mut off);
    let asks = off.blocked_by().join("; ");
    assert!(asks.contains("then name its operation with rejoin; possible: `index`"), "{asks}");
    // A person has looked: it has not come to its place. Advance alone leads out, and return leads nowhere.
    assert!(off.rejoin(Some(INDEX)).is_taken());
    let before = done(&off);
    off.retract(true);
    assert_eq!(off.outputs & TURN, 0);
    off.retract(false);
    off.advance(true);
    assert_eq!(off.outputs & TURN, TURN);
    off.wait_ms(300);
    off.set(IN_PLACE, true);
    assert_eq!((off.outputs, done(&off)), (0, before + 1));
}

#[test]
fn driven_for_longer_than_one_index_takes_it_may_have_passed_a_place() {
    for (ms, believed) in [(900, true), (1000, false)] {
        let mut rig = under_way();
        rig.mode(ControlMode::StandBy);
        rig.wait_ms(ms);
        rig.set(IN_PLACE, true);
        assert_eq!((rig.outputs & TURN, done(&rig), rig.is_doubtful()), (0, i32::from(believed), !believed));
    }
    // Over stops as well.
    let mut rig = under_way();
    rig.mode(ControlMode::EStop);
    rig.manual();
    rig.wait_ms(1000);
    rig.set(IN_PLACE, true);
    assert!(rig.is_doubtful());
}

#[test]
fn let_go_half_way_it_stays_half_way_and_goes_on_to_the_next_place() {
    let mut rig = table();
    rig.manual();
    rig.set(IN_PLACE, false);
    rig.wait_ms(300);
    rig.advance(false);
    assert_eq!((rig.outputs & TURN, rig.marking()), (0, vec![StationPlace::incomplete(INDEX)]));
    assert_eq!(rig.controller.position_lost(), None);
    rig.advance(true);
    rig.wait_ms(300);
    rig.set(IN_PLACE, true);
    assert_eq!((rig.outputs, done(&rig)), (0, 1), "300 ms and 300 ms of a second are no flicker");
}

#[test]
fn let_go_before_it_has_left_it_is_no_index_yet() {
    let mut rig = table();
    rig.manual();
    rig.wait_ms(20);
    rig.advance(false);
    rig.advance(true);
    assert_eq!((rig.outputs, done(&rig)), (TURN, 0), "its switch is on, where it began");
    rig.set(IN_PLACE, false);
    rig.wait_ms(900);
    rig.set(IN_PLACE, true);
    assert_eq!((rig.outputs, done(&rig)), (0, 1));
}

#[test]
fn coasted_into_its_place_it_is_complete_without_being_driven_again() {
    let mut rig = under_way();
    rig.mode(ControlMode::EStop);
    rig.set(IN_PLACE, true);
    assert_eq!((rig.outputs & TURN, done(&rig)), (0, 0));
    rig.mode(ControlMode::Manual);
    let mut driven = 0;
    rig.advance(true);
    driven |= rig.outputs;
    assert_eq!((driven & TURN, done(&rig)), (0, 1));
}

#[test]
fn turned_on_by_hand_long_after_it_has_stopped_it_is_in_doubt() {
    let stops: [fn(&mut Rig); 2] = [|rig| rig.mode(ControlMode::EStop), |rig| rig.devices(false)];
    for stop in stops {
        let mut rig = under_way();
        stop(&mut rig);
        rig.wait_ms(300);
        rig.image |= IN_PLACE;
        rig.devices(true);
        assert!(rig.is_doubtful(), "{}", rig.doing());
        stays(&mut rig);
    }
    // Released in hand mode, it is under way and not driven.
    let mut rig = table();
    rig.mode(ControlMode::Hand);
    rig.hold(0);
    rig.set(IN_PLACE, false);
    rig.wait_ms(600);
    rig.release(0);
    rig.wait_ms(300);
    rig.set(IN_PLACE, true);
    assert!(rig.is_doubtful());
}

#[test]
fn coasted_past_its_place_it_is_in_doubt() {
    let mut rig = under_way();
    rig.mode(ControlMode::EStop);
    rig.set(IN_PLACE, true);
    rig.set(IN_PLACE, false);
    rig.set(IN_PLACE, true);
    assert!(rig.is_doubtful(), "{}", rig.fault());
    stays(&mut rig);
}

#[test]
fn a_flicker_where_it_begins_is_no_index() {
    let mut rig = table();
    rig.mode(ControlMode::Auto);
    rig.wait_ms(50);
    rig.set(IN_PLACE, false);
    rig.wait_ms(20);
    rig.set(IN_PLACE, true);
    assert_eq!((rig.outputs & TURN, done(&rig)), (0, 0));
    assert!(rig.is_doubtful(), "{}", rig.fault());
    stays(&mut rig);
    // A flicker as it is stopped is none either.
    let mut stopped = table();
    stopped.manual();
    stopped.wait_ms(50);
    stopped.advance(false);
    stopped.set(IN_PLACE, false);
    stopped.set(IN_PLACE, true);
    assert!(stopped.is_doubtful());
}

#[test]
fn devices_that_were_lost_as_it_set_out_leave_a_doubt_and_half_way_they_leave_none() {
    let mut rig = table();
    rig.mode(ControlMode::Auto);
    rig.wait_ms(50);
    rig.devices(false);
    rig.wait_ms(500);
    assert_eq!(rig.controller.position_lost(), None, "nothing is known, and nothing is claimed");
    rig.devices(true);
    assert!(rig.is_doubtful());
    stays(&mut rig);

    for comes in [false, true] {
        let mut rig = under_way();
        rig.devices(false);
        rig.wait_ms(200);
        rig.set(IN_PLACE, comes);
        rig.devices(true);
        assert_eq!(rig.controller.position_lost(), None);
        rig.manual();
        assert_eq!((rig.outputs & TURN != 0, done(&rig)), (!comes, i32::from(comes)));
    }
}

#[test]
fn restarted_with_its_memory_it_goes_on_from_half_way_and_is_in_doubt_at_its_switch() {
    let half_way = under_way().controller.snapshot();
    let mut rig = up(Restore::From(half_way.clone()), 0);
    assert_eq!(rig.controller.position_lost(), None);
    rig.manual();
    assert_eq!(rig.outputs & TURN, TURN);
    rig.wait_ms(300);
    rig.set(IN_PLACE, true);
    assert_eq!((rig.outputs, done(&rig)), (0, 1), "how much was left is not known, and its switch was off");
    // It may as well stand at its edge: a switch that flickers there is no arrival, driven or not.
    for driven in [false, true] {
        let mut rig = up(Restore::From(half_way.clone()), 0);
        rig.manual();
        rig.wait_ms(50);
        rig.advance(driven);
        rig.set(IN_PLACE, true);
        assert!(rig.is_doubtful(), "driven: {driven}");
    }

    let mut rig = up(Restore::From(half_way), IN_PLACE);
    rig.refresh();
    assert!(rig.is_doubtful(), "{}", rig.fault());
    stays(&mut rig);
    let asks = rig.blocked_by().join("; ");
    assert!(
        asks.contains("rejoin: not certain whether its index is done; its switch is on before `index` and after it"),
        "{asks}"
    );
    assert!(rig.rejoin(None).is_taken());
    assert_eq!((rig.controller.position_lost(), rig.controller.is_at_home()), (None, true));
    rig.manual();
    assert_eq!(rig.outputs & TURN, TURN);
}

#[test]
fn restarted_at_rest_it_stands_as_it_was_and_without_its_memory_at_home() {
    for restore in [Restore::From(table().controller.snapshot()), Restore::Fresh] {
        let rig = up(restore, IN_PLACE);
        assert_eq!((rig.controller.is_at_home(), rig.controller.position_lost()), (true, None));
    }
    // Half-way without its memory it is not at home; on is the way.
    let mut rig = up(Restore::Fresh, 0);
    assert_eq!(rig.marking(), [StationPlace::incomplete(INDEX)]);
    rig.manual();
    rig.wait_ms(300);
    rig.set(IN_PLACE, true);
    assert!(rig.controller.is_at_home());
}

#[test]
fn moved_off_its_place_while_it_stood_it_is_not_led_on() {
    let mut rig = table();
    rig.set(IN_PLACE, false);
    assert!(rig.controller.position_lost().is_some());
    stays(&mut rig);
    // Named, it is under way, and is led to the next place.
    assert!(rig.rejoin(Some(INDEX)).is_taken());
    rig.manual();
    rig.advance(false);
    rig.advance(true);
    assert_eq!(rig.outputs & TURN, TURN);
    rig.wait_ms(300);
    rig.set(IN_PLACE, true);
    assert!(rig.controller.is_at_home());
    // Turned on to a place again, it may be another one: found by a person, and by nothing else.
    let mut rig = table();
    rig.set(IN_PLACE, false);
    rig.set(IN_PLACE, true);
    assert!(rig.is_doubtful());
    stays(&mut rig);
    assert!(rig.rejoin(None).is_taken());
    assert_eq!((rig.controller.position_lost(), rig.controller.is_at_home()), (None, true));
}

#[test]
fn a_doubt_outlives_a_restart_and_the_loss_of_its_devices() {
    let at_rest = |rig: &mut Rig| {
        rig.set(IN_PLACE, false);
        rig.set(IN_PLACE, true);
    };
    let stuck = |rig: &mut Rig| {
        rig.mode(ControlMode::Auto);
        rig.wait_ms(2000);
    };
    let stuck_off = |rig: &mut Rig| {
        rig.mode(ControlMode::Auto);
        rig.set(IN_PLACE, false);
        rig.wait_ms(2000);
    };
    let stories: [&dyn Fn(&mut Rig); 3] = [&at_rest, &stuck, &stuck_off];
    for story in stories {
        let mut rig = table();
        story(&mut rig);
        assert!(rig.is_doubtful());
        rig.events();
        rig.devices(false);
        assert!(rig.is_doubtful(), "without devices");
        assert!(rig.report().position_lost.is_some());
        assert!(!rig.events().iter().any(|event| event.contains("confirmed by")));
        for image in [0, IN_PLACE] {
            let mut again = up(Restore::From(rig.controller.snapshot()), image);
            assert!(again.is_doubtful(), "restarted");
            stays(&mut again);
        }
    }
    let rig = table();
    let mut contradicts = rig.controller.snapshot();
    contradicts.doubtful = Some(OpId(1));
    assert!(Controller::new(&rig.line, StationId(0), 1, Restore::From(contradicts)).is_err());
}

#[test]
fn a_position_is_not_found_by_an_image_that_is_not_valid() {
    let mut rig = Rig::alone(line(), StationId(1), Restore::Fresh, 1);
    rig.set(1, false);
    assert!(rig.controller.position_lost().is_some());
    rig.events();
    rig.devices(false);
    let events = rig.events();
    assert!(!events.iter().any(|event| event.contains("confirmed by")), "{events:?}");
    rig.set(1, true);
    rig.devices(true);
    assert!(rig.events().iter().any(|event| event.contains("confirmed by")));
}

#[test]
fn in_hand_mode_it_turns_while_its_button_is_held() {
    let mut rig = table();
    rig.mode(ControlMode::Hand);
    rig.hold(0);
    assert_eq!(rig.outputs & TURN, TURN);
    rig.set(IN_PLACE, false);
    rig.wait_ms(600);
    rig.release(0);
    assert_eq!(rig.outputs & TURN, 0);
    rig.wait_ms(5000);
    rig.hold(0);
    assert_eq!(rig.outputs & TURN, TURN, "its watchdog stood still with it");
    rig.wait_ms(400);
    rig.set(IN_PLACE, true);
    assert_eq!((rig.outputs & TURN, done(&rig)), (0, 1), "held on, it does not begin another");
    rig.wait_ms(100);
    assert_eq!(rig.outputs & TURN, 0);
}

/// A table with a bolt: before and after the index its switches are the same.
#[test]
fn where_switches_fit_two_places_a_person_names_the_operation() {
    let text = include_str!("../../../../examples/rotary-table.toml");
    let bolt = |name: &str, (from, to), (on, off), (at, back)| {
        format!(
            "[[station.operation]]\nname = \"{name}\"\nmodule = \"R\"\nmoves = {{ axis = \"bolt\", from = {from}, to = {to} }}\n\
             duration_s = 0.2\nwatchdog_s = 1.0\nnormal = {{ actuator = \"{on}\", complete = \"{at}\" }}\n\
             recovery = {{ actuator = \"{off}\", complete = \"{back}\" }}\n\
             hand = {{ type = 6, forward = \"PB_index\", back = \"PB_back\", next = \"PB_index\" }}\n\n"
        )
    };
    let unlock = bolt("unlock", (0, 10), ("pull", "push"), ("LS_free", "LS_locked"));
    let lock = bolt("lock", (10, 0), ("push", "pull"), ("LS_locked", "LS_free"));
    let text = text
        .replace("home = \"index\"\naxes = { table = 0.0 }", "home = \"lock\"\naxes = { table = 0.0, bolt = 0 }")
        .replace("[[station.operation]]\nname = \"index\"", &format!("{unlock}[[station.operation]]\nname = \"index\""))
        .replace("[[station]]\nname = \"load\"", &format!("{lock}[[station]]\nname = \"load\""))
        .replace("\"LS_in_place\", \"overload\"", "\"LS_in_place\", \"LS_free\", \"LS_locked\", \"overload\"")
        .replace("\"turn\", \"lamp_table\"", "\"turn\", \"pull\", \"push\", \"lamp_table\"")
        .replace("from = \"table: index\"", "from = \"table: lock\"")
        .replace("to = \"table: index\"", "to = \"table: unlock\"")
        .replace("from = \"index\", until = \"index\"", "from = \"unlock\", until = \"lock\"");
    let line = parse("bolt.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    let told = line.clearance(&line.conflicts[0].a).expect("the bolt tells").on;
    assert_eq!(told, 0b101, "in place and locked");
    const FREE: u128 = 2;
    const LOCKED: u128 = 4;
    let mut rig = Rig::alone(line.clone(), StationId(0), Restore::Fresh, IN_PLACE | LOCKED);
    rig.mode(ControlMode::Auto);
    rig.set(LOCKED, false);
    rig.set(FREE, true);
    assert_eq!((rig.outputs, rig.doing().as_str()), (TURN, "index"));
    let kept = rig.controller.snapshot();
    for (named, stands) in [("unlock", "unlock (done)"), ("index", "index (done)")] {
        let mut rig = Rig::alone(line.clone(), StationId(0), Restore::From(kept.clone()), IN_PLACE | FREE);
        rig.refresh();
        assert!(rig.controller.position_lost().is_some());
        assert_eq!(rig.rejoin(None), Handled::Ignored(Ignored::PositionUnclear), "it may be either");
        let asks = rig.blocked_by().join("; ");
        assert!(asks.contains("possible: `unlock`, `index`"), "{asks}");
        assert!(rig.rejoin(line.stations[0].operation_named(named)).is_taken());
        assert_eq!((rig.controller.position_lost(), rig.doing().as_str()), (None, stands));
    }
}
