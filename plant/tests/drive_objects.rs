//! The simulated drive's object dictionary: as its EDS says, and remapped only as CiA 301 allows.

use std::time::Duration;

use crate::drive_bench::described;
use linewright_canopen::{Frame, NodeId};
use linewright_eds::{Eds, read};
use linewright_line::{AtRest, Tick, Timing};
use linewright_plant::{DeviceOutbox, DriveNode};

const EDS: &[u8] = include_bytes!("../../launch-config/devices/linewright-drive.eds");
const NOW: Tick = Tick::from_millis(40);

fn eds() -> Eds {
    read("linewright-drive.eds", EDS).unwrap_or_else(|problems| panic!("{problems:#}"))
}

fn booted() -> DriveNode {
    let id = NodeId::new(5).expect("a node id");
    let mut node = DriveNode::new(Tick::ZERO, id, &described(AtRest::Off, false), 0.0, &Timing::default());
    node.poll(Tick::ZERO + Duration::from_millis(30), &mut DeviceOutbox::default());
    node
}

fn ask(node: &mut DriveNode, data: [u8; 8]) -> Vec<u8> {
    let mut out = DeviceOutbox::default();
    node.handle(NOW, &Frame::data_frame(0x605, &data).expect("a frame"), &mut out);
    out.frames[0].data().to_vec()
}

fn get(node: &mut DriveNode, index: u16, sub: u8) -> Vec<u8> {
    let [low, high] = index.to_le_bytes();
    ask(node, [0x40, low, high, sub, 0, 0, 0, 0])
}

/// Writes an object; the abort code, or 0.
fn put(node: &mut DriveNode, index: u16, sub: u8, len: u8, value: u32) -> u32 {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = value.to_le_bytes();
    let answer = ask(node, [0x23 | (4 - len) << 2, low, high, sub, a, b, c, d]);
    if answer[0] == 0x60 { 0 } else { u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]]) }
}

#[test]
fn every_entry_answers_as_described() {
    let (eds, mut node) = (eds(), booted());
    let mut read = 0;
    for (index, sub, entry) in eds.entries() {
        let answer = get(&mut node, index, sub);
        if !entry.access.is_readable() {
            assert_eq!(answer[0], 0x80, "{index:04X} {sub} is described as {}", entry.access);
            continue;
        }
        read += 1;
        let Some(size) = entry.data_type.size() else {
            assert_eq!((index, answer[0]), (0x1008, 0x41), "the name comes in segments");
            continue;
        };
        assert_eq!(answer[0], 0x43 | (4 - size as u8) << 2, "{index:04X} {sub} answers {answer:02X?}");
        let id = linewright_eds::NodeId::new(5).expect("a node id");
        if let Some(default) = entry.default_for(id) {
            let value = entry.data_type.decode(&answer[4..4 + size]).expect("of its size");
            assert_eq!(value, default, "{index:04X} {sub}");
        }
    }
    assert_eq!(read, 69, "entries of the description that can be read");
}

#[test]
fn nothing_answers_that_is_not_described_and_only_what_is_described_so_is_written() {
    let (eds, mut node) = (eds(), booted());
    for index in (0x1000..0x1C00).chain(0x5F00..0x5F10).chain(0x6000..0x6600) {
        for sub in 0..12 {
            let answer = get(&mut node, index, sub);
            let described = eds.entry(index, sub);
            assert!(described.is_some() || answer[0] == 0x80 || index == 0x5F00, "{index:04X} {sub} is not described");
            if index == 0x5F02 {
                // Numbers of any length, obeyed at once: `troubles.rs`.
                continue;
            }
            // Of a length no object has: whatever may be written complains of that, everything else of being written.
            let length = put(&mut node, index, sub, 3, 0) == 0x0607_0010;
            let writable = described.is_some_and(|entry| entry.access.is_writable()) && index != 0x5F00;
            assert_eq!(length, writable, "{index:04X} {sub}");
        }
    }
}

#[test]
fn a_mapping_is_changed_only_while_it_is_off_and_empty() {
    const STATE: u32 = 0x0800_0022;
    for (parameters, mapping, id, entry) in
        [(0x1400, 0x1600, 0x205u32, 0x607A_0020), (0x1800, 0x1A00, 0x4000_0185, 0x6064_0020)]
    {
        let mut node = booted();
        assert_eq!(put(&mut node, mapping, 0, 1, 0), STATE, "it is on");
        assert_eq!(put(&mut node, parameters, 1, 4, 0x8000_0000 | id), 0);
        assert_eq!(put(&mut node, mapping, 1, 4, entry), STATE, "it is not empty");
        assert_eq!(put(&mut node, mapping, 0, 1, 0), 0);
        assert_eq!(put(&mut node, mapping, 1, 4, entry), 0);
        assert_eq!(put(&mut node, mapping, 2, 4, 0x6098_0008), 0x0604_0041, "it cannot be mapped");
        assert_eq!(put(&mut node, mapping, 2, 4, entry - 0x10), 0x0604_0041, "half an object");
        assert_eq!(put(&mut node, mapping, 2, 4, entry), 0);
        assert_eq!(put(&mut node, mapping, 3, 4, entry), 0);
        assert_eq!(put(&mut node, mapping, 0, 1, 3), 0x0604_0042, "more than eight bytes");
        assert_eq!(put(&mut node, mapping, 0, 1, 4), 0x0604_0042, "nothing at 4");
        assert_eq!(put(&mut node, mapping, 0, 1, 9), 0x0609_0030);
        assert_eq!(put(&mut node, mapping, 0, 1, 2), 0);
        assert_eq!(put(&mut node, parameters, 2, 1, 1), 0x0609_0030, "synchronous");
        assert_eq!(put(&mut node, parameters, 1, 4, id + 1), 0x0609_0030, "another's identifier");
        assert_eq!(put(&mut node, parameters, 1, 4, id), 0);
        assert_eq!(put(&mut node, mapping, 0, 1, 0), STATE);
    }
    let mut node = booted();
    assert_eq!(put(&mut node, 0x1800, 3, 2, 10), STATE);
    assert_eq!(put(&mut node, 0x6060, 0, 1, 4), 0x0609_0030, "no such mode");
    assert_eq!(put(&mut node, 0x5F00, 1, 1, 2), 0x0609_0030, "a drive does not slip");
}
