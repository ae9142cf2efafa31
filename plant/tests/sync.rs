//! Process data that wait for SYNC, manager and device together: they come and act with it, and when the device hears
//! none its outputs go off although every heartbeat still comes.

use std::time::Duration;

use linewright_canopen::{BusEvent, BusOutbox, Frame, Manager, NodeId};
use linewright_line::{Device, DeviceBus, Owner, Tick, Timing, Transmission};
use linewright_plant::{DeviceNode, DeviceOutbox};

const OWNER: Owner = Owner::Station(crate::common::PRESS);

struct Pair {
    now: Tick,
    manager: Manager,
    device: DeviceNode,
    /// SYNC does not get through to the device.
    deaf: bool,
    /// Everything on the wire, with its time.
    wire: Vec<(Tick, String)>,
    events: Vec<BusEvent>,
}

impl Pair {
    /// Operational, with inputs on every second SYNC and outputs on each. `watches` is whether the device itself knows
    /// what SYNC is worth.
    fn up(watches: bool) -> Self {
        let timing = Timing { sync: Some(Duration::from_millis(10)), ..Timing::default() };
        let mut device: Device = crate::common::line().devices[0].clone();
        assert_eq!(device.bus, DeviceBus::Line);
        device.canopen_mut().expect("CANopen").setup.transmission = Transmission { inputs: Some(2), outputs: Some(1) };
        let node = device.node_id().and_then(NodeId::new).unwrap();
        let now = Tick::from_millis(100);
        let mut pair = Pair {
            now,
            manager: Manager::new([&device], timing).unwrap(),
            device: DeviceNode::new(now, node, device.input_bits().len(), device.output_bits().len(), &timing),
            deaf: false,
            wire: Vec::new(),
            events: Vec::new(),
        };
        // Half of it the manager listens for another one.
        pair.run(400);
        assert!(pair.manager.inputs(pair.now, OWNER).valid);
        if !watches {
            let raw = "604#2306100000000000".parse().unwrap();
            pair.device.handle(pair.now, &raw, &mut DeviceOutbox::default());
        }
        pair
    }

    fn run(&mut self, millis: u64) {
        for _ in 0..millis {
            self.now = self.now + Duration::from_millis(1);
            let (mut out, mut own) = (BusOutbox::default(), DeviceOutbox::default());
            self.device.poll(self.now, &mut own);
            self.manager.poll(self.now, &mut out);
            self.carry(out, own);
        }
    }

    fn set(&mut self, image: u128) {
        let mut out = BusOutbox::default();
        self.manager.set_outputs(self.now, OWNER, image, &mut out);
        self.carry(out, DeviceOutbox::default());
    }

    fn carry(&mut self, mut out: BusOutbox, mut own: DeviceOutbox) {
        while !out.frames.is_empty() || !own.frames.is_empty() {
            let (to_device, to_manager) = (std::mem::take(&mut out.frames), std::mem::take(&mut own.frames));
            let all = to_device.iter().chain(&to_manager);
            self.wire.extend(all.map(|frame| (self.now, frame.to_string())));
            for frame in to_device.iter().filter(|frame| !self.deaf || frame.cob_id() != Some(0x80)) {
                self.device.handle(self.now, frame, &mut own);
            }
            for frame in &to_manager {
                self.manager.handle(self.now, frame, &mut out);
            }
        }
        self.events.append(&mut out.events);
    }

    fn heard(&self, id: &str) -> Vec<Tick> {
        self.wire.iter().filter(|(_, frame)| frame.starts_with(id)).map(|(at, _)| *at).collect()
    }
}

fn gaps(moments: &[Tick]) -> Vec<u64> {
    moments.windows(2).map(|pair| pair[1].since(pair[0]).as_millis() as u64).collect()
}

#[test]
fn inputs_come_and_outputs_act_with_sync() {
    let mut pair = Pair::up(true);
    pair.wire.clear();
    pair.run(200);
    let syncs = pair.heard("080#");
    assert_eq!((syncs.len(), gaps(&syncs)), (20, vec![10; 19]));
    assert_eq!(gaps(&pair.heard("184#")), vec![20; 9]);
    // Just after a SYNC: what is set now acts with the next.
    while pair.heard("080#").last() != Some(&pair.now) {
        pair.run(1);
    }
    pair.run(1);
    pair.set(crate::common::FORWARD);
    assert_eq!(pair.device.outputs(), 0);
    pair.run(8);
    assert_eq!(pair.device.outputs(), 0);
    pair.run(1);
    assert_eq!(pair.device.outputs(), 1);
}

#[test]
fn a_device_that_knows_how_often_sync_comes_lets_go_when_it_stops() {
    let mut pair = Pair::up(true);
    pair.set(crate::common::FORWARD);
    pair.run(20);
    assert_eq!(pair.device.outputs(), 1);
    pair.deaf = true;
    pair.run(31);
    assert_eq!(pair.device.outputs(), 0);
    pair.run(50);
    assert!(!pair.manager.inputs(pair.now, OWNER).valid, "its heartbeat says what it did");
}

#[test]
fn a_device_that_does_not_is_stopped_by_the_manager_and_comes_back_when_sync_does() {
    let mut pair = Pair::up(false);
    pair.set(crate::common::FORWARD);
    pair.run(20);
    pair.deaf = true;
    pair.events.clear();
    pair.run(150);
    assert_eq!(pair.device.outputs(), 1, "nothing else would make it let go");
    pair.run(80);
    assert_eq!(pair.device.outputs(), 0);
    let said: Vec<String> = pair.events.iter().map(BusEvent::to_string).collect();
    assert!(said.contains(&"node 4 hears no SYNC: its inputs have not come for 200 ms".to_owned()), "{said:?}");
    let trouble: Vec<String> = pair.manager.trouble(pair.now, OWNER).collect();
    assert!(trouble[0].starts_with("press1-io (node 04h): it hears no SYNC (080h)"), "{trouble:?}");
    // As long as that lasts nothing it is sent energises it.
    for _ in 0..200 {
        pair.set(crate::common::FORWARD);
        pair.run(10);
        assert_eq!(pair.device.outputs(), 0);
        assert!(!pair.manager.inputs(pair.now, OWNER).valid || pair.device.outputs() == 0);
    }
    // By now it has lost SYNC three times in a row, and is looked at every five seconds.
    pair.deaf = false;
    pair.run(6000);
    assert!(pair.manager.inputs(pair.now, OWNER).valid, "{:?}", pair.manager.trouble(pair.now, OWNER).next());
    pair.set(crate::common::FORWARD);
    pair.run(20);
    assert_eq!(pair.device.outputs(), 1);
}

#[test]
fn frames_are_those_of_the_standard() {
    let frame: Frame = "080#".parse().unwrap();
    let pair = Pair::up(true);
    assert!(pair.wire.iter().any(|(_, text)| *text == frame.to_string()));
    let written: Vec<&str> =
        pair.wire.iter().map(|(_, text)| text.as_str()).filter(|text| text.starts_with("604#2")).collect();
    // 1006h in microseconds, then the two transmission types.
    assert_eq!(written[..3], ["604#2306100010270000", "604#2F00140201000000", "604#2F00180202000000"]);
}

#[test]
fn a_device_that_loses_sync_again_and_again_is_left_stopped_and_tried_now_and_then() {
    let mut pair = Pair::up(false);
    pair.set(crate::common::FORWARD);
    pair.run(20);
    pair.deaf = true;
    (pair.events, pair.wire) = (Vec::new(), Vec::new());
    pair.run(20_000);
    let lost = pair.events.iter().filter(|event| matches!(event, BusEvent::NoSync { .. })).count();
    assert!((5..=7).contains(&lost), "three times, and then every five seconds: {lost}");
    let stops = pair.wire.iter().filter(|(_, frame)| frame == "000#0204").count();
    assert!((lost..=lost + 2).contains(&stops), "one order each: {stops}");
    let refused = pair.events.iter().filter(|event| matches!(event, BusEvent::BootFailed { .. })).count();
    assert_eq!(refused, 1, "said once");
    // In between it is at rest, and says why. Whoever mends it need do nothing else.
    while pair.events.last().is_none_or(|event| !matches!(event, BusEvent::NoSync { .. })) {
        pair.events.clear();
        pair.run(1);
    }
    pair.run(300);
    assert_eq!(pair.device.outputs(), 0);
    let trouble: Vec<String> = pair.manager.trouble(pair.now, OWNER).collect();
    assert!(trouble[0].contains("not started: it has lost SYNC (080h)"), "{trouble:?}");
    pair.deaf = false;
    pair.run(8000);
    assert!(pair.manager.inputs(pair.now, OWNER).valid);
    // After a while it may lose it three times again.
    pair.deaf = true;
    pair.events.clear();
    pair.run(1000);
    assert!(!pair.events.iter().any(|event| matches!(event, BusEvent::BootFailed { .. })), "{:?}", pair.events);
}
