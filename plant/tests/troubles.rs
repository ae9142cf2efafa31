//! What a simulated device can be made to suffer on the bus, commanded as over CAN: each begins, shows, and is cleared.

use std::time::Duration;

use linewright_canopen::sdo::ObjectId;
use linewright_canopen::{BusOutbox, Frame, Manager, NodeId};
use linewright_line::{DeviceBus, Owner, Tick};
use linewright_plant::{FrameFaults, PlantOptions, Rack};

const STEP: Duration = Duration::from_millis(1);

/// The devices of the coordinator's bus and their manager, a millisecond at a time.
struct Bench {
    rack: Rack,
    manager: Manager,
    now: Tick,
    /// What the devices said.
    heard: Vec<String>,
}

impl Bench {
    /// Press 1 (node 4) and the console (node 10) are up.
    fn up() -> Self {
        let line = crate::common::line();
        let devices = line.devices.iter().filter(|device| device.bus == DeviceBus::Line);
        let mut bench = Bench {
            rack: Rack::new(Tick::ZERO, &line, &DeviceBus::Line, PlantOptions::default()),
            manager: Manager::new(devices, line.timing).expect("devices of a test"),
            now: Tick::ZERO,
            heard: Vec::new(),
        };
        bench.pass(1000);
        assert!(bench.trouble().is_empty(), "{:?}", bench.trouble());
        bench
    }

    fn pass(&mut self, millis: u32) {
        for _ in 0..millis {
            self.now = self.now + STEP;
            let mut out = BusOutbox::default();
            self.manager.poll(self.now, &mut out);
            let mut back = Vec::new();
            self.rack.poll(self.now, &mut back);
            for _ in 0..20 {
                for frame in out.frames.drain(..) {
                    self.rack.handle(self.now, &frame, &mut back);
                }
                for frame in back.drain(..) {
                    self.heard.push(frame.to_string());
                    self.manager.handle(self.now, &frame, &mut out);
                }
            }
        }
    }

    /// Writes an object of node 4, as a technician would, without waiting for the answer.
    fn write(&mut self, index: u16, sub: u8, value: u32) {
        let [low, high] = index.to_le_bytes();
        let [a, b, c, d] = value.to_le_bytes();
        let frame = Frame::data_frame(0x604, &[0x23, low, high, sub, a, b, c, d]).expect("a frame");
        let mut back = Vec::new();
        self.rack.handle(self.now, &frame, &mut back);
        let answers: Vec<String> = back.iter().map(Frame::to_string).collect();
        let object = ObjectId::new(index, sub);
        assert!(answers.iter().any(|answer| answer.starts_with("584#60")), "{object}: {answers:?}");
        self.heard.extend(answers);
    }

    fn trouble(&self) -> Vec<String> {
        self.manager.trouble(self.now, Owner::Station(crate::common::PRESS)).collect()
    }

    #[track_caller]
    fn expect(&self, words: &str) {
        let trouble = self.trouble();
        assert!(matches!(&trouble[..], [said] if said.contains(words)), "{words}: {trouble:?}");
    }

    /// Everything is cleared, and after a while nothing is left of it.
    fn clear(&mut self) {
        self.write(0x5F00, 0, 0);
        self.pass(7000);
        assert_eq!(self.trouble(), Vec::<String>::new());
        let console: Vec<String> = self.manager.trouble(self.now, Owner::Console).collect();
        assert!(console.is_empty(), "{console:?}");
    }

    fn beats(&self) -> usize {
        self.heard.iter().filter(|frame| frame.starts_with("704#")).count()
    }
}

#[test]
fn one_that_does_not_boot() {
    let mut bench = Bench::up();
    bench.write(0x5F00, 0, 3);
    bench.heard.clear();
    bench.pass(5000);
    assert!(!bench.heard.iter().any(|frame| frame[1..3] == *"04" || frame[1..3] == *"84"), "no sound of it");
    bench.expect("press1-io (node 04h): no heartbeat (1017h) for");
    bench.clear();
    assert!(bench.heard.contains(&"704#00".to_owned()), "it has booted");
}

#[test]
fn one_that_sends_no_heartbeats() {
    let mut bench = Bench::up();
    bench.write(0x5F00, 0, 4);
    bench.heard.clear();
    bench.pass(3000);
    assert_eq!(bench.beats(), 0);
    assert!(bench.heard.iter().any(|frame| frame.starts_with("184#")), "process data go on");
    bench.expect("no heartbeat (1017h) for");
    bench.clear();
}

#[test]
fn one_that_is_in_error_also_after_a_boot() {
    let mut bench = Bench::up();
    bench.write(0x5F02, 1, 0x05_2310);
    bench.pass(10);
    assert!(bench.heard.contains(&"084#1023050000000000".to_owned()));
    bench.expect("emergency 2310h (current at outputs too high, overload), error register 1001h = 05h");
    bench.write(0x5F00, 0, 2);
    bench.pass(1000);
    bench.expect("its error register 1001h = 05h (generic, voltage)");
    bench.write(0x5F02, 1, 0);
    bench.pass(10);
    assert!(bench.heard.contains(&"084#0000000000000000".to_owned()));
    assert!(bench.trouble().is_empty());
}

#[test]
fn one_that_was_off_the_bus() {
    let mut bench = Bench::up();
    bench.write(0x5F02, 2, 60);
    bench.heard.clear();
    bench.pass(50);
    assert_eq!(bench.beats(), 0);
    bench.pass(500);
    assert!(bench.heard.contains(&"084#4081110000000000".to_owned()), "{:?}", bench.heard);
    assert!(bench.trouble().is_empty(), "and it is up again: {:?}", bench.trouble());
    bench.write(0x5F02, 2, 4000);
    bench.pass(300);
    bench.expect("no heartbeat (1017h) for 3");
    bench.pass(6000);
    assert!(bench.trouble().is_empty());
}

#[test]
fn one_that_refuses_an_object() {
    let mut bench = Bench::up();
    bench.write(0x5F02, 5, 0x0606_0000);
    bench.write(0x5F02, 6, 2 << 24 | 0x101700);
    bench.write(0x5F00, 0, 2);
    bench.pass(500);
    bench.expect("not started: it cannot be configured: object 1017h:00: refused: 06060000h");
    bench.write(0x5F02, 6, 1 << 24 | 0x100000);
    bench.write(0x5F00, 0, 2);
    bench.pass(500);
    bench.expect("not started: it cannot be identified: object 1000h:00: refused: 06060000h");
    bench.clear();
}

#[test]
fn one_that_has_no_error_values_or_keeps_others_than_it_is_told() {
    let mut bench = Bench::up();
    // There is no such object (06020000h), read or written.
    bench.write(0x5F02, 5, 0x0602_0000);
    bench.write(0x5F02, 6, 3 << 24 | 0x62_0601);
    bench.write(0x5F00, 0, 2);
    bench.pass(500);
    bench.expect("not started: it cannot be configured: object 6206h:01: refused: 06020000h");
    bench.expect("`without_error_values`");
    assert!(!bench.manager.inputs(bench.now, Owner::Station(crate::common::PRESS)).valid);
    bench.clear();
    // It takes what it is told, and gives back something else.
    bench.write(0x5F02, 3, 0x01);
    bench.write(0x5F02, 4, 0x62_0701);
    bench.write(0x5F00, 0, 2);
    bench.pass(500);
    bench.expect("not started: object 6207h:01 ");
    bench.expect(" is 01h, not 00h as written");
    bench.clear();
}

#[test]
fn one_that_would_keep_its_outputs_is_told_to_let_go_and_does_when_the_manager_falls_silent() {
    let mut bench = Bench::up();
    let outputs = |bench: &Bench| bench.rack.plant().outputs(Owner::Station(crate::common::PRESS));
    // Somebody has set it so that its outputs stay as they are, or go on, and where it is; then it is brought up anew.
    for frame in ["604#2F06620100000000", "604#2F076201FF000000", "604#2F29100101000000", "000#8004"] {
        bench.rack.handle(bench.now, &frame.parse().expect("a frame"), &mut Vec::new());
    }
    bench.pass(500);
    assert!(bench.trouble().is_empty(), "{:?}", bench.trouble());
    let mut out = BusOutbox::default();
    bench.manager.set_outputs(bench.now, Owner::Station(crate::common::PRESS), 1, &mut out);
    for frame in &out.frames {
        bench.rack.handle(bench.now, frame, &mut Vec::new());
    }
    assert_eq!(outputs(&bench), 1);
    // The manager says nothing any more.
    for _ in 0..250 {
        bench.now = bench.now + STEP;
        bench.rack.poll(bench.now, &mut Vec::new());
    }
    assert_eq!(outputs(&bench), 0);
}

#[test]
fn a_bad_line_is_drawn_from_its_seed() {
    let said = |seed: u32| {
        let mut bench = Bench::up();
        for (sub, value) in [(10, seed), (7, 100), (8, 200), (9, 100)] {
            bench.write(0x5F02, sub, value);
        }
        bench.heard.clear();
        bench.pass(10_000);
        bench.heard
    };
    let (one, again, other) = (said(1), said(1), said(2));
    assert_eq!(one, again);
    assert_ne!(one, other);
    let mut bench = Bench::up();
    bench.rack.disturb(NodeId::new(4).expect("a node id"), FrameFaults { lost_from: 1000, ..FrameFaults::default() });
    bench.heard.clear();
    bench.pass(1000);
    assert_eq!(bench.beats(), 0);
    bench.rack.inject(bench.now, NodeId::new(4).expect("a node id"), None);
    bench.pass(1000);
    assert!(bench.trouble().is_empty());
}

#[test]
fn an_output_that_is_stuck_moves_or_does_not_whatever_it_is_sent() {
    let mut bench = Bench::up();
    let outputs = |bench: &Bench| bench.rack.plant().outputs(Owner::Station(crate::common::PRESS));
    bench.write(0x5F03, 1, 1);
    bench.pass(1);
    assert_eq!(outputs(&bench), 1);
    bench.write(0x5F03, 1, 0);
    let mut out = BusOutbox::default();
    bench.manager.set_outputs(bench.now, Owner::Station(crate::common::PRESS), 1, &mut out);
    for frame in &out.frames {
        bench.rack.handle(bench.now, frame, &mut Vec::new());
    }
    assert_eq!(outputs(&bench), 0, "stuck off");
    bench.write(0x5F03, 1, 2);
    bench.pass(1);
    assert_eq!(outputs(&bench), 1, "it follows again");
}
