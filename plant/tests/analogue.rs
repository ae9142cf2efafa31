//! Analogue channels, manager and simulated device together in virtual time: a pressure that follows a pump, a valve that
//! is set, wires that break, and a manager that is gone.

use std::time::Duration;

use linewright_canopen::{BusEvent, BusOutbox, Frame, Manager, NodeId};
use linewright_line::{
    Analogue, AnalogueChannel, AnalogueInput, AnalogueOutput, DeviceBus, Follows, InputId, Lag, OutputId, Owner, Tick,
    When,
};
use linewright_plant::{PlantOptions, Rack};

const OWNER: Owner = Owner::Station(crate::common::PRESS);
const PRESSURE_OK: u128 = 1 << 5;
const PRESSURE_LOW: u128 = 1 << 6;
const SOFT: u128 = 1 << 2;
const HARD: u128 = 1 << 3;

struct Bench {
    now: Tick,
    manager: Manager,
    rack: Rack,
    /// Nothing of the manager gets through.
    cut: bool,
    events: Vec<BusEvent>,
    wire: Vec<String>,
}

fn channel(number: u8) -> AnalogueChannel {
    AnalogueChannel { number, unit: "bar".to_owned(), factor: 0.01, offset: 0.0 }
}

fn analogue(follows: Option<Follows>) -> Analogue {
    let above = (InputId(5), When::Above { at: 5.0, hysteresis: 0.2 });
    let below = (InputId(6), When::Below { at: 1.0, hysteresis: 0.1 });
    let simulated = follows.map(|follows| Lag { follows, time_constant: Duration::from_millis(100) });
    let (least, most, broken, inputs) = (None, None, None, vec![above, below]);
    let input = AnalogueInput { channel: channel(3), least, most, inputs, broken, simulated };
    let outputs = vec![(OutputId(2), 3.5), (OutputId(3), 6.0)];
    Analogue { inputs: vec![input], outputs: vec![AnalogueOutput { channel: channel(1), rest: 0.5, outputs }] }
}

impl Bench {
    fn up(analogue: Analogue) -> Self {
        let mut line = crate::common::line();
        line.devices[0].io_mut().expect("I/O").analogue = analogue;
        let now = Tick::from_millis(100);
        let devices: Vec<_> = line.devices.iter().filter(|device| device.bus == DeviceBus::Line).collect();
        let manager = Manager::new(devices, line.timing).unwrap();
        let rack = Rack::new(now, &line, &DeviceBus::Line, PlantOptions::default());
        let (events, wire) = (Vec::new(), Vec::new());
        let mut bench = Bench { now, manager, rack, cut: false, events, wire };
        bench.run(400);
        assert!(bench.valid(), "{:?}", bench.manager.trouble(bench.now, OWNER).collect::<Vec<_>>());
        bench
    }

    fn run(&mut self, millis: u64) {
        for _ in 0..millis {
            self.now = self.now + Duration::from_millis(1);
            let (mut out, mut sent) = (BusOutbox::default(), Vec::new());
            self.rack.poll(self.now, &mut sent);
            self.manager.poll(self.now, &mut out);
            self.carry(out, sent);
        }
    }

    fn carry(&mut self, mut out: BusOutbox, mut sent: Vec<Frame>) {
        loop {
            self.events.append(&mut out.events);
            let orders = std::mem::take(&mut out.frames);
            if orders.is_empty() && sent.is_empty() {
                return;
            }
            for frame in sent.drain(..) {
                self.wire.push(frame.to_string());
                self.manager.handle(self.now, &frame, &mut out);
            }
            for frame in orders.iter().filter(|_| !self.cut) {
                self.wire.push(frame.to_string());
                self.rack.handle(self.now, frame, &mut sent);
            }
        }
    }

    fn set(&mut self, image: u128) {
        let mut out = BusOutbox::default();
        self.manager.set_outputs(self.now, OWNER, image, &mut out);
        self.carry(out, Vec::new());
    }

    /// A frame from a technician's shell.
    fn send(&mut self, frame: &str) {
        let mut sent = Vec::new();
        self.rack.handle(self.now, &frame.parse().unwrap(), &mut sent);
        self.carry(BusOutbox::default(), sent);
    }

    fn valid(&self) -> bool {
        self.manager.inputs(self.now, OWNER).valid
    }

    fn limits(&self) -> u128 {
        self.manager.inputs(self.now, OWNER).bits & (PRESSURE_OK | PRESSURE_LOW)
    }

    fn valve(&self) -> Option<i16> {
        self.rack.device(NodeId::new(4).unwrap()).unwrap().analogue_output(1)
    }
}

fn pump() -> Option<Follows> {
    // The output that drives the press forward drives the pump, too.
    Some(Follows::Output { output: OutputId(0), on: 6.0, off: 0.0 })
}

#[test]
fn a_pressure_follows_its_pump_and_its_limits_turn_inputs_on_and_off() {
    let mut bench = Bench::up(analogue(pump()));
    assert_eq!(bench.limits(), PRESSURE_LOW);
    bench.set(crate::common::FORWARD);
    // 6 bar · (1 − e^(−t/100 ms)) passes 1.1 bar after 20 ms and 5 bar after 179 ms.
    let mut seen = Vec::new();
    for millis in 1..=400 {
        bench.run(1);
        if seen.last().is_none_or(|(_, limits)| *limits != bench.limits()) {
            seen.push((millis, bench.limits()));
        }
    }
    let [(_, PRESSURE_LOW), (gone, 0), (come, PRESSURE_OK)] = seen[..] else { panic!("{seen:?}") };
    assert!((20..=30).contains(&gone) && (179..=189).contains(&come), "{seen:?}");
    // It falls below 4.8 bar: hysteresis.
    bench.set(0);
    bench.run(15);
    assert_eq!(bench.limits(), PRESSURE_OK);
    bench.run(20);
    assert_eq!(bench.limits(), 0);
    bench.run(300);
    assert_eq!(bench.limits(), PRESSURE_LOW);
    assert!(bench.valid() && !bench.events.iter().any(|event| matches!(event, BusEvent::ChannelFault { .. })));
}

#[test]
fn without_a_model_the_limits_are_what_the_mechanisms_say() {
    let mut limits = analogue(None);
    // The press's own switches come by the channel: in front is above, at the back is below.
    limits.inputs[0].inputs[0].0 = InputId(0);
    limits.inputs[0].inputs[1].0 = InputId(1);
    let mut line_inputs = Bench::up(limits);
    let bench = &mut line_inputs;
    let bits =
        |bench: &Bench| bench.manager.inputs(bench.now, OWNER).bits & (crate::common::FRONT | crate::common::BACK);
    assert_eq!(bits(bench), crate::common::BACK);
    bench.set(crate::common::FORWARD);
    bench.run(50);
    assert_eq!(bits(bench), 0);
    bench.run(300);
    assert_eq!(bits(bench), crate::common::FRONT);
}

#[test]
fn a_valve_takes_its_value_and_rests_when_the_manager_is_gone() {
    let mut bench = Bench::up(analogue(Some(Follows::Channel(1))));
    assert_eq!(bench.valve(), Some(50));
    bench.set(HARD);
    bench.run(500);
    assert_eq!((bench.valve(), bench.limits()), (Some(600), PRESSURE_OK));
    assert_eq!(bench.rack.plant().outputs(OWNER) & (SOFT | HARD), HARD);
    bench.set(SOFT);
    bench.run(500);
    assert_eq!((bench.valve(), bench.limits()), (Some(350), 0));
    bench.cut = true;
    bench.run(300);
    assert_eq!(bench.valve(), Some(50), "the error value, by the device's own watch");
    assert!(!bench.valid());
    bench.cut = false;
    bench.run(6000);
    assert!(bench.valid());
    assert_eq!(bench.valve(), Some(50), "what was ordered before is forgotten");
    bench.set(SOFT);
    bench.run(5);
    assert_eq!(bench.valve(), Some(350));
    // Stopped by somebody, and sent to pre-operational: rest as well.
    bench.send("000#0204");
    assert_eq!(bench.valve(), Some(50));
}

#[test]
fn a_device_told_to_stay_operational_lets_go_without_its_manager_and_goes_on_telling() {
    let mut bench = Bench::up(analogue(Some(Follows::Channel(1))));
    bench.send("604#2F29100101000000");
    bench.set(SOFT);
    bench.run(500);
    assert_eq!(bench.valve(), Some(350));
    bench.cut = true;
    bench.run(300);
    assert_eq!(bench.valve(), Some(50));
    bench.wire.clear();
    bench.run(1000);
    assert!(bench.wire.iter().filter(|frame| frame.starts_with("284#")).count() >= 9, "{:?}", bench.wire);
}

#[test]
fn a_wire_that_breaks_stops_its_owner_and_is_mended_without_restarting_anything() {
    let mut bench = Bench::up(analogue(pump()));
    bench.set(crate::common::FORWARD);
    bench.run(300);
    assert_eq!(bench.limits(), PRESSURE_OK);
    bench.send("604#23045F03FF7F0000");
    bench.run(1);
    assert!(!bench.valid());
    let trouble: Vec<String> = bench.manager.trouble(bench.now, OWNER).collect();
    assert!(
        trouble[0].starts_with("press1-io (node 04h): operational, but analogue input 3 (6401h:03)"),
        "{trouble:?}"
    );
    assert_eq!(bench.rack.plant().outputs(OWNER), 0, "nothing is energised by an owner that cannot know");
    bench.run(2000);
    assert!(!bench.valid());
    bench.send("604#23045F0300000100");
    bench.run(250);
    assert!(!bench.valid(), "not before it has held for a while");
    bench.run(150);
    assert!(bench.valid());
    assert_eq!(bench.rack.plant().outputs(OWNER), 0);
    let booted = bench.events.iter().filter(|event| matches!(event, BusEvent::DeviceUp { .. })).count();
    assert_eq!(booted, 2, "each device once");
}

#[test]
fn channels_that_are_switched_off_are_missed() {
    let mut bench = Bench::up(analogue(pump()));
    // 6423h, by a technician who does not ask the manager.
    bench.send("604#2F23640000000000");
    bench.run(190);
    assert!(bench.valid());
    bench.run(120);
    assert!(!bench.valid());
    bench.send("604#2F23640001000000");
    bench.run(110);
    assert!(bench.valid());
}

#[test]
fn a_value_that_rests_is_sent_ten_times_a_second_and_no_more() {
    let mut bench = Bench::up(analogue(pump()));
    bench.wire.clear();
    bench.run(1000);
    let count = bench.wire.iter().filter(|frame| frame.starts_with("284#")).count();
    assert!((9..=11).contains(&count), "{count}");
}

/// A technician switches what it sends off, or its inputs, while it runs: it does nothing about it, and not all the time.
#[test]
fn channels_that_are_switched_off_while_it_runs_wait_until_they_are_on_again() {
    // Object 6423h, and bit 31 of 1801h:01 for the TPDO2 of node 4.
    for (off, on) in
        [("604#2F23640000000000", "604#2F23640001000000"), ("604#2301180184020080", "604#2301180184020000")]
    {
        let mut bench = Bench::up(analogue(pump()));
        bench.set(1);
        bench.run(2);
        bench.send(off);
        assert!(bench.wire.last().is_some_and(|answer| answer.starts_with("584#60")), "{:?}", bench.wire.last());
        bench.wire.clear();
        let mut polls = 0;
        for _ in 0..200 {
            bench.run(1);
            let mut sent = Vec::new();
            while bench.rack.next_deadline().is_some_and(|due| due <= bench.now) && polls < 1000 {
                bench.rack.poll(bench.now, &mut sent);
                polls += 1;
            }
        }
        assert!(polls < 1000, "{off}: it wants to be polled again and again for nothing");
        assert!(!bench.wire.iter().any(|frame| frame.starts_with("284#")), "{off}");
        bench.send(on);
        bench.run(2);
        assert!(bench.wire.iter().any(|frame| frame.starts_with("284#")), "{on}");
    }
}
