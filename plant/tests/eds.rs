//! The device and its description say the same: every entry that can be read answers with as many bytes as its type
//! has and, if it has a default, with that; and nothing answers that is not described.

use std::time::Duration;

use linewright_canopen::sdo::{ObjectId, SdoClient, TransferOptions, TransferProgress};
use linewright_canopen::{CanopenMessage, Frame};
use linewright_eds::{Eds, NodeId, ObjectValue, read};
use linewright_line::{Analogue, AnalogueChannel, AnalogueInput, AnalogueOutput, Tick, Timing};
use linewright_plant::{DeviceNode, DeviceOutbox};

const NODE: u8 = 4;
const EDS: &[u8] = include_bytes!("../../launch-config/devices/linewright-io.eds");
const ANALOGUE: &[u8] = include_bytes!("../../launch-config/devices/linewright-analogue.eds");

fn described() -> Eds {
    read("linewright-io.eds", EDS).unwrap_or_else(|problems| panic!("{problems:#}"))
}

/// Descriptions, their devices, and how many entries of each can be read.
fn pairs() -> [(Eds, DeviceNode, usize); 2] {
    let analogue = read("linewright-analogue.eds", ANALOGUE).unwrap_or_else(|problems| panic!("{problems:#}"));
    [(described(), device(), 78), (analogue, device().with_channels(&channels()), 195)]
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

/// A device of 64 inputs and outputs that has booted.
fn device() -> DeviceNode {
    let id = linewright_canopen::NodeId::new(NODE).expect("a node id");
    let mut device = DeviceNode::new(Tick::ZERO, id, 64, 64, &Timing::default());
    device.poll(Tick::ZERO + Duration::from_millis(30), &mut DeviceOutbox::default());
    device
}

/// The answer to an upload request, as bytes of the frame.
fn ask(device: &mut DeviceNode, index: u16, sub: u8) -> Vec<u8> {
    let [low, high] = index.to_le_bytes();
    let request = Frame::data_frame(0x600 + u16::from(NODE), &[0x40, low, high, sub, 0, 0, 0, 0]).expect("a frame");
    let mut out = DeviceOutbox::default();
    device.handle(Tick::ZERO + Duration::from_millis(31), &request, &mut out);
    assert_eq!(out.frames.len(), 1, "{index:04X} {sub}");
    out.frames[0].data().to_vec()
}

/// An object of any length, as a manager reads it.
fn upload(device: &mut DeviceNode, object: ObjectId) -> Vec<u8> {
    let now = Tick::ZERO + Duration::from_millis(31);
    let node = linewright_canopen::NodeId::new(NODE).expect("a node id");
    let mut client = SdoClient::upload(object, TransferOptions::default());
    let mut requests = Vec::new();
    client.start(now, &mut requests);
    loop {
        let mut out = DeviceOutbox::default();
        for raw in requests.drain(..) {
            device.handle(now, &CanopenMessage::SdoRequest { node, raw }.encode(), &mut out);
        }
        let Ok(CanopenMessage::SdoResponse { raw, .. }) = CanopenMessage::decode(&out.frames[0]) else {
            panic!("{:?}", out.frames)
        };
        if let TransferProgress::Done(result) = client.handle(now, &raw, &mut requests) {
            return result.unwrap_or_else(|error| panic!("{error}"));
        }
    }
}

#[test]
fn every_entry_answers_as_described() {
    for (eds, mut device, readable) in pairs() {
        let mut read = 0;
        for (index, sub, entry) in eds.entries() {
            let answer = ask(&mut device, index, sub);
            if !entry.access.is_readable() {
                assert_eq!(answer[0], 0x80, "{index:04X} {sub} is described as {}", entry.access);
                continue;
            }
            let bytes = upload(&mut device, ObjectId::new(index, sub));
            let value = entry.data_type.decode(&bytes).expect("of its size");
            if let Some(default) = entry.default_for(NodeId::new(NODE).expect("a node id")) {
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
                // Whatever can be read is described; what can only be written says so.
                let answer = ask(&mut device, index, sub);
                if eds.entry(index, sub).is_none() && !(matches!(index, 0x5F00 | 0x5F01)) {
                    assert_eq!(answer[0], 0x80, "{index:04X} {sub} answers and is not described");
                }
            }
        }
    }
}

#[test]
fn what_a_configuration_sets_the_device_takes() {
    let node = NodeId::new(NODE).expect("a node id");
    let configuration = linewright_eds::Configuration::new(node)
        .set(0x1016, 1, ObjectValue::Unsigned(0x0001_0064))
        .set(0x1017, 0, ObjectValue::Unsigned(100));
    let dcf = described().configure("io4.dcf", &configuration).unwrap_or_else(|errors| panic!("{errors}"));
    let mut device = device();
    for download in dcf.downloads(node).expect("for this node") {
        let linewright_eds::DownloadContent::Bytes(bytes) = &download.content else { panic!("{download}") };
        let [low, high] = download.index.to_le_bytes();
        let mut data = vec![0x23 | (4 - bytes.len() as u8) << 2, low, high, download.sub, 0, 0, 0, 0];
        data[4..4 + bytes.len()].copy_from_slice(bytes);
        let request = Frame::data_frame(0x600 + u16::from(NODE), &data).expect("a frame");
        let mut out = DeviceOutbox::default();
        device.handle(Tick::ZERO + Duration::from_millis(32), &request, &mut out);
        assert_eq!(out.frames[0].data()[0], 0x60, "{download}");
        let answer = ask(&mut device, download.index, download.sub);
        assert_eq!(&answer[4..4 + bytes.len()], bytes);
    }
}
