//! The emergency stop at a station: from any coordinator, and the one way out of it.

use std::time::Duration;

use linewright_line::net::ControlMode::{Auto, EStop, Manual, StandBy};

use crate::rig::{FOLLOWED, OTHER, Rig};

/// From the present order, a message that is no newer one, and one of another coordinator: whatever numbers it carries.
#[test]
fn it_is_obeyed_from_any_life_sequence_and_epoch() {
    for (life, sequence, epoch) in [(FOLLOWED, 1, 5), (FOLLOWED, 900, 1), (OTHER, 1, 1), (OTHER, 1, 90), (0, 0, 0)] {
        let mut rig = Rig::new();
        rig.close();
        rig.order_numbered(sequence, life, epoch, EStop);
        rig.act();
        assert_eq!(rig.mode(), EStop, "life {life} sequence {sequence} epoch {epoch}");
        assert_eq!(rig.kinds().first(), Some(&"off"));
    }
}

#[test]
fn it_ends_by_a_later_epoch_of_the_coordinator_that_ordered_it() {
    let mut rig = Rig::new();
    rig.order(FOLLOWED, 6, EStop);
    rig.act();
    rig.order(FOLLOWED, 6, Manual);
    rig.act();
    assert_eq!(rig.mode(), EStop, "the same epoch ends nothing");
    rig.pass(Duration::from_secs(5));
    rig.act();
    assert_eq!(rig.mode(), EStop, "nor does the end of its lease");
    rig.order(FOLLOWED, 7, Manual);
    rig.act();
    assert_eq!(rig.mode(), Manual);
}

#[test]
fn a_stop_of_another_coordinator_ends_only_after_the_one_that_is_followed_has_ordered_it_too() {
    let mut rig = Rig::new();
    rig.order_numbered(1, OTHER, 1, EStop);
    rig.act();
    for epoch in [6, 7] {
        rig.pass(Duration::from_secs(1));
        rig.order(FOLLOWED, epoch, StandBy);
        rig.act();
        assert_eq!(rig.mode(), EStop, "a change of mode by who has not heard of the stop");
    }
    rig.order(FOLLOWED, 8, EStop);
    rig.act();
    rig.order(FOLLOWED, 9, Manual);
    rig.act();
    assert_eq!(rig.mode(), Manual);
}

#[test]
fn it_stays_in_force_while_another_coordinator_gives_it() {
    let mut rig = Rig::new();
    rig.order(FOLLOWED, 6, EStop);
    for round in 0..20 {
        rig.order_numbered(round, OTHER, 1, EStop);
        rig.order(FOLLOWED, 7, Manual);
        rig.act();
        assert_eq!(rig.mode(), EStop);
        rig.pass(rig.timing().refresh);
    }
    rig.pass(rig.timing().stale);
    rig.order(FOLLOWED, 7, Manual);
    rig.act();
    assert_eq!(rig.mode(), Manual);
}

/// A successor that has never received the stop has higher epochs by chance, or because its journal is of another time.
#[test]
fn a_successor_that_does_not_know_of_it_ends_nothing() {
    let mut rig = Rig::new();
    rig.order(FOLLOWED, 6, EStop);
    rig.pass(Duration::from_secs(1));
    for epoch in [40, 41] {
        rig.order(OTHER, epoch, Auto);
        rig.act();
        assert_eq!(rig.mode(), EStop);
        assert_eq!(rig.shell.controller().report().mode_epoch, epoch, "it is followed all the same");
    }
    rig.order(OTHER, 42, EStop);
    rig.order(OTHER, 43, Manual);
    rig.act();
    assert_eq!(rig.mode(), Manual);
}

#[test]
fn everything_is_off_at_the_end_whatever_the_reason() {
    let mut rig = Rig::new();
    rig.close();
    let off = rig.shell.off();
    assert_eq!(off.bits, 0);
    rig.act();
    assert!(rig.driven().is_none_or(|image| image.sequence > off.sequence && image.number != off.number));
}

/// It gives the stop while its predecessor is still followed, then it is followed and ends it.
#[test]
fn a_successor_that_gave_it_before_it_was_followed_ends_it() {
    let mut rig = Rig::new();
    rig.order(FOLLOWED, 6, EStop);
    rig.act();
    let mut sequence = 0;
    while rig.shell.controller().report().mode_epoch != 7 {
        sequence += 1;
        assert!(sequence < 100, "its predecessor is silent");
        rig.pass(rig.timing().refresh);
        rig.order_numbered(sequence, OTHER, 7, EStop);
        rig.act();
    }
    rig.order_numbered(sequence + 1, OTHER, 8, Manual);
    rig.act();
    assert_eq!(rig.mode(), Manual);
}
