//! Sources and epochs of orders. Two coordinators at once: nothing moves while both are received, and the station reports
//! why.

use std::time::Duration;

use linewright_line::net::ControlMode::{Auto, EStop, Manual, StandBy};
use linewright_station_shell::StationEffect;

use crate::rig::{FOLLOWED, OTHER, Rig};

impl Rig {
    /// For this many periods both give orders, the other one with numbers of its own, and the panel's button stays down.
    fn both(&mut self, periods: u64) {
        for round in 1..=periods {
            self.now = self.now + self.timing().refresh;
            self.refresh(5, Manual);
            let sequence = 700 + round + self.now.as_micros() / 1000;
            self.order_numbered(sequence, OTHER, 5, Manual);
            self.inputs(false);
            self.act();
        }
    }

    /// For this long the followed one alone gives orders.
    fn alone(&mut self, periods: u64) {
        for _ in 0..periods {
            self.now = self.now + self.timing().refresh;
            self.refresh(5, Manual);
            self.inputs(false);
            self.act();
        }
    }

    fn reasons(&self) -> String {
        self.shell.controller().blocked_by(&self.line, self.now).join("; ")
    }
}

#[test]
fn while_two_coordinators_give_orders_nothing_moves_and_both_are_named() {
    let mut rig = Rig::new();
    rig.close();
    rig.both(4);
    assert_eq!(rig.mode(), StandBy);
    assert!(rig.kinds().contains(&"off"), "{:?}", rig.kinds());
    assert!(rig.shell.controller().marking().any(|place| place.is_incomplete()), "the motion was stopped");
    let expected = format!("one coordinator: two are active (boot ids {FOLLOWED} and {OTHER}); stop one of them");
    assert!(rig.reasons().contains(&expected), "{}", rig.reasons());
    rig.effects.clear();
    rig.both(20);
    assert!(!rig.kinds().contains(&"on"), "{:?}", rig.kinds());

    // It ends by itself, and the button that stayed down starts nothing.
    rig.alone(rig.timing().stale.as_millis() as u64 / rig.timing().refresh.as_millis() as u64 + 1);
    assert_eq!(rig.mode(), Manual);
    assert!(!rig.reasons().contains("two are active"), "{}", rig.reasons());
    assert!(!rig.kinds().contains(&"on"), "{:?}", rig.kinds());
}

#[test]
fn one_late_order_of_a_dead_coordinator_and_its_copies_stop_nothing() {
    let mut rig = Rig::new();
    rig.close();
    for _ in 0..4 {
        rig.order_numbered(900, OTHER, 5, Auto);
        rig.alone(1);
    }
    assert_eq!(rig.mode(), Manual);
    assert!(!rig.kinds().contains(&"off"), "{:?}", rig.kinds());
}

#[test]
fn the_emergency_stop_of_either_is_obeyed_while_both_give_orders() {
    for life in [FOLLOWED, OTHER] {
        let mut rig = Rig::new();
        rig.close();
        rig.both(4);
        rig.order_numbered(5000, life, 1, EStop);
        rig.act();
        assert_eq!(rig.mode(), EStop, "of life {life}");
    }
}

/// The followed one is killed, and its successor sends at once.
#[test]
fn a_successor_is_no_second_coordinator() {
    let mut rig = Rig::new();
    let periods = rig.timing().stale.as_millis() / rig.timing().refresh.as_millis() + 2;
    for _ in 0..periods {
        rig.now = rig.now + rig.timing().refresh;
        rig.order(OTHER, 6, Manual);
        rig.act();
        assert!(!rig.reasons().contains("two are active"), "{}", rig.reasons());
    }
    assert_eq!(rig.shell.controller().mode_epoch(), 6);
    rig.pass(Duration::from_millis(1));
    assert_eq!(rig.mode(), Manual);
}

#[test]
fn an_epoch_far_ahead_is_refused_by_who_follows_one_and_taken_by_who_is_restarted() {
    let far = (1 << 33) + 7;
    let mut rig = Rig::new();
    rig.order(FOLLOWED, far, Manual);
    rig.act();
    assert_eq!(rig.shell.controller().mode_epoch(), 5);
    assert!(rig.effects.iter().any(|effect| matches!(effect, StationEffect::Ignored { .. })));
    // What a coordinator was made to write down is no dead end.
    rig.restart();
    rig.order(FOLLOWED, far, Manual);
    rig.act();
    assert_eq!((rig.shell.controller().mode_epoch(), rig.mode()), (far, Manual));
}
