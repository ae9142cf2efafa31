//! Process data that wait for SYNC, manager and device together: they come and act with it, and when the device
//! receives none its outputs go off although every heartbeat still comes.

use std::time::Duration;

use linewright_canopen::BusEvent;
use linewright_line::{Tick, Timing, Transmission};

use crate::managed::Managed;
use linewright_testkit::presses::{FORWARD, line};

/// The first device alone, operational, with inputs on every second SYNC and outputs on each. `watches`: whether the
/// device itself has the SYNC period.
fn up(watches: bool) -> Managed {
    let mut line = line();
    line.devices.truncate(1);
    line.timing = Timing { sync: Some(Duration::from_millis(10)), ..Timing::default() };
    let setup = &mut line.devices[0].canopen_mut().expect("CANopen").setup;
    setup.transmission = Transmission { inputs: Some(2), outputs: Some(1) };
    let mut bus = Managed::up(&line);
    if !watches {
        bus.send("604#2306100000000000");
    }
    bus
}

/// SYNC alone does not get through to the device.
fn lose_sync(bus: &mut Managed) {
    bus.passes = |frame| frame.cob_id() != Some(0x80);
}

fn gaps(moments: &[Tick]) -> Vec<u64> {
    moments.windows(2).map(|pair| pair[1].since(pair[0]).as_millis() as u64).collect()
}

#[test]
fn inputs_come_and_outputs_act_with_sync() {
    let mut bus = up(true);
    bus.wire.clear();
    bus.run(200);
    let syncs = bus.sent("080#");
    assert_eq!((syncs.len(), gaps(&syncs)), (20, vec![10; 19]));
    assert_eq!(gaps(&bus.sent("184#")), vec![20; 9]);
    // Just after a SYNC: what is set now acts with the next.
    while bus.sent("080#").last() != Some(&bus.now) {
        bus.run(1);
    }
    bus.run(1);
    bus.set(FORWARD);
    assert_eq!(bus.outputs(), 0);
    bus.run(8);
    assert_eq!(bus.outputs(), 0);
    bus.run(1);
    assert_eq!(bus.outputs(), 1);
}

#[test]
fn a_device_that_knows_how_often_sync_comes_lets_go_when_it_stops() {
    let mut bus = up(true);
    bus.set(FORWARD);
    bus.run(20);
    assert_eq!(bus.outputs(), 1);
    lose_sync(&mut bus);
    bus.run(31);
    assert_eq!(bus.outputs(), 0);
    bus.run(50);
    assert!(!bus.is_valid(), "its heartbeat says what it did");
}

#[test]
fn a_device_that_does_not_is_stopped_by_the_manager_and_comes_back_when_sync_does() {
    let mut bus = up(false);
    bus.set(FORWARD);
    bus.run(20);
    lose_sync(&mut bus);
    bus.events.clear();
    bus.run(150);
    assert_eq!(bus.outputs(), 1, "nothing else would make it let go");
    bus.run(80);
    assert_eq!(bus.outputs(), 0);
    let said: Vec<String> = bus.events.iter().map(BusEvent::to_string).collect();
    assert!(said.contains(&"node 04h hears no SYNC: its inputs have not come for 200 ms".to_owned()), "{said:?}");
    let trouble = bus.trouble();
    assert!(trouble[0].starts_with("press1-io (node 04h): it hears no SYNC (080h)"), "{trouble:?}");
    // As long as that lasts nothing it is sent energises it.
    for _ in 0..200 {
        bus.set(FORWARD);
        bus.run(10);
        assert_eq!(bus.outputs(), 0);
        assert!(!bus.is_valid() || bus.outputs() == 0);
    }
    // By now it has lost SYNC three times in a row, and is looked at every five seconds.
    bus.passes = |_| true;
    bus.run(6000);
    assert!(bus.is_valid(), "{:?}", bus.trouble());
    bus.set(FORWARD);
    bus.run(20);
    assert_eq!(bus.outputs(), 1);
}

#[test]
fn frames_are_those_of_the_standard() {
    let bus = up(true);
    assert!(!bus.sent("080#").is_empty());
    let written: Vec<&str> =
        bus.wire.iter().map(|(_, text)| text.as_str()).filter(|text| text.starts_with("604#2")).collect();
    // 1006h in microseconds, then the two transmission types.
    assert_eq!(written[..3], ["604#2306100010270000", "604#2F00140201000000", "604#2F00180202000000"]);
}

#[test]
fn a_device_that_loses_sync_again_and_again_is_left_stopped_and_tried_now_and_then() {
    let mut bus = up(false);
    bus.set(FORWARD);
    bus.run(20);
    lose_sync(&mut bus);
    (bus.events, bus.wire) = (Vec::new(), Vec::new());
    bus.run(20_000);
    let lost = bus.events.iter().filter(|event| matches!(event, BusEvent::NoSync { .. })).count();
    assert!((5..=7).contains(&lost), "three times, and then every five seconds: {lost}");
    let stops = bus.sent("000#0204").len();
    assert!((lost..=lost + 2).contains(&stops), "one order each: {stops}");
    let refused = bus.events.iter().filter(|event| matches!(event, BusEvent::BootFailed { .. })).count();
    assert_eq!(refused, 1, "said once");
    // In between it is at rest, with the reason. The repair needs no further action.
    while bus.events.last().is_none_or(|event| !matches!(event, BusEvent::NoSync { .. })) {
        bus.events.clear();
        bus.run(1);
    }
    bus.run(300);
    assert_eq!(bus.outputs(), 0);
    let trouble = bus.trouble();
    assert!(trouble[0].contains("not started: it has lost SYNC (080h)"), "{trouble:?}");
    bus.passes = |_| true;
    bus.run(8000);
    assert!(bus.is_valid());
    // After a while it may lose it three times again.
    lose_sync(&mut bus);
    bus.events.clear();
    bus.run(1000);
    assert!(!bus.events.iter().any(|event| matches!(event, BusEvent::BootFailed { .. })), "{:?}", bus.events);
}
