//! A station that has just been started: which orders it follows.

use linewright_line::net::ControlMode::{EStop, Manual, StandBy};

use crate::rig::{FOLLOWED, LIFE, Rig};

/// An order of before the start, received once more, and one of a coordinator that has received no state of it.
#[test]
fn an_order_that_does_not_name_this_start_is_followed_into_the_emergency_stop_only() {
    for station_life in [LIFE, 0] {
        let mut rig = Rig::new();
        rig.restart();
        rig.order_to(station_life, 900, (FOLLOWED, 5, Manual));
        rig.act();
        let controller = rig.shell.controller();
        assert_eq!((rig.mode(), controller.followed(), controller.mode_epoch()), (StandBy, 0, 0), "{station_life}");
        let is_reported =
            |rig: &Rig| rig.effects.iter().any(|effect| format!("{effect:?}").contains("name this start"));
        assert!(!is_reported(&rig), "{:?}", rig.effects);
        rig.pass(2 * rig.timing().stale);
        rig.order_to(station_life, 901, (FOLLOWED, 5, Manual));
        assert!(is_reported(&rig), "for long: {:?}", rig.effects);
        // Its number does not count either.
        rig.order(FOLLOWED, 5, Manual);
        rig.act();
        assert_eq!(rig.mode(), Manual);
        rig.restart();
        rig.order_to(station_life, 902, (FOLLOWED, 5, EStop));
        rig.act();
        assert_eq!(rig.mode(), EStop, "{station_life}");
        // The stop was reset before an order named this start: a later epoch ends it, and the same does not.
        for (epoch, mode) in [(5, EStop), (6, Manual)] {
            rig.order(FOLLOWED, epoch, Manual);
            rig.act();
            assert_eq!(rig.mode(), mode, "{station_life}");
        }
    }
}
