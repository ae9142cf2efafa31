//! An I/O device by itself: its states, its outputs without a manager, and its objects, read and written with the SDO client
//! as a manager would.

use linewright_canopen::codec::NmtState;
use linewright_canopen::sdo::{Abort, ObjectId, SdoClient, TransferMode, TransferOptions};
use linewright_canopen::{CanopenMessage, Frame, NodeId};
use linewright_line::{Tick, Timing};
use linewright_plant::{DeviceNode, DeviceOutbox};
use proptest::prelude::*;

use crate::alone::{Alone, refused};

/// A device with ten inputs and outputs.
fn device(now: Tick, node: NodeId) -> Box<DeviceNode> {
    Box::new(DeviceNode::new(now, node, 10, 10, &Timing::default()))
}

/// One with four inputs and two outputs.
fn small(now: Tick, node: NodeId) -> Box<DeviceNode> {
    Box::new(DeviceNode::new(now, node, 4, 2, &Timing::default()))
}

fn booted() -> Alone<Box<DeviceNode>> {
    Alone::booted(4, device)
}

fn started() -> Alone<Box<DeviceNode>> {
    Alone::started(4, device)
}

/// Gives it inputs; what it sends at once.
fn set_inputs(bench: &mut Alone<Box<DeviceNode>>, inputs: u64) -> Vec<String> {
    let mut out = DeviceOutbox::default();
    bench.device.set_inputs(bench.now, inputs, &mut out);
    out.frames.iter().map(Frame::to_string).collect()
}

#[test]
fn it_says_who_it_is_in_segments_and_in_blocks() {
    let mut bench = booted();
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
    let mut bench = started();
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
    assert!(bench.news().contains(&"084#3081110000000000".to_owned()));
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
        let mut bench = started();
        bench.write("1029:1", &[code]).unwrap();
        assert_eq!(bench.read("1029:1").unwrap(), [code]);
        bench.hear("77F#05");
        bench.hear("204#FF03");
        bench.pass(200);
        assert_eq!(bench.device.outputs(), outputs);
        let frames = bench.take();
        assert!(frames.contains(&"084#3081110000000000".to_owned()), "{frames:?}");
        bench.pass(50);
        let frames = bench.take();
        assert!(frames.iter().any(|frame| frame == state), "{code}: {frames:?}");
    }
    assert_eq!(started().write("1029:1", &[3]), refused(Abort::VALUE));
}

#[test]
fn pdo_parameters_are_readable() {
    let mut bench = booted();
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
    let mut bench = started();
    bench.write("1800:5", &10u16.to_le_bytes()).unwrap();
    bench.news();
    bench.pass(100);
    assert_eq!(bench.news().len(), 10);
    bench.write("1800:5", &[0, 0]).unwrap();
    bench.news();
    bench.pass(1000);
    assert!(bench.news().is_empty());
    assert_eq!(set_inputs(&mut bench, 1), ["184#0100"], "a change is sent all the same");
}

#[test]
fn synchronous_process_data_waits_for_its_sync() {
    let mut bench = started();
    bench.write("1800:2", &[2]).unwrap();
    bench.write("1400:2", &[0]).unwrap();
    bench.pass(100);
    bench.news();
    assert!(set_inputs(&mut bench, 1).is_empty());
    bench.hear("204#0100");
    assert_eq!(bench.device.outputs(), 0);
    bench.hear("080#");
    assert_eq!((bench.device.outputs(), bench.news()), (1, vec![]));
    bench.hear("080#");
    assert_eq!(bench.news(), ["184#0100"], "every second SYNC");
    // 0: with the next SYNC, if it has changed.
    bench.write("1800:2", &[0]).unwrap();
    bench.hear("080#");
    assert!(bench.news().is_empty());
    assert!(set_inputs(&mut bench, 3).is_empty());
    bench.hear("080#");
    assert_eq!(bench.news(), ["184#0300"]);
    // Waiting frames are dropped with the operational state.
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
    let mut bench = started();
    let disabled = 0x8000_0184u32.to_le_bytes();
    assert_eq!(bench.write("1A00:0", &[0]), refused(Abort::ACCESS), "not while it exists");
    bench.write("1800:1", &disabled).unwrap();
    bench.news();
    bench.pass(500);
    assert!(bench.news().is_empty(), "it does not exist");
    assert_eq!(bench.write("1A00:1", &[8, 1, 0, 0x60]), refused(Abort::ACCESS), "not while it counts");
    bench.write("1A00:0", &[0]).unwrap();
    bench.write("1A00:1", &[8, 1, 0, 0x60]).unwrap();
    assert_eq!(bench.write("1A00:2", &[8, 1, 0, 0x60]), refused(Abort::NOT_MAPPABLE));
    assert_eq!(bench.write("1A00:0", &[1]), refused(Abort::VALUE));
    assert_eq!(bench.write("1A00:0", &[9]), refused(Abort::PDO_LENGTH));
    bench.write("1A00:0", &[2]).unwrap();
    assert_eq!(bench.write("1800:1", &0x185u32.to_le_bytes()), refused(Abort::VALUE));
    bench.write("1800:1", &0x184u32.to_le_bytes()).unwrap();
    assert_eq!(bench.news(), ["184#0000"]);
    // The same for the outputs: what comes while it does not exist is not taken.
    bench.write("1400:1", &0x8000_0204u32.to_le_bytes()).unwrap();
    bench.hear("204#0100");
    assert_eq!(bench.device.outputs(), 0);
}

#[test]
fn a_device_without_inputs_has_no_objects_of_theirs() {
    let mut bench = Alone::booted(4, |now, node| Box::new(DeviceNode::new(now, node, 0, 3, &Timing::default())));
    for object in ["1800:0", "1A00:0", "6000:0"] {
        assert_eq!(bench.read(object), refused(Abort::NO_OBJECT), "{object}");
    }
    assert_eq!(bench.read("1600:0").unwrap(), [1]);
}

#[test]
fn outputs_are_taken_in_the_operational_state_only_and_go_off_with_it() {
    for order in ["000#0204", "000#8004", "000#8104", "000#8200"] {
        let mut bench = Alone::booted(4, small);
        bench.hear("204#01");
        assert_eq!(bench.device.outputs(), 0);
        bench.hear("000#0104");
        bench.hear("204#01");
        assert_eq!(bench.device.outputs(), 1);
        bench.hear(order);
        assert_eq!(bench.device.outputs(), 0, "{order}");
        bench.pass(50);
        bench.hear("000#0104");
        assert_eq!(bench.device.outputs(), 0, "{order}: starting again restores nothing");
    }
}

#[test]
fn a_device_that_loses_its_manager_lets_go_and_says_so() {
    let mut bench = Alone::started(4, small);
    bench.hear("77F#05");
    bench.hear("204#01");
    bench.pass(199);
    assert_eq!(bench.device.outputs(), 1);
    bench.take();
    bench.pass(1);
    assert_eq!(bench.device.outputs(), 0);
    assert!(bench.take().contains(&"084#3081110000000000".to_owned()));
    bench.pass(50);
    assert_eq!(bench.take(), ["704#7F"]);
    bench.hear("77F#05");
    assert_eq!(bench.take(), ["084#0000000000000000"]);
}

#[test]
fn a_manager_that_booted_is_a_manager_lost() {
    let mut bench = Alone::started(4, small);
    bench.hear("77F#05");
    bench.hear("204#01");
    bench.hear("77F#00");
    assert_eq!(bench.device.outputs(), 0);
}

#[test]
fn a_watch_that_was_configured_runs_from_then() {
    let mut bench = Alone::started(4, small);
    assert_eq!(bench.ask("604#2316100164007F00"), "584#6016100100000000");
    bench.hear("204#01");
    bench.pass(100);
    assert_eq!(bench.device.outputs(), 0, "100 ms without a heartbeat");
}

#[test]
fn a_silent_device_is_silent_until_it_is_plugged_in_again() {
    let mut bench = Alone::started(4, small);
    bench.hear("77F#05");
    bench.hear("204#01");
    assert_eq!(bench.ask("604#2F005F0001000000"), "584#60005F0000000000");
    bench.pass(100);
    bench.hear("77F#05");
    bench.hear("604#4000100000000000");
    assert!(bench.take().is_empty());
    bench.pass(100);
    assert_eq!(bench.device.outputs(), 0, "it does not hear its manager");
    assert_eq!(bench.ask("604#40055F0000000000"), "584#43055F004C575344", "it is simulated");
    assert_eq!(bench.ask("604#2F005F0000000000"), "584#60005F0000000000");
    bench.pass(50);
    assert!(bench.take().contains(&"704#7F".to_owned()));
}

#[test]
fn a_reboot_is_a_gap_with_outputs_off() {
    let mut bench = Alone::started(4, small);
    bench.hear("204#01");
    bench.hear("604#2F005F0002000000");
    assert_eq!(bench.device.outputs(), 0);
    bench.take();
    bench.hear("204#01");
    bench.pass(20);
    assert_eq!(bench.take(), ["704#00"]);
    assert_eq!(bench.device.outputs(), 0);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Any frames on the device's SDO channel, and then a client that begins properly: it gets its answer.
    #[test]
    fn whatever_was_said_before_the_next_transfer_works(frames in prop::collection::vec(any::<[u8; 8]>(), 0..60)) {
        let mut bench = booted();
        let node = NodeId::new(4).unwrap();
        for mut raw in frames {
            // Neither unplugged nor booted by one of them.
            raw[2] &= 0x3F;
            bench.hear(&CanopenMessage::SdoRequest { node, raw }.encode().to_string());
        }
        // Within a block anything is a segment: there a client that is gone is waited for.
        bench.pass(4000);
        prop_assert_eq!(bench.read("1008").unwrap(), b"Linewright simulated I/O");
    }

    /// Whatever comes over the bus: no panic, outputs only in the operational state, and none for longer than the
    /// timeout after the manager's last heartbeat. (One that never sent any is not watched, as the standard has it.)
    #[test]
    fn whatever_comes_outputs_are_on_only_when_operational(
        frames in prop::collection::vec((0u16..0x800, prop::collection::vec(any::<u8>(), 0..=8), 0u64..60), 1..100),
        known in prop::collection::vec(prop::sample::select(vec![
            "000#0104", "204#01", "204#03", "77F#05", "000#0204", "604#2F005F0001000000", "604#2F005F0000000000",
        ]), 100),
    ) {
        let mut bench = Alone::started(4, small);
        let mut silent = false;
        for ((id, data, millis), known) in frames.into_iter().zip(known) {
            bench.pass(millis);
            bench.hear(&Frame::data_frame(id, &data).unwrap().to_string());
            bench.hear(known);
            match known {
                "604#2F005F0001000000" => silent = true,
                "604#2F005F0000000000" => silent = false,
                "77F#05" if !silent && millis % 4 == 0 => {
                    bench.pass(200);
                    prop_assert_eq!(bench.device.outputs(), 0);
                }
                _ => {}
            }
            prop_assert!(bench.device.state() == NmtState::Operational || bench.device.outputs() == 0);
        }
    }
}
