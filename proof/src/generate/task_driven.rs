//! A random task-driven station: rests in a ring of tasks, more tasks between any of them, and operations that lead
//! from one rest to the next along one axis.
//!
//! Each rest is a position of that axis, so whatever a task does in between, its last operation leads to its rest, and so
//! does every recovery path. Irreversible operations are in tasks that come back, after something that can be taken back.

use std::time::Duration;

use linewright_line::{
    Axis, AxisId, HandMode, InputId, Line, Motion, MotionResult, OpId, OutputId, Parameter, Rest, RestId, Station, Task,
};

use super::station::{button, operation};
use super::{LineShape, Random, empty_station, unjoined};

/// Rests of one station.
const RESTS: std::ops::RangeInclusive<usize> = 1..=3;
/// Tasks beside those that lead round all rests.
const MORE_TASKS: std::ops::RangeInclusive<usize> = 0..=2;
/// Operations of a task.
const OPERATIONS: std::ops::RangeInclusive<usize> = 1..=3;
/// Distance of rests.
const APART: f64 = 100.0;

/// A line of so many task-driven stations; the same for the same seed. Of the shape count the chances.
pub fn task_driven(shape: &LineShape, stations: usize, seed: u64) -> Line {
    let mut random = Random::new(seed);
    let mut buttons = Vec::new();
    let stations: Vec<Station> =
        (0..stations).map(|number| station(shape, number, &mut buttons, &mut random)).collect();
    unjoined(format!("Generated task-driven stations {seed}"), stations, buttons)
}

fn station(shape: &LineShape, number: usize, buttons: &mut Vec<String>, random: &mut Random) -> Station {
    let rests = random.within(&RESTS);
    let mut ways: Vec<(usize, usize)> = (0..rests).map(|rest| (rest, (rest + 1) % rests)).collect();
    for _ in 0..random.within(&MORE_TASKS) {
        ways.push((random.below(rests), random.below(rests)));
    }
    let stands = (0..rests).map(|n| Rest { name: format!("rest {n}"), at: vec![position(n)] }).collect();
    let mut station = empty_station(number, vec![Axis { name: "axis_0".to_owned(), home: 0.0, index: None }], stands);
    for (nth, &(from, to)) in ways.iter().enumerate() {
        task(&mut station, nth, (from, to), shape, buttons, random);
    }
    for nth in 0..station.tasks.len() {
        let task = &station.tasks[nth];
        let last = station.steps[task.steps.end - 1][0];
        let next = station.tasks_from(task.to).next().map(|next| station.first_of(next));
        let forward = next.map(|op| station.operations[op.index()].hand.forward());
        let hand = &mut station.operations[last.index()].hand;
        *hand = match (*hand, forward) {
            (HandMode::SequenceEnd { forward, next: _ }, Some(next)) => HandMode::SequenceEnd { forward, next },
            (HandMode::ReversedEnd { forward, back, next: _ }, Some(next)) => {
                HandMode::ReversedEnd { forward, back, next }
            }
            (HandMode::Single { forward, back, next: _ }, Some(next)) => HandMode::Single { forward, back, next },
            (hand, _) => hand,
        };
    }
    station.home = station.arrival_at(RestId(0)).unwrap_or(OpId(0));
    station
}

fn position(rest: usize) -> f64 {
    rest as f64 * APART
}

fn task(
    station: &mut Station,
    nth: usize,
    (from, to): (usize, usize),
    shape: &LineShape,
    buttons: &mut Vec<String>,
    random: &mut Random,
) {
    let count = random.within(&OPERATIONS).max(if from == to { 2 } else { 1 });
    let first = station.operations.len();
    let mut irreversible = false;
    let mut at = position(from);
    for n in 0..count {
        let last = n + 1 == count;
        // Points of its own between the rests, another one each time.
        let end = if last { position(to) } else { position(from) + 1.0 + (nth * *OPERATIONS.end() + n) as f64 };
        let earlier: Vec<OpId> = (first..first + n).map(OpId::at).filter(|&op| is_reversible(station, op)).collect();
        let path = from == to && n > 0 && !last && random.chance(shape.irreversible);
        let path = path.then(|| earlier.into_iter().rev().collect::<Vec<_>>());
        irreversible |= path.is_some();
        let motion = Motion { axis: AxisId(0), from: at, to: end };
        let hand = HandMode::Sequence { forward: button(buttons, format!("F_{nth}")) };
        let mut op = operation(station, first + n, motion, path, hand, shape, random);
        if random.chance(30) {
            station.inputs.push(format!("W_{}", first + n));
            op.waits = vec![InputId::at(station.inputs.len() - 1)];
            op.waits_code = if random.chance(50) { 1 + (first + n) as u16 } else { 0 };
        }
        if !last && random.chance(20) {
            station.inputs.push(format!("R_{}", first + n));
            let input = InputId::at(station.inputs.len() - 1);
            op.result =
                Some(MotionResult { input, within: Duration::from_millis(500), code: 500 + (first + n) as u16 });
        }
        station.operations.push(op);
        station.steps.push(vec![OpId::at(first + n)]);
        at = end;
    }
    let reversed = !irreversible && random.chance(50);
    for n in 0..count {
        let hand = hand(n, count, nth, reversed, buttons);
        station.operations[first + n].hand = hand;
    }
    let parameters = if random.chance(40) { vec![parameter(station, nth, random)] } else { Vec::new() };
    station.tasks.push(Task {
        name: format!("task {nth}"),
        steps: first..first + count,
        from: RestId::at(from),
        to: RestId::at(to),
        limit: Duration::from_secs(10),
        parameters,
    });
}

fn is_reversible(station: &Station, op: OpId) -> bool {
    matches!(station.operations[op.index()].module, linewright_line::OperationModule::Reversible { .. })
}

/// One button runs the task, another may take it back; what follows is put in afterwards.
fn hand(n: usize, count: usize, task: usize, reversed: bool, buttons: &mut Vec<String>) -> HandMode {
    let forward = button(buttons, format!("F_{task}"));
    let (next, last) = (forward, n + 1 == count);
    if !reversed {
        return if last { HandMode::SequenceEnd { forward, next } } else { HandMode::Sequence { forward } };
    }
    let back = button(buttons, format!("B_{task}"));
    match (n, last) {
        (0, true) => HandMode::Single { forward, back, next },
        (0, false) => HandMode::ReversedStart { forward, back },
        (_, false) => HandMode::ReversedMiddle { forward, back },
        (_, true) => HandMode::ReversedEnd { forward, back, next },
    }
}

fn parameter(station: &mut Station, task: usize, random: &mut Random) -> Parameter {
    let bits = (0..random.within(&(1..=3))).map(|bit| {
        station.outputs.push(format!("N_{task}_{bit}"));
        OutputId::at(station.outputs.len() - 1)
    });
    Parameter { name: format!("number_{task}"), bits: bits.collect() }
}
