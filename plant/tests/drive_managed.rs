//! A manager and a line with a drive on one bus, in virtual time: boot, homing, motion, letting go, losses.

use std::time::Duration;

use linewright_canopen::{BusEvent, BusOutbox, Frame, Manager, NodeId};
use linewright_line::{AxisId, DeviceBus, Owner, StationId, Tick, parse};
use linewright_plant::{DeviceFault, PlantOptions, Rack};

const LINE: &str = include_str!("../../model/line/tests/descriptions/drives.toml");
const SLIDE: Owner = Owner::Station(StationId(0));
/// Bits of the image, in the order of the description.
const TO_0: u128 = 1 << 2;
const TO_80: u128 = 1 << 3;
const TO_100: u128 = 1 << 5;
const AT_0: u128 = 1 << 5;
const AT_80: u128 = 1 << 6;
const AT_100: u128 = 1 << 7;
const FAULT: u128 = 1 << 8;

/// More than anybody has to do at one moment.
const AT_ONCE_MAX: u32 = 50;

struct World {
    manager: Manager,
    rack: Rack,
    now: Tick,
    /// A manager that is not alive neither hears nor sends.
    alive: bool,
    events: Vec<BusEvent>,
    /// How often somebody had something to do without time passing.
    at_once: u32,
}

impl World {
    fn new() -> Self {
        let line = parse("drives.toml", LINE).unwrap_or_else(|problems| panic!("{problems:#}")).line;
        let now = Tick::from_millis(1000);
        let manager = Manager::new(&line.devices, line.timing).expect("two devices");
        let rack = Rack::new(now, &line, &DeviceBus::Line, PlantOptions::default());
        World { manager, rack, now, alive: true, events: Vec::new(), at_once: 0 }
    }

    /// The world once everything is operational and the drive has been homed, standing at 0 without an order.
    fn ready() -> Self {
        let mut world = World::new();
        world.until("both are up", |world| world.manager.inputs(world.now, SLIDE).valid);
        world.set(TO_0);
        world.until("homed, and at 0", |world| world.bits() & AT_0 != 0);
        world.set(0);
        world.pass(200);
        world.events.clear();
        world
    }

    fn set(&mut self, image: u128) {
        let mut out = BusOutbox::default();
        self.manager.set_outputs(self.now, SLIDE, image, &mut out);
        self.carry(out);
    }

    /// Frames of the manager reach the devices, and theirs the manager, until all is quiet.
    fn carry(&mut self, out: BusOutbox) {
        self.events.extend(out.events);
        let mut down = out.frames;
        for _ in 0..100 {
            let mut up: Vec<Frame> = Vec::new();
            for frame in down.drain(..) {
                self.rack.handle(self.now, &frame, &mut up);
            }
            let mut answer = BusOutbox::default();
            for frame in up.iter().filter(|_| self.alive) {
                self.manager.handle(self.now, frame, &mut answer);
            }
            self.events.append(&mut answer.events);
            down = answer.frames;
            if down.is_empty() {
                return;
            }
        }
        panic!("they never stop talking");
    }

    fn step(&mut self) {
        let due = [self.rack.next_deadline(), self.manager.next_deadline().filter(|_| self.alive)];
        let due = due.into_iter().flatten().min().unwrap_or(self.now + Duration::from_millis(1));
        let before = self.now;
        self.now = self.now.max(due.min(self.now + Duration::from_millis(5)));
        self.at_once = if self.now == before { self.at_once + 1 } else { 0 };
        assert!(self.at_once < AT_ONCE_MAX, "a deadline stays in the past: {due:?} at {before:?}");
        let mut up = Vec::new();
        self.rack.poll(self.now, &mut up);
        let mut out = BusOutbox::default();
        if self.alive {
            for frame in &up {
                self.manager.handle(self.now, frame, &mut out);
            }
            self.manager.poll(self.now, &mut out);
        }
        self.carry(out);
    }

    fn pass(&mut self, millis: u64) {
        let until = self.now + Duration::from_millis(millis);
        while self.now < until {
            self.step();
        }
    }

    fn until(&mut self, what: &str, holds: impl Fn(&World) -> bool) {
        let patience = self.now + Duration::from_secs(30);
        while !holds(self) {
            let is = self.manager.explain(self.now, drive());
            assert!(self.now < patience, "waited in vain: {what}; at {}, {is:?}, {:?}", self.place(), self.events);
            self.step();
        }
    }

    fn bits(&self) -> u128 {
        let inputs = self.manager.inputs(self.now, SLIDE);
        if inputs.valid { inputs.bits } else { 0 }
    }

    fn place(&self) -> f64 {
        self.rack.plant().position(StationId(0), AxisId(0))
    }

    /// How far it moves within a while.
    fn moves_within(&mut self, millis: u64) -> f64 {
        let before = self.place();
        self.pass(millis);
        (self.place() - before).abs()
    }
}

fn drive() -> NodeId {
    NodeId::new(3).expect("3 is a node id")
}

#[test]
fn it_is_booted_homed_and_goes_where_its_outputs_say() {
    let mut world = World::ready();
    // Homing has found the zero, 1.5 mm from where the switch is.
    let zero = world.place();
    world.set(TO_80);
    world.until("at 80", |world| world.bits() & AT_80 != 0);
    assert!((world.place() - zero - 80.0).abs() <= 0.05, "{}", world.place());
    world.set(0);
    world.pass(100);
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
fn it_moves_only_while_its_output_is_on() {
    let mut world = World::ready();
    for millis in [20, 60, 110, 200] {
        world.set(TO_80);
        world.pass(millis);
        world.set(0);
        // The quick stop ramp from 250 mm/s at 5000 mm/s² takes 50 ms.
        world.pass(100);
        assert_eq!(world.moves_within(500), 0.0, "after {millis} ms");
    }
    assert!(world.place() > 1.0 && world.place() < 80.0, "it was under way: {}", world.place());
    world.set(TO_80);
    world.until("it goes on when it is told to", |world| world.bits() & AT_80 != 0);
}

#[test]
fn two_orders_at_once_are_none_and_a_fault() {
    let mut world = World::ready();
    world.set(TO_80 | TO_100);
    world.pass(50);
    assert_eq!(world.moves_within(500), 0.0);
    assert!(world.bits() & FAULT != 0);
    world.set(0);
    world.pass(50);
    world.set(TO_80);
    world.until("at 80", |world| world.bits() & AT_80 != 0);
}

#[test]
fn without_its_manager_it_stops_by_itself() {
    let mut world = World::ready();
    world.set(TO_80);
    world.pass(60);
    assert!(world.moves_within(20) > 0.0);
    world.alive = false;
    // The heartbeat timeout of 200 ms is shorter than the way, and the ramp takes 50 ms.
    world.pass(300);
    assert_eq!(world.moves_within(500), 0.0);
    assert!(world.place() < 80.0, "{}", world.place());
}

#[test]
fn a_drive_that_boots_on_the_way_is_lost_and_moves_again_only_after_it_was_homed() {
    let mut world = World::ready();
    world.set(TO_80);
    world.pass(60);
    let now = world.now;
    let before = world.manager.inputs(now, SLIDE).losses;
    world.rack.drive_mut(drive()).expect("it is a drive").inject(now, Some(DeviceFault::Reboot));
    world.until("the loss is seen", |world| world.manager.inputs(world.now, SLIDE).losses > before);
    world.until("it is brought up again", |world| world.manager.inputs(world.now, SLIDE).valid);
    assert!(world.events.contains(&BusEvent::DeviceRebooted { node: drive() }), "{:?}", world.events);
    // It brakes while it boots.
    world.pass(100);
    assert_eq!(world.moves_within(500), 0.0, "the order from before the loss is forgotten");
    assert_eq!(world.bits() & (AT_0 | AT_80 | AT_100), 0, "nobody knows where it is");
    world.set(TO_80);
    world.pass(100);
    assert_eq!(world.moves_within(300), 0.0, "it is not homed");
    assert!(world.bits() & FAULT != 0);
    world.set(0);
    world.pass(100);
    world.set(TO_0);
    world.until("homed again", |world| world.bits() & AT_0 != 0);
}

#[test]
fn a_lost_neighbour_stops_it() {
    let mut world = World::ready();
    world.set(TO_80);
    world.pass(60);
    let now = world.now;
    let io = NodeId::new(2).expect("2 is a node id");
    world.rack.device_mut(io).expect("the valves' device").inject(now, Some(DeviceFault::Silent));
    world.until("the loss is seen", |world| !world.manager.inputs(world.now, SLIDE).valid);
    world.pass(100);
    assert_eq!(world.moves_within(500), 0.0);
}
