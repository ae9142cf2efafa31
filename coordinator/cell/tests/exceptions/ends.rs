//! Sensors at the end of an activity.

use linewright_coordinator_cell::exception::OutOfServiceReason;
use linewright_coordinator_cell::{PlayerInput, Presence};

use super::bench::CellBench;

const LOADED: &str = "M1.loaded<A.new>";

/// C1 with a part that has just been loaded in M1, where nothing sees it.
fn loaded_unseen() -> CellBench {
    let mut bench = CellBench::c1(&[1, 0]);
    bench.sim.senses = false;
    for name in ["robot", "m1", "m2", "m3"] {
        bench.at(name).presence = Presence::Off;
    }
    bench.until_that(|bench| bench.count(LOADED) > 0 || !bench.down().is_empty());
    bench
}

/// A part that has dropped on its way is not worked on, and counts as nothing that was made.
#[test]
fn a_part_that_is_not_seen_when_it_was_loaded_raises_an_alarm_before_it_is_worked_on() {
    let mut bench = loaded_unseen();
    assert_eq!((bench.count(LOADED), bench.down()), (1, Vec::new()), "the sensor may follow");
    bench.seconds_later(2.0);
    assert_eq!(bench.down(), [("M1".to_owned(), OutOfServiceReason::Mismatch)]);
    assert!(bench.alarm().text.starts_with("M1: part expected, sensor off. "), "{}", bench.alarm().text);
    assert!(bench.firing("M1.process<A.new>").is_none());
    bench.answer("gone");
    assert_eq!((bench.count(LOADED), bench.state().left()), (0, 0));
}

/// A sensor that is on a little later holds the work up for that time alone.
#[test]
fn a_sensor_that_follows_an_activity_is_waited_for() {
    let mut bench = loaded_unseen();
    bench.at("m1").presence = Presence::On;
    bench.until_that(|bench| bench.count(LOADED) == 0);
    assert_eq!(bench.down(), []);
    bench.seconds_later(1.0);
    assert!(bench.firing("M1.process<A.new>").is_some());
}

/// With the devices of the machine away when its loading ends, it is compared when they are back.
#[test]
fn a_sensor_that_is_not_read_when_an_activity_ends_is_compared_when_it_is() {
    for (then, down) in
        [(Presence::Off, vec![("M1".to_owned(), OutOfServiceReason::Mismatch)]), (Presence::On, Vec::new())]
    {
        let mut bench = CellBench::c1(&[1, 0]);
        bench.until_that(|bench| bench.firing("load M1<A.new>").is_some());
        bench.sim.senses = false;
        for (name, presence) in [("robot", Presence::Off), ("m1", Presence::Unread)] {
            bench.at(name).presence = presence;
        }
        bench.until_that(|bench| bench.firing("load M1<A.new>").is_none());
        bench.hear();
        assert_eq!((bench.count(LOADED), bench.down()), (1, Vec::new()), "nothing is begun");
        bench.at("m1").presence = then;
        bench.hear();
        assert_eq!((bench.down(), bench.count(LOADED)), (down, u64::from(then == Presence::Off)));
    }
}

/// A gripper that has not let go of its part is not sent for another one.
#[test]
fn a_part_that_is_still_seen_in_the_hand_raises_an_alarm() {
    let mut bench = CellBench::c1(&[1, 0]);
    bench.until_that(|bench| bench.firing("load M1<A.new>").is_some());
    bench.sim.senses = false;
    (bench.at("m1").presence, bench.at("robot").presence) = (Presence::On, Presence::On);
    bench.until_that(|bench| bench.firing("load M1<A.new>").is_none());
    bench.seconds_later(2.0);
    assert_eq!(bench.down(), [("R".to_owned(), OutOfServiceReason::Mismatch)]);
    bench.at("robot").presence = Presence::Off;
    bench.seconds_later(1.0);
    let up = PlayerInput::Resource { resource: bench.resource("R"), up: true };
    bench.say(up);
    assert_eq!(bench.down(), []);
}
