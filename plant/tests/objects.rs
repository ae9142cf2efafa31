//! The objects of a device, read and written with the SDO client as a manager would, and what they bring about.

use std::time::Duration;

use linewright_canopen::sdo::{
    Abort, ObjectId, SdoClient, TransferFailure, TransferMode, TransferOptions, TransferProgress,
};
use linewright_canopen::{CanopenMessage, Frame, NodeId};
use linewright_line::{Tick, Timing};
use linewright_plant::{DeviceNode, DeviceOutbox};
use proptest::prelude::*;

/// Node 4 with ten inputs and outputs.
struct Bench {
    device: DeviceNode,
    now: Tick,
    out: DeviceOutbox,
}

impl Bench {
    fn new() -> Self {
        let now = Tick::from_millis(1000);
        let device = DeviceNode::new(now, NodeId::new(4).unwrap(), 10, 10, &Timing::default());
        let mut bench = Bench { device, now, out: DeviceOutbox::default() };
        bench.pass(20);
        bench
    }

    fn up() -> Self {
        let mut bench = Bench::new();
        bench.hear("000#0104");
        bench.take();
        bench
    }

    fn pass(&mut self, millis: u64) {
        let until = self.now + Duration::from_millis(millis);
        while let Some(due) = self.device.next_deadline().filter(|due| *due <= until) {
            self.now = due;
            self.device.poll(due, &mut self.out);
        }
        self.now = until;
    }

    fn hear(&mut self, text: &str) {
        self.device.handle(self.now, &text.parse().unwrap(), &mut self.out);
    }

    /// What it has sent besides heartbeats.
    fn take(&mut self) -> Vec<String> {
        let frames = std::mem::take(&mut self.out).frames;
        frames.iter().map(Frame::to_string).filter(|text| !text.starts_with("704")).collect()
    }

    /// Carries out a transfer. No time passes, except where one side waits.
    fn transfer(&mut self, mut client: SdoClient) -> Result<Vec<u8>, TransferFailure> {
        let node = NodeId::new(4).unwrap();
        let mut requests = Vec::new();
        client.start(self.now, &mut requests);
        loop {
            let mut out = DeviceOutbox::default();
            for raw in requests.drain(..) {
                self.device.handle(self.now, &CanopenMessage::SdoRequest { node, raw }.encode(), &mut out);
            }
            if out.frames.is_empty() {
                let device = self.device.next_deadline();
                self.now = client.next_deadline().into_iter().chain(device).min().unwrap().max(self.now);
                self.device.poll(self.now, &mut out);
                if let TransferProgress::Done(result) = client.poll(self.now, &mut requests) {
                    return result.map_err(|error| error.cause);
                }
            }
            for frame in out.frames {
                match CanopenMessage::decode(&frame) {
                    Ok(CanopenMessage::SdoResponse { raw, .. }) => {
                        if let TransferProgress::Done(result) = client.handle(self.now, &raw, &mut requests) {
                            for raw in requests.drain(..) {
                                self.device.handle(
                                    self.now,
                                    &CanopenMessage::SdoRequest { node, raw }.encode(),
                                    &mut self.out,
                                );
                            }
                            return result.map_err(|error| error.cause);
                        }
                    }
                    _ => self.out.frames.push(frame),
                }
            }
        }
    }

    fn read(&mut self, object: &str) -> Result<Vec<u8>, TransferFailure> {
        self.transfer(SdoClient::upload(object.parse().unwrap(), TransferOptions::default()))
    }

    fn write(&mut self, object: &str, data: &[u8]) -> Result<(), TransferFailure> {
        self.transfer(SdoClient::download(object.parse::<ObjectId>().unwrap(), data, TransferOptions::default()))
            .map(|_| ())
    }
}

fn refused<T>(code: Abort) -> Result<T, TransferFailure> {
    Err(TransferFailure::Refused(code))
}

#[test]
fn it_says_who_it_is_in_segments_and_in_blocks() {
    let mut bench = Bench::new();
    for mode in [TransferMode::Auto, TransferMode::Segmented, TransferMode::Block] {
        let client =
            SdoClient::upload(ObjectId::new(0x1008, 0), TransferOptions { mode, ..TransferOptions::default() });
        assert_eq!(bench.transfer(client).unwrap(), b"Linewright simulated I/O", "{mode:?}");
    }
    assert_eq!(bench.read("1009").unwrap(), b"simulated");
    assert_eq!(bench.read("100A").unwrap(), env!("CARGO_PKG_VERSION").as_bytes());
    let identity: Vec<Vec<u8>> = (0..=4).map(|sub| bench.read(&format!("1018:{sub}")).unwrap()).collect();
    assert_eq!(identity, [vec![4], vec![0; 4], vec![0x91, 1, 0, 0], vec![0, 0, 1, 0], vec![4, 0, 0, 0]]);
    assert_eq!(bench.read("1018:5"), refused(Abort::NO_SUBINDEX));
    assert_eq!(bench.write("1008", b"another name"), refused(Abort::READ_ONLY));
    assert_eq!(bench.write("1234", b"more than four"), refused(Abort::NO_OBJECT));
}

#[test]
fn outputs_take_their_error_value_when_the_manager_is_gone_or_stops_them() {
    let mut bench = Bench::up();
    assert_eq!(bench.read("6206:1").unwrap(), [0xFF]);
    assert_eq!(bench.read("6207:2").unwrap(), [0x00]);
    // Output 0 stays as it is, 1 goes on, 2 goes off; 8 goes off, 9 on.
    bench.write("6206:1", &[0xFE]).unwrap();
    bench.write("6207:1", &[0x02]).unwrap();
    bench.write("6207:2", &[0xFE]).unwrap();
    bench.hear("77F#05");
    bench.hear("204#0501");
    assert_eq!(bench.device.outputs(), 0x105);
    bench.pass(200);
    assert_eq!(bench.device.outputs(), 0x203, "outputs that do not exist are not on either");
    assert!(bench.take().contains(&"084#3081110000000000".to_owned()));
    bench.hear("000#0104");
    bench.hear("204#0000");
    bench.hear("204#0500");
    bench.hear("000#0204");
    assert_eq!(bench.device.outputs(), 0x203, "stopped");
    bench.hear("000#8004");
    assert_eq!(bench.device.outputs(), 0, "pre-operational by order");
    // A boot forgets.
    bench.hear("000#8104");
    bench.pass(20);
    assert_eq!(bench.read("6206:1").unwrap(), [0xFF]);
    assert_eq!(bench.read("6207:1").unwrap(), [0]);
    assert_eq!(bench.read("6207:0").unwrap(), [2]);
    assert_eq!(bench.read("6207:3"), refused(Abort::NO_SUBINDEX));
    assert_eq!(bench.write("6207:1", &[1, 2]), refused(Abort::LENGTH));
    assert_eq!(bench.write("6207:0", &[1]), refused(Abort::READ_ONLY));
}

#[test]
fn where_a_lost_manager_leads_is_configured() {
    for (code, state, outputs) in [(0u8, "704#7F", 0), (1, "704#05", 0), (2, "704#04", 0)] {
        let mut bench = Bench::up();
        bench.write("1029:1", &[code]).unwrap();
        assert_eq!(bench.read("1029:1").unwrap(), [code]);
        bench.hear("77F#05");
        bench.hear("204#FF03");
        bench.pass(200);
        assert_eq!(bench.device.outputs(), outputs);
        let frames: Vec<String> = std::mem::take(&mut bench.out).frames.iter().map(Frame::to_string).collect();
        assert!(frames.contains(&"084#3081110000000000".to_owned()), "{frames:?}");
        bench.pass(50);
        let frames: Vec<String> = std::mem::take(&mut bench.out).frames.iter().map(Frame::to_string).collect();
        assert!(frames.iter().any(|frame| frame == state), "{code}: {frames:?}");
    }
    assert_eq!(Bench::up().write("1029:1", &[3]), refused(Abort::VALUE));
}

#[test]
fn pdo_parameters_are_readable() {
    let mut bench = Bench::new();
    let mut read = |object: &str| bench.read(object).unwrap();
    assert_eq!([read("1400:0"), read("1400:1"), read("1400:2")], [vec![2], vec![4, 2, 0, 0], vec![255]]);
    assert_eq!([read("1800:0"), read("1800:1"), read("1800:2")], [vec![5], vec![0x84, 1, 0, 0], vec![255]]);
    assert_eq!(read("1800:5"), [100, 0]);
    assert_eq!([read("1600:0"), read("1600:1")], [vec![2], vec![8, 1, 0, 0x62]]);
    assert_eq!([read("1A00:0"), read("1A00:2")], [vec![2], vec![8, 2, 0, 0x60]]);
    assert_eq!(bench.read("1800:3"), refused(Abort::NO_SUBINDEX));
    assert_eq!(bench.read("1A00:3"), refused(Abort::NO_SUBINDEX));
}

#[test]
fn the_event_timer_is_what_it_is_set_to() {
    let mut bench = Bench::up();
    bench.write("1800:5", &10u16.to_le_bytes()).unwrap();
    bench.take();
    bench.pass(100);
    assert_eq!(bench.take().len(), 10);
    bench.write("1800:5", &[0, 0]).unwrap();
    bench.take();
    bench.pass(1000);
    assert!(bench.take().is_empty());
    let (now, mut out) = (bench.now, DeviceOutbox::default());
    bench.device.set_inputs(now, 1, &mut out);
    assert_eq!(out.frames[0].to_string(), "184#0100", "a change is sent all the same");
}

#[test]
fn synchronous_process_data_waits_for_its_sync() {
    let mut bench = Bench::up();
    bench.write("1800:2", &[2]).unwrap();
    bench.write("1400:2", &[0]).unwrap();
    bench.pass(100);
    bench.take();
    let (now, mut out) = (bench.now, DeviceOutbox::default());
    bench.device.set_inputs(now, 1, &mut out);
    assert!(out.frames.is_empty());
    bench.hear("204#0100");
    assert_eq!(bench.device.outputs(), 0);
    bench.hear("080#");
    assert_eq!((bench.device.outputs(), bench.take()), (1, vec![]));
    bench.hear("080#");
    assert_eq!(bench.take(), ["184#0100"], "every second SYNC");
    // 0: with the next SYNC, if it has changed.
    bench.write("1800:2", &[0]).unwrap();
    bench.hear("080#");
    assert!(bench.take().is_empty());
    bench.device.set_inputs(now, 3, &mut out);
    bench.hear("080#");
    assert_eq!(bench.take(), ["184#0300"]);
    // What waits is dropped with the operational state.
    bench.hear("204#0000");
    bench.hear("000#8004");
    bench.hear("000#0104");
    bench.hear("080#");
    assert_eq!(bench.device.outputs(), 0);
    for code in [241, 251, 252, 253] {
        assert_eq!(bench.write("1800:2", &[code]), refused(Abort::VALUE));
    }
}

#[test]
fn the_mapping_can_be_written_as_it_is_and_not_otherwise() {
    let mut bench = Bench::up();
    let disabled = 0x8000_0184u32.to_le_bytes();
    assert_eq!(bench.write("1A00:0", &[0]), refused(Abort::ACCESS), "not while it exists");
    bench.write("1800:1", &disabled).unwrap();
    bench.take();
    bench.pass(500);
    assert!(bench.take().is_empty(), "it does not exist");
    assert_eq!(bench.write("1A00:1", &[8, 1, 0, 0x60]), refused(Abort::ACCESS), "not while it counts");
    bench.write("1A00:0", &[0]).unwrap();
    bench.write("1A00:1", &[8, 1, 0, 0x60]).unwrap();
    assert_eq!(bench.write("1A00:2", &[8, 1, 0, 0x60]), refused(Abort::NOT_MAPPABLE));
    assert_eq!(bench.write("1A00:0", &[1]), refused(Abort::VALUE));
    assert_eq!(bench.write("1A00:0", &[9]), refused(Abort::PDO_LENGTH));
    bench.write("1A00:0", &[2]).unwrap();
    assert_eq!(bench.write("1800:1", &0x185u32.to_le_bytes()), refused(Abort::VALUE));
    bench.write("1800:1", &0x184u32.to_le_bytes()).unwrap();
    assert_eq!(bench.take(), ["184#0000"]);
    // The same for the outputs: what comes while it does not exist is not taken.
    bench.write("1400:1", &0x8000_0204u32.to_le_bytes()).unwrap();
    bench.hear("204#0100");
    assert_eq!(bench.device.outputs(), 0);
}

#[test]
fn a_device_without_inputs_has_no_objects_of_theirs() {
    let now = Tick::from_millis(1000);
    let device = DeviceNode::new(now, NodeId::new(4).unwrap(), 0, 3, &Timing::default());
    let mut bench = Bench { device, now, out: DeviceOutbox::default() };
    bench.pass(20);
    for object in ["1800:0", "1A00:0", "6000:0"] {
        assert_eq!(bench.read(object), refused(Abort::NO_OBJECT), "{object}");
    }
    assert_eq!(bench.read("1600:0").unwrap(), [1]);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Any frames on the device's SDO channel, and then a client that begins properly: it gets its answer.
    #[test]
    fn whatever_was_said_before_the_next_transfer_works(frames in prop::collection::vec(any::<[u8; 8]>(), 0..60)) {
        let mut bench = Bench::new();
        let node = NodeId::new(4).unwrap();
        for mut raw in frames {
            // Neither unplugged nor booted by one of them.
            raw[2] &= 0x3F;
            bench.device.handle(bench.now, &CanopenMessage::SdoRequest { node, raw }.encode(), &mut bench.out);
        }
        // Within a block anything is a segment: there a client that is gone is waited for.
        bench.pass(4000);
        prop_assert_eq!(bench.read("1008").unwrap(), b"Linewright simulated I/O");
    }
}
