//! Devices while a line runs: through ROS 2 an object is read, the state is seen, and a reset stops one station alone; and
//! a device fails by the command `fail` until it is repaired.
//!
//! ```text
//!   auto ── nmt_reset_node in mid-motion ──▶ devices lost, by name ── booted again ── manual, advance ──▶ auto
//!        ── fail … identity ──▶ another product, by name ── fail … clear ──▶ booted again ──▶ auto
//! ```

use std::time::{Duration, Instant};

use linewright_msgs::{
    Byte, CORead, COReadID, COWrite, CoReadIdRequest, CoReadRequest, CoReadResponse, CoWriteRequest, DiagnosticArray,
    DiagnosticStatus, RosMessage, RosService, StationState, Text, Trigger, TriggerRequest,
};
use linewright_node_shell::{Caller, Mapping, Participant, RosArgs, RosNode, Subscription, qos};
use tokio::runtime::Runtime;

use crate::support::operator::Operator;
use crate::support::rig::{BUS, Rig, line};
use crate::support::{PATIENCE, pause};

/// A technician with a node of his own.
struct Technician {
    runtime: Runtime,
    node: RosNode,
}

impl Technician {
    fn join(rig: &Rig) -> Self {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
        let args = RosArgs { domain_id: rig.domain(), ..RosArgs::default() };
        let participant = Participant::open(&args).expect("a participant");
        Technician { runtime, node: participant.node("/transfer_line", "technician").expect("a node") }
    }

    /// Opens a client; discovery takes a moment.
    fn caller<S: RosService>(&mut self, service: &str) -> Caller<S> {
        let caller = self.node.caller(service, Mapping::Enhanced).expect("a service");
        pause(500);
        caller
    }

    /// Repeats a request until it is answered: one sent before discovery is lost.
    fn call<S: RosService>(&mut self, caller: &Caller<S>, request: &S::Request) -> S::Response {
        let end = Instant::now() + PATIENCE;
        loop {
            let answer = self.runtime.block_on(caller.call(request.clone(), Duration::from_secs(2)));
            match answer {
                Ok(response) => return response,
                Err(error) => assert!(Instant::now() < end, "{error}"),
            }
        }
    }

    fn ask<S: RosService>(&mut self, service: &str, request: &S::Request) -> S::Response {
        let caller = self.caller::<S>(service);
        self.call(&caller, request)
    }

    /// The first message for which this holds.
    fn hear<T: RosMessage>(&mut self, topic: &mut Subscription<T>, holds: impl Fn(&T) -> bool) -> T {
        let heard = async {
            loop {
                let (message, _) = topic.recv().await.expect("the middleware works");
                if holds(&message) {
                    return message;
                }
            }
        };
        self.runtime.block_on(async { tokio::time::timeout(PATIENCE, heard).await }).expect("heard in time")
    }
}

#[test]
fn a_device_is_asked_seen_and_reset_while_the_line_runs() {
    let (node, product) = ("node = 0x11\n", "node = 0x11\nidentity = { product = 401 }\n");
    let text = line(1.0);
    assert!(text.contains(node));
    let mut rig = Rig::new(&text.replace(node, product));
    let operator = rig.in_auto();
    let mut technician = Technician::join(&rig);
    let mut states =
        technician.node.subscription::<Text>("transfer_io/nmt_state", qos::latched_state()).expect("topic");
    let mut reports = technician.node.subscription::<DiagnosticArray>("/diagnostics", qos::event()).expect("topic");

    asked_while_it_works(&mut technician);
    technician.hear(&mut states, |state| state.data == "START");
    let is = |level: Byte| {
        move |array: &DiagnosticArray| {
            array.status.iter().any(|s| s.name == "coordinator: transfer io" && s.level == level)
        }
    };
    let report = technician.hear(&mut reports, is(DiagnosticStatus::OK));
    assert!(report.status.iter().all(|s| s.hardware_id.starts_with("CANopen node ")), "{report:?}");
    operator.cycles(1);

    // In the middle of the bar's longest motion.
    let reset = technician.caller::<Trigger>("transfer_io/nmt_reset_node");
    rig.eye.wait("the bar stands", |seen| !seen.output("transfer", "advance"));
    rig.eye.wait("the bar advances", |seen| seen.output("transfer", "advance"));
    let answer = technician.call(&reset, &TriggerRequest::default());
    assert!(answer.success, "{}", answer.message);
    let by_name = "I/O devices lost (transfer io (node 11h): ";
    operator.wait("the station says which device and why", |heard| heard.station("transfer").fault.contains(by_name));
    technician.hear(&mut states, |state| state.data == "START");
    let lost_once = |s: &DiagnosticStatus| s.values.iter().any(|value| value.key == "losses" && value.value == "1");
    let back = |array: &DiagnosticArray| {
        is(DiagnosticStatus::OK)(array) && array.status.iter().any(|s| s.name.ends_with("transfer io") && lost_once(s))
    };
    let report = technician.hear(&mut reports, back);
    assert_eq!(report.status.iter().filter(|s| lost_once(s)).count(), 1, "one device, once: {report:?}");
    let refusal = operator.refused("auto");
    assert!(refusal.contains("transfer: operation incomplete"), "{refusal}");
    operator.wait("its devices are back", |heard| heard.all(|state| state.devices_valid));
    operator.recover();
    operator.cycles(1);
    is_another_device(&rig, &operator);
    operator.cycles(1);
    operator.go_home();
    let report = rig.ends_well(0);
    assert_eq!(report["stations"]["transfer"]["faults"], 1, "{report}");
    assert!(report["stations"]["transfer"]["fault"].as_str().is_some_and(|text| text.contains(by_name)), "{report}");
    assert_eq!(report["stations"]["clamp_1"]["faults"], 0, "{report}");
}

/// A device with another identity keeps its station waiting, with the reason in its state. With its own identity again it is
/// booted by the manager; no process is restarted.
fn is_another_device(rig: &Rig, operator: &Operator) {
    let fail = |what: &str| {
        let output = rig.command(&["fail"], &["transfer", what, "--device", "transfer io", "--bus", BUS]).output();
        let output = output.expect("the command starts");
        assert!(output.status.success(), "{output:?}");
    };
    fail("identity");
    operator.wait("another product", |heard| {
        let said = "its product code (object 1018h:02) is 0000FFFFh";
        heard.station("transfer").blocked_by.iter().any(|text| text.contains("transfer io") && text.contains(said))
    });
    fail("clear");
    operator.wait("its devices are back", |heard| heard.all(|state| state.devices_valid));
    if !operator.heard().in_mode(StationState::MODE_AUTO) {
        operator.recover();
    }
}

/// Objects are read, by device and by node id; what the line rests on is not written.
fn asked_while_it_works(technician: &mut Technician) {
    let vendor = CoReadRequest { index: 0x1018, subindex: 1 };
    let answer = technician.ask::<CORead>("clamp_1_io/sdo_read", &vendor);
    assert_eq!(answer, CoReadResponse { success: true, data: 0 });
    let product = CoReadIdRequest { nodeid: 0x21, index: 0x1018, subindex: 2, canopen_datatype: 7 };
    let answer = technician.ask::<COReadID>("coordinator/sdo_read", &product);
    assert_eq!((answer.success, answer.data), (true, 401));
    let none = CoReadRequest { index: 0x4321, subindex: 0 };
    let answer = technician.ask::<CORead>("clamp_1_io/sdo_read", &none);
    assert_eq!(answer, CoReadResponse { success: false, data: 0x0602_0000 }, "no such object");
    let outputs = CoWriteRequest { index: 0x6200, subindex: 1, data: 0xFF };
    assert!(!technician.ask::<COWrite>("clamp_1_io/sdo_write", &outputs).success, "outputs belong to the station");
    // A fault of the simulated device, of one byte: written as such, and taken back.
    for data in [1, 0] {
        let finger = CoWriteRequest { index: 0x5F01, subindex: 8, data: 2 - data };
        assert!(technician.ask::<COWrite>("clamp_1_io/sdo_write", &finger).success);
    }
}
