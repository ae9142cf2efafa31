//! A small line for tests: two presses that advance and return, one on the coordinator's bus, one on its own, and a
//! console.
//!
//! Each press: input 0 is on in front, 1 at the back, 2 when the advance has failed; output 0 advances, 1 returns.

use std::time::Duration;

use linewright_line::{
    Axis, AxisId, ButtonId, Console, Device, DeviceBus, DeviceKind, HandMode, InputId, Line, MaterialFlow, Motion,
    MotionSignals, OpId, Operation, OperationModule, OutputId, Owner, Panel, Station, StationId, TaskOrderSource,
    Timing,
};

pub const PRESS: StationId = StationId(0);
pub const OTHER: StationId = StationId(1);
pub const RAM: AxisId = AxisId(0);
pub const ADVANCE: OpId = OpId(0);

pub const FRONT: u128 = 0b001;
pub const BACK: u128 = 0b010;
pub const FAILED: u128 = 0b100;
pub const FORWARD: u128 = 0b01;
pub const RETURN: u128 = 0b10;

/// Time of the ram's way of 80 mm, forward.
pub const FORWARD_TIME: Duration = Duration::from_millis(200);
/// And back.
const RETURN_TIME: Duration = Duration::from_millis(100);

/// One press as a text, without its device: valves `forward` and `back`, switches `front` and `rear`.
pub const PRESSING: &str = r#"
name = "pressing"
buttons = ["PB_1", "PB_2"]

[[station]]
name = "press"
home = "return"
axes = { ram = 0.0 }

[[station.operation]]
name = "advance"
module = "R"
moves = { axis = "ram", from = 0, to = 80 }
duration_s = 0.2
watchdog_s = 1.0
normal = { actuator = "forward", complete = "front" }
recovery = { actuator = "back", complete = "rear" }
hand = { type = 6, forward = "PB_1", back = "PB_2", next = "PB_2" }

[[station.operation]]
name = "return"
module = "R"
moves = { axis = "ram", from = 80, to = 0 }
duration_s = 0.2
watchdog_s = 1.0
normal = { actuator = "back", complete = "rear" }
recovery = { actuator = "forward", complete = "front" }
hand = { type = 6, forward = "PB_2", back = "PB_1", next = "PB_1" }
"#;

fn operation(name: &str, from: f64, to: f64) -> Operation {
    let forward = to > from;
    let signals = |forward: bool| MotionSignals {
        actuator: OutputId(u16::from(!forward)),
        complete: InputId(u16::from(!forward)),
        fault: forward.then_some(InputId(2)),
        lamp: None,
    };
    let time = |forward| if forward { FORWARD_TIME } else { RETURN_TIME };
    Operation {
        name: name.to_owned(),
        module: OperationModule::Reversible {
            recovery: signals(!forward),
            recovery_duration: time(!forward),
            recovery_watchdog: Duration::from_secs(1),
        },
        duration: time(forward),
        watchdog: Duration::from_secs(1),
        motion: Motion { axis: RAM, from, to },
        normal: signals(forward),
        waits: Vec::new(),
        waits_code: 0,
        result: None,
        hand: HandMode::Sequence { forward: ButtonId(0) },
    }
}

fn station(name: &str, bus: DeviceBus) -> Station {
    Station {
        name: name.to_owned(),
        title: name.to_owned(),
        operations: vec![operation("advance", 0.0, 80.0), operation("return", 80.0, 0.0)],
        home: OpId(1),
        steps: vec![vec![OpId(0)], vec![OpId(1)]],
        rests: Vec::new(),
        tasks: Vec::new(),
        order_source: TaskOrderSource::Coordinator,
        axes: vec![Axis { name: "ram".to_owned(), home: 0.0, index: None }],
        inputs: ["front", "back", "failed", "selector"].map(str::to_owned).to_vec(),
        outputs: ["forward", "return"].map(str::to_owned).to_vec(),
        panel: Panel { manual: Some(InputId(3)), advance: None, retract: None },
        bus,
    }
}

fn device(name: &str, node_id: u8, owner: Owner, bus: DeviceBus, inputs: u16, outputs: u16) -> Device {
    Device {
        name: name.to_owned(),
        owner,
        bus,
        kind: DeviceKind::io(
            node_id,
            (0..inputs).map(|i| Some(InputId(i))).collect(),
            (0..outputs).map(|i| Some(OutputId(i))).collect(),
        ),
    }
}

/// The line. Press 1 is node 4, the console node 10, on the coordinator's bus; press 2 is node 4 on `press2`.
pub fn line() -> Line {
    let own = || DeviceBus::Own("press2".to_owned());
    Line {
        name: "test".to_owned(),
        title: "Test".to_owned(),
        stations: vec![station("press1", DeviceBus::Line), station("press2", own())],
        arrows: Vec::new(),
        conflicts: Vec::new(),
        devices: vec![
            device("press1-io", 4, Owner::Station(PRESS), DeviceBus::Line, 4, 2),
            device("press2-io", 4, Owner::Station(OTHER), own(), 4, 2),
            device("console-io", 10, Owner::Console, DeviceBus::Line, 1, 1),
        ],
        buttons: Vec::new(),
        console: Console {
            inputs: vec!["start".to_owned()],
            outputs: vec!["auto lamp".to_owned()],
            start: Some(InputId(0)),
            ..Console::default()
        },
        timing: Timing::default(),
        handling: MaterialFlow::default(),
    }
}
