//! Injected faults of a simulated device on the bus, commanded as over CAN: each begins, shows, and is cleared.

use linewright_canopen::NodeId;
use linewright_line::{Owner, Tick};
use linewright_plant::{CLEAR, DeviceFault, FrameFaults, MotionFault, ObjectWrites};

use crate::managed::Managed;
use linewright_testkit::presses::line;

/// Press 1 (node 4) and the console (node 10) are up.
fn up() -> Managed {
    let mut bus = Managed::up(&line());
    bus.run(600);
    bus.wire.clear();
    bus
}

/// Index, subindex and number written to node 4.
type Writes = &'static [(u16, u8, u32)];

struct Row {
    writes: Writes,
    /// Time that follows, in ms.
    millis: u64,
    /// The manager's description of the fault then, in parts.
    trouble: &'static [&'static str],
    /// A frame that comes meanwhile, and beginnings of those that do not.
    heard: &'static str,
    unheard: &'static [&'static str],
}

const FAULT: u16 = 0x5F00;
const TROUBLE: u16 = 0x5F02;
const REBOOT: (u16, u8, u32) = (FAULT, 0, 2);
const READING: u32 = 1 << 24;
const WRITING: u32 = 1 << 25;
/// The manager's first request to a device that it probes.
const ASKED: &str = "604#40001000";

const ROWS: &[Row] = &[
    // It boots, and does not come up.
    Row {
        writes: &[(FAULT, 0, 3)],
        millis: 5000,
        trouble: &["press1-io (node 04h): no heartbeat (1017h) for"],
        heard: ASKED,
        unheard: &["084#", "184#", "584#", "704#"],
    },
    // Its heartbeats cease, process data go on.
    Row {
        writes: &[(FAULT, 0, 4)],
        millis: 3000,
        trouble: &["no heartbeat (1017h) for"],
        heard: "184#",
        unheard: &["704#"],
    },
    // It reports an error.
    Row {
        writes: &[(TROUBLE, 1, 0x05_2310)],
        millis: 10,
        trouble: &["emergency 2310h (current at outputs too high, overload), error register 1001h = 05h"],
        heard: "084#1023050000000000",
        unheard: &[],
    },
    // The error stands also after a boot.
    Row {
        writes: &[(TROUBLE, 1, 0x05_2310), REBOOT],
        millis: 1000,
        trouble: &["its error register 1001h = 05h (generic, voltage)"],
        heard: "704#00",
        unheard: &[],
    },
    // It is off the bus.
    Row {
        writes: &[(TROUBLE, 2, 4000)],
        millis: 300,
        trouble: &["no heartbeat (1017h) for 3"],
        heard: "77F#05",
        unheard: &["704#"],
    },
    // It refuses an object that is written.
    Row {
        writes: &[(TROUBLE, 5, 0x0606_0000), (TROUBLE, 6, WRITING | 0x10_1700), REBOOT],
        millis: 500,
        trouble: &["not started: it cannot be configured: object 1017h:00: refused: 06060000h"],
        heard: "704#7F",
        unheard: &["704#05"],
    },
    // It refuses an object that is read.
    Row {
        writes: &[(TROUBLE, 5, 0x0606_0000), (TROUBLE, 6, READING | 0x10_0000), REBOOT],
        millis: 500,
        trouble: &["not started: it cannot be identified: object 1000h:00: refused: 06060000h"],
        heard: "704#7F",
        unheard: &["704#05"],
    },
    // It has no error values: no such object, read or written.
    Row {
        writes: &[(TROUBLE, 5, 0x0602_0000), (TROUBLE, 6, READING | WRITING | 0x62_0601), REBOOT],
        millis: 500,
        trouble: &[
            "not started: it cannot be configured: object 6206h:01: refused: 06020000h",
            "`without_error_values`",
        ],
        heard: "704#7F",
        unheard: &["704#05"],
    },
    // It takes an error value, and gives back something else.
    Row {
        writes: &[(TROUBLE, 3, 0x01), (TROUBLE, 4, 0x62_0701), REBOOT],
        millis: 500,
        trouble: &["not started: object 6207h:01 ", " is 01h, not 00h as written"],
        heard: "704#7F",
        unheard: &["704#05"],
    },
];

#[test]
fn each_trouble_shows_and_is_cleared() {
    for Row { writes, millis, trouble, heard, unheard } in ROWS {
        let mut bus = up();
        for (index, sub, value) in *writes {
            bus.run(10);
            bus.write(*index, *sub, *value);
        }
        bus.wire.clear();
        bus.run(*millis);
        let said = bus.trouble();
        let [one] = &said[..] else { panic!("{writes:X?}: {said:?}") };
        assert!(trouble.iter().all(|part| one.contains(part)), "{writes:X?}: {one}");
        assert!(!bus.sent(heard).is_empty(), "{writes:X?}: {heard}");
        assert!(unheard.iter().all(|frame| bus.sent(frame).is_empty()), "{writes:X?}: {unheard:?}");
        assert!(!bus.is_valid());
        bus.write(FAULT, 0, 0);
        bus.run(7000);
        assert_eq!(bus.trouble(), Vec::<String>::new(), "{writes:X?} is cleared");
        assert_eq!(bus.manager.trouble(bus.now, Owner::Console).count(), 0, "{writes:X?}: another device");
    }
}

#[test]
fn the_end_of_an_error_and_of_a_time_off_the_bus_is_reported() {
    let mut bus = up();
    bus.write(TROUBLE, 1, 0x05_2310);
    bus.write(TROUBLE, 1, 0);
    bus.run(10);
    assert!(!bus.sent("084#0000000000000000").is_empty());
    assert!(bus.is_valid());
    bus.write(TROUBLE, 2, 60);
    bus.wire.clear();
    bus.run(50);
    assert!(bus.sent("704#").is_empty());
    bus.run(500);
    assert!(!bus.sent("084#4081110000000000").is_empty(), "{:?}", bus.wire);
    assert!(bus.is_valid(), "and it is up again: {:?}", bus.trouble());
}

#[test]
fn outputs_that_were_set_to_stay_are_let_go_when_the_manager_falls_silent() {
    let mut bus = up();
    // It is set from outside so that its outputs stay as they are, or go on, and so is its state; then it is brought up
    // anew.
    for frame in ["604#2F06620100000000", "604#2F076201FF000000", "604#2F29100101000000", "000#8004"] {
        bus.send(frame);
    }
    bus.run(500);
    bus.set(1);
    assert_eq!((bus.trouble(), bus.outputs()), (vec![], 1));
    bus.passes = |_| false;
    bus.run(250);
    assert_eq!(bus.outputs(), 0);
}

#[test]
fn a_bad_line_is_drawn_from_its_seed() {
    let node = NodeId::new(4).expect("a node id");
    let said = |seed: u32| {
        let mut bus = up();
        for (sub, value) in [(10, seed), (7, 100), (8, 200), (9, 100)] {
            bus.write(TROUBLE, sub, value);
        }
        bus.wire.clear();
        bus.run(10_000);
        bus.wire
    };
    let (one, again, other) = (said(1), said(1), said(2));
    assert_eq!(one, again);
    assert_ne!(one, other);
    let mut bus = up();
    bus.rack.disturb(node, FrameFaults { lost_from: 1000, ..FrameFaults::default() });
    bus.run(1000);
    assert!(bus.sent("704#").is_empty());
    bus.rack.inject(bus.now, node, None);
    bus.run(1000);
    assert!(bus.is_valid());
}

#[test]
fn an_output_that_is_stuck_moves_or_does_not_whatever_it_is_sent() {
    let mut bus = up();
    bus.write(0x5F03, 1, 1);
    bus.run(1);
    assert_eq!(bus.outputs(), 1);
    bus.write(0x5F03, 1, 0);
    bus.set(1);
    assert_eq!(bus.outputs(), 0, "stuck off");
    bus.write(0x5F03, 1, 2);
    bus.run(1);
    assert_eq!(bus.outputs(), 1, "it follows again");
}

const PRESS_IO: u8 = 4;

/// What is sent on the bus after this was done to it, and after a boot later on; and the frames once all is cleared.
fn seen(begin: impl Fn(&mut Managed), clear: impl Fn(&mut Managed)) -> (Vec<(Tick, String)>, Vec<String>) {
    let mut bus = up();
    begin(&mut bus);
    bus.wire.clear();
    bus.run(300);
    bus.rack.inject(bus.now, NodeId::new(PRESS_IO).expect("a node id"), Some(DeviceFault::Reboot));
    bus.run(2000);
    let suffering = std::mem::take(&mut bus.wire);
    clear(&mut bus);
    bus.run(7000);
    assert_eq!(bus.trouble(), [""; 0]);
    bus.wire.clear();
    bus.run(1000);
    let mut cleared: Vec<String> = bus.wire.into_iter().map(|(_, frame)| frame).collect();
    cleared.sort_unstable();
    cleared.dedup();
    (suffering, cleared)
}

fn obey(bus: &mut Managed, orders: ObjectWrites) {
    orders.into_iter().for_each(|(object, value)| bus.order(object, value));
}

#[test]
fn what_is_ordered_over_the_bus_is_what_is_injected() {
    let node = NodeId::new(PRESS_IO).expect("a node id");
    let refusal = |object, reading, writing| DeviceFault::Abort { object, code: 0x0606_0000, reading, writing };
    let (well, healthy) = seen(|_| (), |_| ());
    for fault in [
        DeviceFault::Silent,
        DeviceFault::Reboot,
        DeviceFault::NoBoot,
        DeviceFault::NoHeartbeat,
        DeviceFault::Identity { object: (0x1000, 0), value: 0xFFFF_0001 },
        refusal((0x1000, 0), true, false),
        refusal((0x1017, 0), false, true),
        refusal((0x6206, 1), true, true),
        DeviceFault::Emergency { code: 0x2310, register: 0x85 },
        DeviceFault::BusOff { millis: 1000 },
    ] {
        let ordered = seen(|bus| obey(bus, fault.orders()), |bus| obey(bus, vec![CLEAR]));
        let injected =
            seen(|bus| bus.rack.inject(bus.now, node, Some(fault)), |bus| bus.rack.inject(bus.now, node, None));
        assert!(ordered.0 == injected.0 && ordered.0 != well, "{fault:?}");
        assert_eq!([&ordered.1, &injected.1], [&healthy; 2], "{fault:?} is cleared");
    }
    let faults = FrameFaults { lost_to: 1, lost_from: 20, doubled: 300, seed: 4000 };
    let ordered = seen(|bus| obey(bus, faults.orders()), |bus| obey(bus, vec![CLEAR]));
    let injected = seen(|bus| bus.rack.disturb(node, faults), |bus| bus.rack.inject(bus.now, node, None));
    assert!(ordered.0 == injected.0 && ordered.0 != well);
    assert_eq!([&ordered.1, &injected.1], [&healthy; 2]);
    for fault in MotionFault::ALL {
        assert_eq!(MotionFault::from_code(fault.code()), Ok(Some(fault)));
    }
}
