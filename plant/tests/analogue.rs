//! Analogue channels, manager and simulated device together in virtual time: a pressure that follows a pump, a valve that
//! is set, wires that break, and a manager that is gone.

use std::time::Duration;

use linewright_canopen::{BusEvent, NodeId};
use linewright_line::{
    Analogue, AnalogueChannel, AnalogueInput, AnalogueOutput, Follows, InputId, Lag, OutputId, Timing, When,
};
use linewright_plant::{DeviceNode, DeviceOutbox};

use crate::alone::Alone;
use crate::managed::Managed;
use linewright_testkit::presses::{BACK, FORWARD, FRONT, line};

const PRESSURE_OK: u128 = 1 << 5;
const PRESSURE_LOW: u128 = 1 << 6;
const SOFT: u128 = 1 << 2;
const HARD: u128 = 1 << 3;

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

fn up(analogue: Analogue) -> Managed {
    let mut line = line();
    line.devices[0].io_mut().expect("I/O").analogue = analogue;
    Managed::up(&line)
}

fn limits(bus: &Managed) -> u128 {
    bus.bits() & (PRESSURE_OK | PRESSURE_LOW)
}

/// The number that analogue output 1 is at.
fn valve(bus: &Managed) -> Option<i16> {
    let node = NodeId::new(4).expect("a node id");
    bus.rack.device(node).expect("press1-io").analogue_output(1)
}

fn pump() -> Option<Follows> {
    // The output that drives the press forward drives the pump, too.
    Some(Follows::Output { output: OutputId(0), on: 6.0, off: 0.0 })
}

#[test]
fn a_pressure_follows_its_pump_and_its_limits_turn_inputs_on_and_off() {
    let mut bus = up(analogue(pump()));
    assert_eq!(limits(&bus), PRESSURE_LOW);
    bus.set(FORWARD);
    // 6 bar · (1 − e^(−t/100 ms)) passes 1.1 bar after 20 ms and 5 bar after 179 ms.
    let mut seen = Vec::new();
    for millis in 1..=400 {
        bus.run(1);
        if seen.last().is_none_or(|(_, last)| *last != limits(&bus)) {
            seen.push((millis, limits(&bus)));
        }
    }
    let [(_, PRESSURE_LOW), (gone, 0), (come, PRESSURE_OK)] = seen[..] else { panic!("{seen:?}") };
    assert!((20..=30).contains(&gone) && (179..=189).contains(&come), "{seen:?}");
    // It falls below 4.8 bar: hysteresis.
    bus.set(0);
    bus.run(15);
    assert_eq!(limits(&bus), PRESSURE_OK);
    bus.run(20);
    assert_eq!(limits(&bus), 0);
    bus.run(300);
    assert_eq!(limits(&bus), PRESSURE_LOW);
    assert!(bus.is_valid() && !bus.events.iter().any(|event| matches!(event, BusEvent::ChannelFault { .. })));
}

#[test]
fn without_a_model_the_limits_are_what_the_mechanisms_say() {
    let mut limits = analogue(None);
    // The press's own switches come by the channel: in front is above, at the back is below.
    limits.inputs[0].inputs[0].0 = InputId(0);
    limits.inputs[0].inputs[1].0 = InputId(1);
    let mut bus = up(limits);
    let bits = |bus: &Managed| bus.bits() & (FRONT | BACK);
    assert_eq!(bits(&bus), BACK);
    bus.set(FORWARD);
    bus.run(50);
    assert_eq!(bits(&bus), 0);
    bus.run(300);
    assert_eq!(bits(&bus), FRONT);
}

#[test]
fn a_valve_takes_its_value_and_rests_when_the_manager_is_gone() {
    let mut bus = up(analogue(Some(Follows::Channel(1))));
    assert_eq!(valve(&bus), Some(50));
    bus.set(HARD);
    bus.run(500);
    assert_eq!((valve(&bus), limits(&bus)), (Some(600), PRESSURE_OK));
    assert_eq!(bus.outputs() & (SOFT | HARD), HARD);
    bus.set(SOFT);
    bus.run(500);
    assert_eq!((valve(&bus), limits(&bus)), (Some(350), 0));
    bus.passes = |_| false;
    bus.run(300);
    assert_eq!(valve(&bus), Some(50), "the error value, by the device's own watch");
    assert!(!bus.is_valid());
    bus.passes = |_| true;
    bus.run(6000);
    assert!(bus.is_valid());
    assert_eq!(valve(&bus), Some(50), "what was ordered before is forgotten");
    bus.set(SOFT);
    bus.run(5);
    assert_eq!(valve(&bus), Some(350));
    // Stopped from outside, and sent to pre-operational: rest in both.
    bus.send("000#0204");
    assert_eq!(valve(&bus), Some(50));
}

#[test]
fn a_device_told_to_stay_operational_lets_go_without_its_manager_and_goes_on_telling() {
    let mut bus = up(analogue(Some(Follows::Channel(1))));
    bus.send("604#2F29100101000000");
    bus.set(SOFT);
    bus.run(500);
    assert_eq!(valve(&bus), Some(350));
    bus.passes = |_| false;
    bus.run(300);
    assert_eq!(valve(&bus), Some(50));
    bus.wire.clear();
    bus.run(1000);
    assert!(bus.sent("284#").len() >= 9, "{:?}", bus.wire);
}

#[test]
fn a_wire_that_breaks_stops_its_owner_and_is_mended_without_restarting_anything() {
    let mut bus = up(analogue(pump()));
    bus.set(FORWARD);
    bus.run(300);
    assert_eq!(limits(&bus), PRESSURE_OK);
    bus.send("604#23045F03FF7F0000");
    bus.run(1);
    assert!(!bus.is_valid());
    assert_eq!(bus.outputs(), 0, "nothing is energised by an owner that cannot know");
    bus.run(2000);
    assert!(!bus.is_valid());
    bus.send("604#23045F0300000100");
    bus.run(250);
    assert!(!bus.is_valid(), "not before it has held for a while");
    bus.run(150);
    assert!(bus.is_valid());
    assert_eq!(bus.outputs(), 0);
    let booted = bus.events.iter().filter(|event| matches!(event, BusEvent::DeviceUp { .. })).count();
    assert_eq!(booted, 2, "each device once");
}

#[test]
fn a_value_that_rests_is_sent_ten_times_a_second_and_no_more() {
    let mut bus = up(analogue(pump()));
    bus.wire.clear();
    bus.run(1000);
    assert!((9..=11).contains(&bus.sent("284#").len()), "{:?}", bus.wire);
}

/// A technician switches what it sends off, or its inputs, while it runs: it does nothing about it, and not all the time.
#[test]
fn channels_that_are_switched_off_while_it_runs_wait_until_they_are_on_again() {
    // Object 6423h, and bit 31 of 1801h:01 for the TPDO2 of node 4.
    for (off, on) in
        [("604#2F23640000000000", "604#2F23640001000000"), ("604#2301180184020080", "604#2301180184020000")]
    {
        let mut bus = up(analogue(pump()));
        bus.set(1);
        bus.run(2);
        bus.send(off);
        assert!(bus.sent("584#60").contains(&bus.now), "{off} is taken");
        bus.wire.clear();
        // The bench refuses a device that requests polls without effect.
        bus.run(200);
        assert!(bus.sent("284#").is_empty(), "{off}");
        bus.send(on);
        bus.run(2);
        assert!(!bus.sent("284#").is_empty(), "{on}");
    }
}

/// An I/O device with these channels, without a manager.
fn alone(channels: &Analogue) -> Alone<Box<DeviceNode>> {
    let device = |now, node| Box::new(DeviceNode::new(now, node, 8, 8, &Timing::default()).with_channels(channels));
    Alone::started(4, device)
}

/// What channel 3 measures, from now on with these inputs and outputs of the mechanisms.
fn measured(bench: &mut Alone<Box<DeviceNode>>, inputs: u128, outputs: u128) -> i16 {
    bench.device.set_plant(bench.now, inputs, outputs, &mut DeviceOutbox::default());
    let data = bench.read("6401:3").expect("it measures");
    i16::from_le_bytes([data[0], data[1]])
}

#[test]
fn without_a_model_a_number_fits_what_the_switches_are() {
    let mut channels = analogue(None);
    channels.inputs[0].broken = Some(InputId(9));
    let of = &channels.inputs[0];
    let mut bench = alone(&channels);
    for image in [0, PRESSURE_OK, PRESSURE_LOW] {
        let number = measured(&mut bench, image, 0);
        for was in [false, true] {
            let now: Vec<bool> = of.inputs.iter().map(|(_, when)| of.holds(*when, number, was)).collect();
            assert_eq!(now, [image == PRESSURE_OK, image == PRESSURE_LOW], "{number}");
        }
    }
    assert_eq!(measured(&mut bench, 1 << 9, 0), i16::MAX);
    let both = measured(&mut bench, PRESSURE_OK | PRESSURE_LOW, 0);
    assert!(of.is_measured(both), "both at once cannot be; it stays a measurement");
}

#[test]
fn a_value_follows_its_output_by_the_exponential_from_wherever_it_is() {
    let mut bench = alone(&analogue(pump()));
    let mut after = |millis: u64, outputs: u128| {
        bench.pass(millis);
        measured(&mut bench, 0, outputs)
    };
    let expected = |passed: f64| (600.0 * (1.0 - (-passed / 100.0f64).exp())).round() as i16;
    assert_eq!([after(0, 0), after(0, FORWARD)], [0; 2]);
    assert_eq!([50, 50, 900].map(|millis| after(millis, FORWARD)), [50.0, 100.0, 1000.0].map(expected));
    assert_eq!(after(0, 0), 600);
    assert_eq!(after(100, 0), 221, "600 / e");
}
