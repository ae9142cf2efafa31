//! The device and its description agree: every entry that can be read answers with as many bytes as its type has and,
//! if it has a default, with that; and nothing answers that is not described.

use linewright_canopen::sdo::Abort;
use linewright_canopen::{CanopenMessage, NodeId};
use linewright_eds::{Eds, ObjectValue, read};
use linewright_line::{Analogue, AnalogueChannel, AnalogueInput, AnalogueOutput, AtRest, Tick, Timing};
use linewright_plant::{CanDevice, DeviceNode, DeviceOutbox, DriveNode};

use crate::alone::{Alone, refused};
use crate::drive_bench::described as described_drive;

const NODE: u8 = 4;

fn eds(name: &str) -> Eds {
    let file = format!("{}/../launch-config/devices/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read(&file).unwrap_or_else(|error| panic!("{file}: {error}"));
    read(name, &text).unwrap_or_else(|problems| panic!("{problems:#}"))
}

type AnyDevice = Box<dyn CanDevice>;

fn boxed<D: CanDevice + 'static>(device: impl FnOnce(Tick, NodeId) -> D) -> Alone<AnyDevice> {
    Alone::booted(NODE, |now, node| Box::new(device(now, node)) as AnyDevice)
}

/// Descriptions, their devices, and how many entries of each can be read.
fn pairs() -> [(Eds, Alone<AnyDevice>, usize); 3] {
    let drive = |now, node| DriveNode::new(now, node, &described_drive(AtRest::Off, false), 0.0, &Timing::default());
    [
        (eds("linewright-io.eds"), boxed(io), 82),
        (eds("linewright-analogue.eds"), boxed(|now, node| io(now, node).with_channels(&channels())), 199),
        (eds("linewright-drive.eds"), boxed(drive), 76),
    ]
}

/// A device of 64 inputs and outputs.
fn io(now: Tick, node: NodeId) -> DeviceNode {
    DeviceNode::new(now, node, 64, 64, &Timing::default())
}

/// All that a device can have.
fn channels() -> Analogue {
    let channel = |number| AnalogueChannel { number, unit: String::new(), factor: 1.0, offset: 0.0 };
    let input = |number| {
        let (least, most, broken, simulated) = (None, None, None, None);
        AnalogueInput { channel: channel(number), least, most, inputs: Vec::new(), broken, simulated }
    };
    let output = |number| AnalogueOutput { channel: channel(number), rest: 0.0, outputs: Vec::new() };
    Analogue { inputs: (1..=12).map(input).collect(), outputs: (1..=12).map(output).collect() }
}

/// Whether the device answers an upload request with data. Asked millions of times, so not by texts of frames.
fn answers(device: &mut Alone<AnyDevice>, index: u16, sub: u8) -> bool {
    let [low, high] = index.to_le_bytes();
    let node = NodeId::new(NODE).expect("a node id");
    let request = CanopenMessage::SdoRequest { node, raw: [0x40, low, high, sub, 0, 0, 0, 0] }.encode();
    let mut out = DeviceOutbox::default();
    device.device.handle(device.now, &request, &mut out);
    let answer = out.frames.iter().find(|frame| frame.cob_id() == Some(0x580 + u16::from(NODE)));
    answer.unwrap_or_else(|| panic!("{index:04X} {sub}: no answer")).data()[0] != 0x80
}

#[test]
fn every_entry_answers_as_described() {
    for (eds, mut device, readable) in pairs() {
        let mut read = 0;
        for (index, sub, entry) in eds.entries() {
            if !entry.access.is_readable() {
                assert!(!answers(&mut device, index, sub), "{index:04X} {sub} is described as {}", entry.access);
                continue;
            }
            let bytes = device.read(&format!("{index:X}:{sub:X}")).unwrap_or_else(|error| panic!("{error:?}"));
            let value = entry.data_type.decode(&bytes).expect("of its size");
            if let Some(default) = entry.default_for(linewright_eds::NodeId::new(NODE).expect("a node id")) {
                assert_eq!(value, default, "{index:04X} {sub}");
            }
            read += 1;
        }
        assert_eq!(read, readable, "entries of the description that can be read");
    }
}

#[test]
fn nothing_answers_that_is_not_described() {
    for (eds, mut device, _) in pairs() {
        for index in (0x1000..0x1C00).chain(0x2000..0x7000) {
            for sub in 0..=70 {
                let described = eds.entry(index, sub).is_some() || !answers(&mut device, index, sub);
                assert!(described, "{index:04X} {sub} answers and is not described");
            }
        }
    }
}

/// Of a length no object has: whatever may be written complains of that, everything else of being written.
#[test]
fn a_drive_takes_only_what_is_described_as_writable() {
    let [.., (eds, mut drive, _)] = pairs();
    for index in (0x1000..0x1C00).chain(0x5F00..0x5F02).chain(0x6000..0x6600) {
        for sub in 0..12 {
            let too_long = drive.write(&format!("{index:X}:{sub:X}"), &[0; 3]) == refused(Abort::LENGTH);
            let writable = eds.entry(index, sub).is_some_and(|entry| entry.access.is_writable()) && index != 0x5F00;
            assert_eq!(too_long, writable, "{index:04X} {sub}");
        }
    }
}

#[test]
fn what_a_configuration_sets_the_device_takes() {
    let node = linewright_eds::NodeId::new(NODE).expect("a node id");
    let configuration = linewright_eds::Configuration::new(node)
        .set(0x1016, 1, ObjectValue::Unsigned(0x0001_0064))
        .set(0x1017, 0, ObjectValue::Unsigned(100));
    let [(eds, mut device, _), ..] = pairs();
    let dcf = eds.configure("io4.dcf", &configuration).unwrap_or_else(|errors| panic!("{errors}"));
    for download in dcf.downloads(node).expect("for this node") {
        let linewright_eds::DownloadContent::Bytes(bytes) = &download.content else { panic!("{download}") };
        let object = format!("{:X}:{:X}", download.index, download.sub);
        assert_eq!(device.write(&object, bytes), Ok(()), "{download}");
        assert_eq!(device.read(&object), Ok(bytes.clone()));
    }
}
