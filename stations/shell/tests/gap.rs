//! The process stood still: stopped by a signal, or with its machine.

use std::time::Duration;

use linewright_line::net::ControlMode::{Manual, StandBy};

use crate::rig::Rig;

/// Messages that waited for it meanwhile prove nothing about the present, however new they look.
#[test]
fn what_was_heard_before_a_gap_and_what_waited_in_it_is_unknown() {
    let mut rig = Rig::new();
    rig.close();
    // A lease that would outlive the gap.
    let gap = rig.timing().stale + rig.timing().refresh * 2;
    assert!(gap < rig.timing().lease);
    rig.stand_still(gap);
    rig.refresh(5, Manual);
    rig.inputs(false);
    rig.act();
    assert_eq!(rig.mode(), StandBy, "the lease has ended");
    assert!(!rig.shell.controller().report().devices_valid, "nobody vouches for the image");
    assert!(rig.kinds().contains(&"off") && !rig.kinds().contains(&"on"), "{:?}", rig.kinds());
    let incomplete = rig.shell.controller().marking().any(|place| place.is_incomplete());
    assert!(incomplete, "the motion was stopped");

    // One period later all that live have been received anew.
    rig.pass(rig.timing().refresh);
    rig.refresh(5, Manual);
    rig.inputs(false);
    rig.act();
    assert_eq!(rig.mode(), Manual);
    assert!(rig.shell.controller().report().devices_valid);
}

#[test]
fn a_loop_that_is_late_by_less_than_a_message_lasts_goes_on() {
    let mut rig = Rig::new();
    rig.close();
    rig.stand_still(rig.timing().stale - Duration::from_millis(1));
    rig.refresh(5, Manual);
    rig.inputs(false);
    rig.act();
    assert_eq!(rig.mode(), Manual);
    assert!(!rig.kinds().contains(&"off"), "{:?}", rig.kinds());
}

#[test]
fn a_button_that_was_held_before_a_gap_was_released_in_it() {
    let mut rig = Rig::new();
    rig.close();
    rig.stand_still(Duration::from_secs(10));
    for _ in 0..20 {
        rig.refresh(5, Manual);
        rig.inputs(false);
        rig.act();
        assert!(!rig.kinds().contains(&"on"), "{:?}", rig.kinds());
        rig.pass(rig.timing().refresh);
    }
    rig.advance(false);
    rig.act();
    rig.refresh(5, Manual);
    rig.act();
    assert!(rig.kinds().contains(&"on"), "pressed again: {:?}", rig.kinds());
}
