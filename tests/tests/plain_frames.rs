//! The clamp's valves and switches hang on a box without CANopen: the line works as before.

use std::time::Duration;

use linewright_line::{
    Checksum, Coding, DbcName, DeviceKind, FrameBinding, FrameField, FrameId, FrameTable, Line, Page,
    ReceivedFrameBinding, SentFrameBinding, When,
};
use linewright_plant::DeviceFault;
use linewright_tests::{WatchedLine, transfer_line};

const BOX: &str = "clamp 1 io";

fn field(start: usize, size: u8) -> FrameField {
    let start = start as u8;
    FrameField { start, size, motorola: false, coding: Coding::Unsigned, factor: 1.0, offset: 0.0 }
}

/// The shipped line; that device's bits are those of two messages with counter and checksum.
fn line() -> Line {
    let mut line = transfer_line(1.0);
    let device = line.devices.iter_mut().find(|device| device.name == BOX).expect("the clamp's device");
    let (inputs, outputs) = (device.input_bits().to_vec(), device.output_bits().to_vec());
    let inputs = inputs.iter().enumerate().filter_map(|(at, input)| Some(((*input)?, field(at, 1), When::NotZero)));
    let outputs = outputs.iter().enumerate().filter_map(|(at, output)| Some(((*output)?, field(at, 1), 1)));
    let heard = ReceivedFrameBinding {
        name: "State".to_owned(),
        id: FrameId { id: 0x18FF_0021, extended: true },
        len: 8,
        timeout: Duration::from_millis(100),
        counter: Some(field(48, 4)),
        checksum: Some((7, Checksum::Crc8)),
        pages: vec![Page { selected: None, inputs: inputs.collect(), limits: Vec::new() }],
    };
    let told = SentFrameBinding {
        lets_go_after: Some(Duration::from_millis(100)),
        name: "Command".to_owned(),
        id: FrameId { id: 0x321, extended: false },
        len: 4,
        every: Duration::from_millis(20),
        counter: Some(field(16, 8)),
        checksum: Some((3, Checksum::Xor)),
        rest: [0; 8],
        outputs: outputs.collect(),
    };
    device.kind = DeviceKind::Frames(FrameTable {
        file: DbcName { name: "box.dbc".to_owned(), at: 0..0 },
        receive: Vec::new(),
        send: Vec::new(),
        bound: Some(FrameBinding { heard: vec![heard], told: vec![told] }),
    });
    line
}

#[test]
fn the_line_cycles() {
    let mut sim = WatchedLine::new(&line(), 1);
    sim.start_auto();
    sim.run_until_done("mill_1", "reset main slide", 3);
    for part in 1..=2 {
        assert_eq!(sim.observer().machined(1, part), 1, "part {part} is machined once");
    }
}

#[test]
fn a_box_that_falls_silent_stops_its_station_until_it_is_recovered() {
    for moment in (0..3560).step_by(445) {
        let mut sim = WatchedLine::new(&line(), moment);
        sim.start_auto();
        sim.run_until_done("clamp_1", "return clamp", 2);
        sim.run_for(Duration::from_millis(moment));
        let clamp = sim.id("clamp_1");
        sim.fail_device(BOX, Some(DeviceFault::Silent));
        sim.run_for(Duration::from_millis(110));
        assert_eq!(sim.energised(clamp), 0, "at {moment}");
        sim.fail_device(BOX, None);
        sim.bring_back();
        sim.run_until_done("mill_1", "reset main slide", 4);
        for part in 1..=3 {
            assert_eq!(sim.observer().machined(1, part), 1, "at {moment}: part {part} is machined once");
        }
    }
}
