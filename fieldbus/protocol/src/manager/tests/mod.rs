//! Scenarios, named by what happens on the bus. Frames are written as candump prints them.

mod analogue;
mod boot;
mod crowd;
mod errors;
mod plain;
mod request;
mod rival;
mod trouble;

use linewright_line::{Device, DeviceBus, DeviceKind, InputId, OutputId, StationId};

use super::*;
use crate::codec::Profile;

const DRILL: Owner = Owner::Station(StationId(0));
const CLAMP: Owner = Owner::Station(StationId(1));

/// Node 4 and 5 carry the drill: inputs 0 and 1, outputs 0 (node 4) and 1 (node 5). Node 6 carries the clamp.
fn devices() -> Vec<Device> {
    let device = |name: &str, node_id, owner, bit| Device {
        name: name.to_owned(),
        owner,
        bus: DeviceBus::Line,
        kind: DeviceKind::io(node_id, vec![Some(InputId(bit)), None], vec![Some(OutputId(bit))]),
    };
    vec![device("drill-a", 4, DRILL, 0), device("drill-b", 5, DRILL, 1), device("clamp", 6, CLAMP, 0)]
}

struct ManagerBench {
    manager: Manager,
    now: Tick,
    out: BusOutbox,
}

impl ManagerBench {
    fn new() -> Self {
        ManagerBench::of(&devices())
    }

    /// With these devices, and its time of listening over: the first frames are sent.
    fn of<'a>(devices: impl IntoIterator<Item = &'a Device>) -> Self {
        let mut bench = ManagerBench::listening(devices);
        bench.pass(200);
        bench
    }

    /// It has just begun.
    fn listening<'a>(devices: impl IntoIterator<Item = &'a Device>) -> Self {
        let manager = Manager::new(devices, Timing::default()).unwrap();
        let mut bench = ManagerBench { manager, now: Tick::from_millis(800), out: BusOutbox::default() };
        bench.poll();
        bench
    }

    /// A bench on which every device is up, and what that took is forgotten.
    fn up() -> Self {
        let mut bench = ManagerBench::new();
        for node in [4, 5, 6] {
            bench.bring_up(node);
        }
        bench.take();
        bench
    }

    fn poll(&mut self) {
        self.manager.poll(self.now, &mut self.out);
    }

    fn pass(&mut self, millis: u64) {
        self.now = self.now + Duration::from_millis(millis);
        self.poll();
    }

    /// Lets time pass while these devices send their heartbeats.
    fn pass_with(&mut self, millis: u64, alive: &[u8]) {
        for _ in 0..millis / 50 {
            for node in alive {
                self.hear(&format!("7{node:02X}#05"));
            }
            self.pass(50);
        }
    }

    /// Receives a frame, with room on the bus for all that follows from it.
    fn hear(&mut self, text: &str) {
        self.pace_is_free();
        self.manager.handle(self.now, &text.parse().unwrap(), &mut self.out);
    }

    fn set(&mut self, owner: Owner, image: u128) {
        self.manager.set_outputs(self.now, owner, image, &mut self.out);
    }

    fn bring_up(&mut self, node: u8) {
        self.hear(&format!("7{node:02X}#00"));
        self.configure(node);
        self.hear(&format!("{:03X}#00", 0x180 + u16::from(node)));
    }

    /// Answers the boot: a device of profile 401, which takes every setting and has no error.
    fn configure(&mut self, node: u8) {
        self.configure_to_register(node);
        self.hear(&format!("{:03X}#4F01100000000000", 0x580 + u16::from(node)));
    }

    /// The same as far as the question for its error register.
    fn configure_to_register(&mut self, node: u8) {
        for answer in ["4300100091010300", "6017100000000000", "6016100100000000"] {
            self.hear(&format!("{:03X}#{answer}", 0x580 + u16::from(node)));
        }
        self.takes_error_values(node);
    }

    /// Answers the settings of its outputs, up to eight, for the loss of the manager, as a device that keeps them.
    fn takes_error_values(&mut self, node: u8) {
        let read = ["4F29100100000000", "4F066201FF000000", "4F07620100000000"];
        for (object, read) in ["291001", "066201", "076201"].iter().zip(read) {
            self.hear(&format!("{:03X}#60{object}00000000", 0x580 + u16::from(node)));
            self.hear(&format!("{:03X}#{read}", 0x580 + u16::from(node)));
        }
    }

    /// A node takes each SDO write and keeps it; other objects read 0, one byte. Gives the requests.
    fn keeps_what_it_is_told(&mut self, node: u8) -> Vec<String> {
        let (mut kept, mut asked) = (std::collections::BTreeMap::new(), Vec::new());
        for _ in 0..40 {
            for frame in std::mem::take(&mut self.out.frames) {
                let Ok(CanopenMessage::SdoRequest { node: of, raw }) = CanopenMessage::decode(&frame) else { continue };
                let ([command, low, high, sub, ..], object) = (raw, [raw[1], raw[2], raw[3]]);
                let answer = if command == 0x40 {
                    let [size, data @ ..] = kept.get(&object).copied().unwrap_or([0x2F, 0, 0, 0, 0]);
                    [size & 0x0F | 0x40, low, high, sub, data[0], data[1], data[2], data[3]]
                } else {
                    kept.insert(object, [command, raw[4], raw[5], raw[6], raw[7]]);
                    [0x60, low, high, sub, 0, 0, 0, 0]
                };
                if of.get() == node {
                    asked.push(frame.to_string());
                    self.pace_is_free();
                    let frame = CanopenMessage::SdoResponse { node: of, raw: answer }.encode();
                    self.manager.handle(self.now, &frame, &mut self.out);
                }
            }
        }
        asked
    }

    fn pace_is_free(&mut self) {
        self.manager.pace = SendQueue::new();
    }

    /// The frames sent and events reported since the last call.
    fn take(&mut self) -> (Vec<String>, Vec<BusEvent>) {
        let out = std::mem::take(&mut self.out);
        (out.frames.iter().map(Frame::to_string).collect(), out.events)
    }

    fn frames(&mut self) -> Vec<String> {
        self.take().0
    }

    fn inputs(&self, owner: Owner) -> InputImage {
        self.manager.inputs(self.now, owner)
    }
}

fn node(id: u8) -> NodeId {
    NodeId::new(id).unwrap()
}

#[test]
fn first_of_all_every_output_is_let_go() {
    let mut bench = ManagerBench::new();
    let frames = bench.frames();
    assert_eq!(frames[..5], ["77F#00", "204#00", "205#00", "206#00", "77F#05"]);
    // And each device already there is identified.
    assert_eq!(frames[5..], ["604#4000100000000000", "605#4000100000000000", "606#4000100000000000"]);
}

#[test]
fn a_device_that_boots_is_configured_started_and_then_gets_its_outputs() {
    let mut bench = ManagerBench::new();
    bench.set(CLAMP, 1);
    bench.take();
    bench.hear("706#00");
    assert_eq!(bench.frames(), ["606#4000100000000000"], "what are you?");
    bench.hear("586#4300100091010300");
    assert_eq!(bench.frames(), ["606#2B17100032000000"], "a heartbeat every 50 ms");
    bench.hear("586#6017100000000000");
    assert_eq!(bench.frames(), ["606#23161001C8007F00"], "watch node 127, 200 ms");
    bench.hear("586#6016100100000000");
    assert_eq!(bench.frames(), ["606#2F29100100000000"], "without it, to pre-operational");
    bench.hear("586#6029100100000000");
    assert_eq!(bench.frames(), ["606#4029100100000000"], "has it kept that?");
    bench.hear("586#4F29100100000000");
    assert_eq!(bench.frames(), ["606#2F066201FF000000"], "outputs 1 to 8 take their error values");
    bench.hear("586#6006620100000000");
    assert_eq!(bench.frames(), ["606#4006620100000000"]);
    bench.hear("586#4F06620101000000");
    assert_eq!(bench.frames(), ["606#2F07620100000000"], "it has one output; the error value is off");
    bench.hear("586#6007620100000000");
    assert_eq!(bench.frames(), ["606#4007620100000000"]);
    bench.hear("586#4F076201FE000000");
    assert_eq!(bench.frames(), ["606#4001100000000000"], "does an error stand?");
    bench.hear("586#4F01100000000000");
    assert_eq!(bench.frames(), ["000#0106"]);
    bench.hear("706#7F");
    assert!(bench.frames().is_empty(), "not operational yet");
    bench.hear("186#01");
    let (frames, events) = bench.take();
    assert_eq!(frames, ["206#01"]);
    assert_eq!(events, [BusEvent::DeviceUp { node: node(6) }, BusEvent::InputsChanged { owner: CLAMP }]);
    let inputs = bench.inputs(CLAMP);
    assert!(inputs.valid && inputs.bits == 1);
}

#[test]
fn inputs_need_every_device_of_their_owner() {
    let mut bench = ManagerBench::new();
    bench.bring_up(4);
    assert!(!bench.inputs(DRILL).valid);
    bench.bring_up(5);
    assert!(bench.inputs(DRILL).valid);
    bench.hear("185#03");
    assert_eq!(bench.inputs(DRILL).bits, 0b10, "bit 1 of the device carries nothing");
    assert!(!bench.inputs(Owner::Console).valid, "an owner without devices knows nothing");
}

#[test]
fn outputs_are_sent_on_change_and_refreshed() {
    let mut bench = ManagerBench::up();
    bench.set(DRILL, 0b01);
    assert_eq!(bench.frames(), ["204#01"]);
    bench.set(DRILL, 0b01);
    assert!(bench.frames().is_empty());
    bench.pass(50);
    let frames = bench.frames();
    assert!(frames.contains(&"204#01".to_owned()) && frames.contains(&"205#00".to_owned()), "{frames:?}");
}

#[test]
fn a_silent_device_is_lost_and_takes_its_owners_outputs_along() {
    let mut bench = ManagerBench::up();
    bench.set(DRILL, 0b11);
    bench.set(CLAMP, 1);
    bench.take();
    bench.pass_with(200, &[5, 6]);
    let (frames, events) = bench.take();
    let silent_for = Duration::from_millis(200);
    assert!(events.contains(&BusEvent::DeviceLost { node: node(4), silent_for }), "{events:?}");
    assert_eq!(frames.iter().rfind(|f| f.starts_with("205")).unwrap(), "205#00");
    assert_eq!(frames.iter().rfind(|f| f.starts_with("206")).unwrap(), "206#01", "the clamp is not concerned");
    let inputs = bench.inputs(DRILL);
    assert!(!inputs.valid && inputs.losses == 1);
    // Outputs that the controller sets after the loss go to the device that is left.
    bench.set(DRILL, 0b10);
    assert_eq!(bench.frames(), ["205#01"]);
}

#[test]
fn a_device_that_rebooted_gets_only_what_was_set_since_and_only_when_operational() {
    let mut bench = ManagerBench::up();
    bench.set(CLAMP, 1);
    bench.take();
    bench.hear("706#00");
    assert_eq!(bench.take().1, [BusEvent::DeviceRebooted { node: node(6) }, BusEvent::InputsChanged { owner: CLAMP }]);
    bench.configure(6);
    assert!(!bench.frames().iter().any(|f| f.starts_with("206")));
    bench.hear("706#05");
    assert_eq!(bench.frames(), ["206#00"], "the image from before the reboot is forgotten");
    assert!(!bench.inputs(CLAMP).valid, "its inputs have not been heard since it booted");
    bench.hear("186#00");
    assert!(bench.inputs(CLAMP).valid);
    bench.set(CLAMP, 1);
    assert_eq!(bench.frames(), ["206#01"]);
}

#[test]
fn a_device_that_falls_back_is_configured_and_started_again_a_stopped_one_is_left_alone() {
    let mut bench = ManagerBench::up();
    bench.hear("706#7F");
    let (frames, events) = bench.take();
    assert_eq!(frames, ["606#4000100000000000"], "it may have booted unheard: never started as it is");
    assert_eq!(events[0], BusEvent::DeviceLeft { node: node(6), state: NmtState::PreOperational });
    bench.configure(6);
    assert_eq!(bench.take().0.last().map(String::as_str), Some("000#0106"));
    bench.hear("706#05");
    bench.take();
    bench.hear("706#04");
    assert!(bench.frames().is_empty());
    let is = bench.manager.explain(bench.now, node(6)).unwrap();
    assert_eq!(is, "stopped by somebody else, and left so; its heartbeat came 0 ms ago");
    bench.hear("706#05");
    assert_eq!(bench.take().1, [BusEvent::DeviceUp { node: node(6) }]);
}

#[test]
fn a_device_that_lost_the_manager_has_no_outputs_until_it_is_operational_again() {
    let mut bench = ManagerBench::up();
    bench.set(CLAMP, 1);
    bench.take();
    bench.hear("086#3081110000000000");
    assert!(!bench.inputs(CLAMP).valid);
    assert_eq!(bench.frames(), ["606#4000100000000000"]);
    bench.configure(6);
    assert_eq!(bench.frames().last().map(String::as_str), Some("000#0106"));
    bench.hear("706#05");
    assert_eq!(bench.frames(), ["206#00"]);
}

#[test]
fn an_emergency_is_told_by_the_table_of_the_device() {
    let mut bench = ManagerBench::up();
    bench.hear("086#2023010000000000");
    let said = bench.take().1[0].to_string();
    assert_eq!(said, "node 06h reports 2320h (short circuit at outputs), register 01h");
    let drive: Frame = "086#1186010000000000".parse().unwrap();
    let Ok(CanopenMessage::Emergency { emergency, .. }) = CanopenMessage::decode(&drive) else { panic!("{drive}") };
    assert_eq!(emergency.text(Profile::Drive), "8611h (following error), register 01h");
    assert_eq!(emergency.text(Profile::Unknown), "8611h (monitoring), register 01h");
}

#[test]
fn what_is_not_understood_is_ignored_and_counted() {
    let mut bench = ManagerBench::up();
    let cases = [
        ("00000186#01", IgnoreReason::Extended),
        ("186#R", IgnoreReason::Remote),
        ("7FF#00", IgnoreReason::UnknownNode),
        ("7E5#00", IgnoreReason::UnknownCobId),
        ("706#0505", IgnoreReason::Malformed),
        ("187#00", IgnoreReason::UnknownNode),
        ("186#", IgnoreReason::ShortPdo),
    ];
    for (text, reason) in cases.iter().skip(3).chain(&cases[..2]) {
        let before = bench.manager.ignored(*reason);
        bench.hear(text);
        assert_eq!(bench.manager.ignored(*reason), before + 1, "{text}");
        assert!(matches!(bench.take().1[..], [BusEvent::Ignored { .. }]), "{text}");
    }
    bench.hear("20000040#0000000000000000");
    assert_eq!(bench.take().1[0], BusEvent::BusError { class: 0x40 });
    bench.hear("000#0104");
    assert!(bench.take().1.is_empty(), "an order of somebody else is not for the manager");
}

#[test]
fn impossible_devices_are_refused_by_name() {
    let mut devices = devices();
    devices[1].canopen_mut().expect("CANopen").node_id = 4;
    let error = Manager::new(&devices, Timing::default()).map(|_| ()).unwrap_err();
    assert_eq!(error.to_string(), "devices `drill-a` and `drill-b` share node id 04h");
    devices[1].canopen_mut().expect("CANopen").node_id = 127;
    let error = Manager::new(&devices, Timing::default()).map(|_| ()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "device `drill-b` has node id 7Fh; devices have 01h to 7Eh, the manager itself is 7Fh"
    );
}
