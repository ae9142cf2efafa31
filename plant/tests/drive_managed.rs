//! A manager and a line with a drive on one bus, in virtual time: boot, homing, motion, letting go, losses.

use std::time::Duration;

use linewright_canopen::{BusEvent, NodeId};
use linewright_line::{AxisId, StationId, parse};
use linewright_plant::DeviceFault;

use crate::managed::Managed;

const LINE: &str = include_str!("../../model/line/tests/descriptions/drives.toml");
/// Bits of the image, in the order of the description.
const TO_0: u128 = 1 << 2;
const TO_80: u128 = 1 << 3;
const TO_100: u128 = 1 << 5;
const AT_0: u128 = 1 << 5;
const AT_80: u128 = 1 << 6;
const AT_100: u128 = 1 << 7;
const FAULT: u128 = 1 << 8;

/// The world once everything is operational and the drive has been homed, standing at 0 without an order.
fn ready() -> Managed {
    let mut world = Managed::new(&parse("drives.toml", LINE).unwrap_or_else(|problems| panic!("{problems:#}")).line);
    world.until("both are up", Managed::is_valid);
    world.set(TO_0);
    world.until("homed, and at 0", |world| world.bits() & AT_0 != 0);
    world.set(0);
    world.run(200);
    world.events.clear();
    world
}

fn place(world: &Managed) -> f64 {
    world.rack.plant().position(StationId(0), AxisId(0))
}

/// Distance that it moves within a while.
fn moves_within(world: &mut Managed, millis: u64) -> f64 {
    let before = place(world);
    world.run(millis);
    (place(world) - before).abs()
}

fn drive() -> NodeId {
    NodeId::new(3).expect("3 is a node id")
}

#[test]
fn it_is_booted_homed_and_goes_where_its_outputs_say() {
    let mut world = ready();
    // Homing has found the zero, 1.5 mm from where the switch is.
    let zero = place(&world);
    world.set(TO_80);
    world.until("at 80", |world| world.bits() & AT_80 != 0);
    assert!((place(&world) - zero - 80.0).abs() <= 0.05, "{}", place(&world));
    world.set(0);
    world.run(100);
    assert_eq!(world.bits() & (AT_0 | AT_80 | AT_100 | FAULT), AT_80, "it stays there without an order");
    // This target has a velocity of its own, which is written while the drive runs.
    world.set(TO_100);
    let start = world.now;
    world.until("at 100", |world| world.bits() & AT_100 != 0);
    let took = world.now.since(start);
    assert!(took >= Duration::from_millis(330), "20 mm at 60 mm/s take a third of a second, not {took:?}");
    world.set(TO_0);
    world.until("back", |world| world.bits() & AT_0 != 0);
    let is = world.manager.explain(world.now, drive()).expect("it is known");
    assert!(is.starts_with("operational; "), "{is}");
}

#[test]
fn a_drive_that_boots_on_the_way_is_lost_and_moves_again_only_after_it_was_homed() {
    let mut world = ready();
    world.set(TO_80);
    world.run(60);
    let now = world.now;
    world.rack.inject(now, drive(), Some(DeviceFault::Reboot));
    world.until("the loss is seen", |world| !world.is_valid());
    world.until("it is brought up again", Managed::is_valid);
    assert!(world.events.contains(&BusEvent::DeviceRebooted { node: drive() }), "{:?}", world.events);
    // It brakes while it boots.
    world.run(100);
    assert_eq!(moves_within(&mut world, 500), 0.0, "the order from before the loss is forgotten");
    assert_eq!(world.bits() & (AT_0 | AT_80 | AT_100), 0, "nobody knows where it is");
    world.set(TO_80);
    world.run(100);
    assert_eq!(moves_within(&mut world, 300), 0.0, "it is not homed");
    assert!(world.bits() & FAULT != 0);
    world.set(0);
    world.run(100);
    world.set(TO_0);
    world.until("homed again", |world| world.bits() & AT_0 != 0);
}

#[test]
fn a_lost_neighbour_stops_it() {
    let mut world = ready();
    world.set(TO_80);
    world.run(60);
    let now = world.now;
    let io = NodeId::new(2).expect("2 is a node id");
    world.rack.inject(now, io, Some(DeviceFault::Silent));
    world.until("the loss is seen", |world| !world.is_valid());
    world.run(100);
    assert_eq!(moves_within(&mut world, 500), 0.0);
}
