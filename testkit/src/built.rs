//! Stations and lines put together in code, for tests that need many or odd ones.
//!
//! The result is not parsed, so nothing here is checked beyond what the builder itself makes sure of: hand types form
//! sequences, buttons follow the sequences, every signal has a bit of its own, and motions chain along one axis each.

use std::time::Duration;

use linewright_line::{
    Arrow, Axis, AxisId, ButtonId, Console, DeviceBus, HandMode, HandType, InputId, Line, MaterialFlow, Motion,
    MotionSignals, OpId, Operation, OperationModule, OutputId, Panel, Station, StationId, TaskOrderSource, Timing,
};

/// One operation to be built.
#[derive(Clone, Debug)]
pub struct Op {
    /// The hand type, 1 to 6. Sequences must be well formed: 1* 2, 3 4* 5 or 6.
    pub hand: u8,
    /// Irreversible, with this recovery path.
    pub path: Option<Vec<usize>>,
    /// Runs beside the operation before it.
    pub beside: bool,
}

/// A reversible operation.
pub fn r(hand: u8) -> Op {
    Op { hand, path: None, beside: false }
}

/// A reversible operation beside the one before it.
pub fn beside(hand: u8) -> Op {
    Op { beside: true, ..r(hand) }
}

/// An irreversible operation.
pub fn i(hand: u8, path: &[usize]) -> Op {
    Op { path: Some(path.to_vec()), ..r(hand) }
}

/// The panel's inputs, in the order manual, advance, return; operations use the bits below.
pub const PANEL: [u16; 3] = [125, 126, 127];

/// The input that completes a motion of an operation; the one above it is the fault input.
pub fn complete_bit(op: OpId, recovery: bool) -> u128 {
    1 << (op.0 * 4 + if recovery { 2 } else { 0 })
}

/// The output that drives a motion of an operation.
pub fn actuator_bit(op: OpId, recovery: bool) -> u128 {
    1 << (op.0 * 2 + u16::from(recovery))
}

/// A station whose sequences use the buttons from `first_button` on, two for each sequence: forward and back. With
/// `share`, a sequence is run back by the button that runs the one after it, as the shipped clamp's two are.
pub fn station(name: &str, home: usize, ops: &[Op], first_button: u16, share: bool) -> Station {
    let hands = hands(ops, first_button, share);
    let operations: Vec<Operation> = ops
        .iter()
        .enumerate()
        .map(|(n, op)| {
            let op_id = OpId::at(n);
            let signals = |recovery: bool| MotionSignals {
                actuator: OutputId(op_id.0 * 2 + u16::from(recovery)),
                complete: InputId(op_id.0 * 4 + if recovery { 2 } else { 0 }),
                fault: Some(InputId(op_id.0 * 4 + if recovery { 3 } else { 1 })),
                lamp: None,
            };
            Operation {
                name: format!("op {n}"),
                module: match &op.path {
                    None => OperationModule::Reversible {
                        recovery: signals(true),
                        recovery_duration: Duration::from_millis(100),
                        recovery_watchdog: Duration::from_millis(1000),
                    },
                    Some(path) => {
                        OperationModule::Irreversible { recovery_path: path.iter().map(|&p| OpId::at(p)).collect() }
                    }
                },
                duration: Duration::from_millis(100),
                watchdog: Duration::from_millis(1000),
                motion: Motion { axis: AxisId(op_id.0), from: 0.0, to: 1.0 },
                normal: signals(false),
                waits: Vec::new(),
                waits_code: 0,
                result: None,
                hand: hands[n],
            }
        })
        .collect();
    let mut steps: Vec<Vec<OpId>> = Vec::new();
    for (n, op) in ops.iter().enumerate() {
        match steps.last_mut() {
            Some(step) if op.beside => step.push(OpId::at(n)),
            _ => steps.push(vec![OpId::at(n)]),
        }
    }
    Station {
        name: name.to_owned(),
        title: name.to_owned(),
        axes: (0..ops.len()).map(|n| Axis { name: format!("axis {n}"), home: 0.0, index: None }).collect(),
        home: OpId::at(home),
        inputs: (0..128).map(|bit| format!("in {bit}")).collect(),
        outputs: (0..128).map(|bit| format!("out {bit}")).collect(),
        panel: Panel {
            manual: Some(InputId(PANEL[0])),
            advance: Some(InputId(PANEL[1])),
            retract: Some(InputId(PANEL[2])),
        },
        bus: DeviceBus::Line,
        operations,
        steps,
        rests: Vec::new(),
        tasks: Vec::new(),
        order_source: TaskOrderSource::Coordinator,
    }
}

fn hands(ops: &[Op], first_button: u16, share: bool) -> Vec<HandMode> {
    // Which sequence each operation belongs to.
    let mut sequence_of = Vec::new();
    let mut sequence = 0;
    for (n, op) in ops.iter().enumerate() {
        let ended = n > 0 && matches!(ops[n - 1].hand, 2 | 5 | 6);
        sequence += u16::from(ended && !op.beside);
        sequence_of.push(sequence);
    }
    let sequences = sequence + 1;
    let forward = |s: u16| ButtonId(first_button + 2 * (s % sequences));
    let back = |s: u16| if share { forward(s + 1) } else { ButtonId(first_button + 2 * s + 1) };
    ops.iter()
        .zip(sequence_of)
        .map(|(op, s)| {
            let (forward, back, next) = (forward(s), back(s), forward(s + 1));
            let kind = HandType::numbered(op.hand.into()).expect("1 to 6");
            kind.with(forward, Some(back), Some(next)).expect("every button is given")
        })
        .collect()
}

/// A line of these stations.
pub fn line(stations: Vec<Station>, arrows: Vec<Arrow>) -> Line {
    Line {
        name: "test_line".to_owned(),
        title: "Test line".to_owned(),
        stations,
        arrows,
        conflicts: Vec::new(),
        devices: Vec::new(),
        buttons: (0..32).map(|n| format!("B{n}")).collect(),
        console: Console::default(),
        timing: Timing::default(),
        handling: MaterialFlow::default(),
    }
}

/// An arrow in all modes.
pub fn arrow(from: (u16, u16), to: (u16, u16), lag: u32) -> Arrow {
    let end = |(station, op)| (StationId(station), OpId(op));
    Arrow { from: end(from), to: end(to), lag, auto: true, manual: true }
}

/// A line of one station.
pub fn alone(home: usize, ops: &[Op]) -> Line {
    line(vec![station("alone", home, ops, 0, false)], Vec::new())
}

/// The shipped transfer line.
pub fn transfer_line() -> Line {
    let text = include_str!("../../launch-config/lines/transfer-line/line.toml");
    linewright_line::parse("line.toml", text).unwrap_or_else(|e| panic!("the shipped line is sound: {e:?}")).line
}
