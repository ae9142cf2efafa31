//! A random station, thought of from home: first what it does and which axes that moves, then where its list begins,
//! then how hand mode divides it into sequences.
//!
//! One axis goes on with every step and comes back with the home operation, so home is at the end of every recovery
//! path. A concurrent group moves axes of its own besides, each of which some later operation brings back. Irreversible
//! operations come before any group, since no recovery path could take the group back.

use std::time::Duration;

use linewright_line::{
    Axis, AxisId, BRANCHES_MAX, BUTTONS_MAX, ButtonId, HandMode, InputId, Motion, MotionSignals, OpId, Operation,
    OperationModule, OutputId, Station,
};

use super::{LineShape, Random, empty_station};

/// Operations of one station, at least and at most: two, so that something can come back; and few enough for the bits
/// of one process image.
const OPERATIONS: std::ops::RangeInclusive<usize> = 2..=24;
/// Operations side by side.
const BRANCHES: std::ops::RangeInclusive<usize> = 2..=3;
/// Axes that are out when another group begins: all that are may come back side by side, the main one with them.
const OUT_MAX: usize = BRANCHES_MAX - 1 - *BRANCHES.end();
/// The axis that goes on with every step.
const MAIN: usize = 0;

/// With a button each way, as many runs as there may be buttons for; what comes on top shares theirs.
const RUNS: usize = BUTTONS_MAX / 2;

/// An operation by its place in the round, home being 0.
#[derive(Clone, Debug)]
struct PlannedOperation {
    axis: usize,
    /// Takes its axis back to where it stands at home.
    back: bool,
    /// Irreversible, with the places of its recovery path.
    path: Option<Vec<usize>>,
}

/// The round from home: steps of operations.
struct RoundPlan {
    steps: Vec<Vec<PlannedOperation>>,
    axes: usize,
}

pub(super) fn random(shape: &LineShape, number: usize, buttons: &mut Vec<String>, random: &mut Random) -> Station {
    let count = random.within(&shape.operations);
    assert!(OPERATIONS.contains(&count), "{count} operations are not within {OPERATIONS:?}");
    let plan = RoundPlan::random(shape, count, random);
    let listed = plan.listed_from(random);
    let hands = hands(&plan, shape, buttons, random);
    build(&plan, listed, &hands, number, shape, random)
}

impl RoundPlan {
    fn random(shape: &LineShape, count: usize, random: &mut Random) -> Self {
        let one = |axis, back| PlannedOperation { axis, back, path: None };
        let mut plan = RoundPlan { steps: vec![vec![one(MAIN, true)], vec![one(MAIN, false)]], axes: 1 };
        let mut out: Vec<usize> = Vec::new();
        let mut left = count - 2;
        while left > 0 {
            let branches = random.within(&BRANCHES);
            let step = if left == out.len() || (!out.is_empty() && random.chance(40)) {
                plan.come_back(&mut out, left, shape, random)
            } else if out.len() <= OUT_MAX && left + 1 >= out.len() + 2 * branches && random.chance(shape.groups) {
                let own: Vec<usize> = (plan.axes..plan.axes + branches - 1).collect();
                plan.axes += branches - 1;
                out.extend(&own);
                [MAIN].into_iter().chain(own).map(|axis| one(axis, false)).collect()
            } else {
                let path = if plan.axes == 1 { plan.path(shape, random) } else { None };
                vec![PlannedOperation { path, ..one(MAIN, false) }]
            };
            left -= step.len();
            plan.steps.push(step);
        }
        plan
    }

    /// One or all of the axes that are out come back, all of them side by side.
    fn come_back(
        &self,
        out: &mut Vec<usize>,
        left: usize,
        shape: &LineShape,
        random: &mut Random,
    ) -> Vec<PlannedOperation> {
        let one = |axis, back| PlannedOperation { axis, back, path: None };
        if random.chance(shape.groups.max(30)) {
            let with_main = left > out.len() && random.chance(50);
            let main = with_main.then(|| one(MAIN, false));
            return main.into_iter().chain(out.drain(..).map(|axis| one(axis, true))).collect();
        }
        vec![one(out.swap_remove(random.below(out.len())), true)]
    }

    /// For an operation to come: some of the reversible ones so far, the last one first.
    fn path(&self, shape: &LineShape, random: &mut Random) -> Option<Vec<usize>> {
        if !random.chance(shape.irreversible) {
            return None;
        }
        // No group so far, so places are numbers of steps.
        let reversible: Vec<usize> = (1..self.steps.len()).filter(|&n| self.steps[n][0].path.is_none()).collect();
        let mut path: Vec<usize> = reversible.iter().rev().copied().filter(|_| random.chance(60)).collect();
        if path.is_empty() {
            path.push(*random.pick(&reversible));
        }
        Some(path)
    }

    fn count(&self) -> usize {
        self.steps.iter().map(Vec::len).sum()
    }

    /// The step the list begins with: any that is one operation.
    fn listed_from(&self, random: &mut Random) -> usize {
        let alone: Vec<usize> = (0..self.steps.len()).filter(|&n| self.steps[n].len() == 1).collect();
        *random.pick(&alone)
    }
}

/// A button by its name, known to the whole line: the same step of the cycle has the same button at every station.
pub(super) fn button(buttons: &mut Vec<String>, name: String) -> ButtonId {
    let known = buttons.iter().position(|known| *known == name);
    ButtonId::at(known.unwrap_or_else(|| {
        buttons.push(name);
        buttons.len() - 1
    }))
}

/// A hand-mode entry for each step of the round from home.
fn hands(plan: &RoundPlan, shape: &LineShape, buttons: &mut Vec<String>, random: &mut Random) -> Vec<HandMode> {
    let runs = runs(plan, shape, random);
    // A run is taken back by a button of its own, or by the one that runs what follows: those of a clamp are each
    // other's reverse.
    let shared = (2..=RUNS).contains(&runs.len()) && random.chance(30);
    let forward: Vec<ButtonId> = (0..runs.len()).map(|run| button(buttons, format!("F_{}", run % RUNS))).collect();
    let mut hands = Vec::new();
    for (run, &(length, reversed)) in runs.iter().enumerate() {
        let next = forward[(run + 1) % runs.len()];
        let own = forward[run];
        for nth in 0..length {
            let last = nth + 1 == length;
            hands.push(if reversed {
                let back = if shared { next } else { button(buttons, format!("B_{}", run % RUNS)) };
                match (nth, last) {
                    (0, true) => HandMode::Single { forward: own, back, next },
                    (0, false) => HandMode::ReversedStart { forward: own, back },
                    (_, false) => HandMode::ReversedMiddle { forward: own, back },
                    (_, true) => HandMode::ReversedEnd { forward: own, back, next },
                }
            } else if last {
                HandMode::SequenceEnd { forward: own, next }
            } else {
                HandMode::Sequence { forward: own }
            });
        }
    }
    // A run may go on beyond home, and beyond the end of the list.
    let turned = random.below(hands.len());
    if runs_fit(plan, &hands, turned) {
        hands.rotate_right(turned);
    }
    hands
}

/// Whether no irreversible operation would be taken back if the runs began so many steps later.
fn runs_fit(plan: &RoundPlan, hands: &[HandMode], later: usize) -> bool {
    let hand = |step: usize| &hands[(step + hands.len() - later) % hands.len()];
    let irreversible = |step: &Vec<PlannedOperation>| step.iter().any(|op| op.path.is_some());
    (0..plan.steps.len()).all(|step| !irreversible(&plan.steps[step]) || hand(step).back().is_none())
}

/// The round from home divided into sequences: the length of each, and whether a button takes it back.
fn runs(plan: &RoundPlan, shape: &LineShape, random: &mut Random) -> Vec<(usize, bool)> {
    let mut runs: Vec<(usize, bool)> = Vec::new();
    let mut before = None;
    for step in &plan.steps {
        let reversible = step.iter().all(|op| op.path.is_none());
        let goes_on = before.is_some_and(|(length, reversed): (usize, bool)| {
            // A run of several that is taken back has none in it that cannot be.
            (!reversed || reversible) && (length > 1 || random.chance(shape.sequences))
        });
        match runs.last_mut() {
            Some(run) if goes_on && random.chance(70) => run.0 += 1,
            _ => runs.push((1, reversible && random.chance(70))),
        }
        before = runs.last().copied();
    }
    runs
}

fn build(
    plan: &RoundPlan,
    listed: usize,
    hands: &[HandMode],
    number: usize,
    shape: &LineShape,
    random: &mut Random,
) -> Station {
    let axes = (0..plan.axes).map(|axis| Axis { name: format!("axis_{axis}"), home: 0.0, index: None }).collect();
    let mut station = empty_station(number, axes, Vec::new());
    let places: Vec<usize> =
        plan.steps.iter().scan(0, |place, step| Some(std::mem::replace(place, *place + step.len()))).collect();
    let id = |place: usize| OpId::at((place + plan.count() - places[listed]) % plan.count());
    let positions = main_positions(plan);
    for nth in (0..plan.steps.len()).map(|nth| (nth + listed) % plan.steps.len()) {
        let first = station.operations.len();
        for (branch, planned) in plan.steps[nth].iter().enumerate() {
            let motion = match (planned.axis, planned.back) {
                (MAIN, _) => positions[nth],
                (_, false) => (0.0, 1.0),
                (_, true) => (1.0, 0.0),
            };
            let motion = Motion { axis: AxisId::at(planned.axis), from: motion.0, to: motion.1 };
            let path = planned.path.as_ref().map(|path| path.iter().map(|&place| id(places[place])).collect());
            let operation = operation(&mut station, places[nth] + branch, motion, path, hands[nth], shape, random);
            station.operations.push(operation);
        }
        station.steps.push((first..station.operations.len()).map(OpId::at).collect());
    }
    station.home = id(0);
    station
}

/// Start and end of the main axis, step by step from home: on by one with each that moves it, back at the end.
fn main_positions(plan: &RoundPlan) -> Vec<(f64, f64)> {
    let moves = |step: &Vec<PlannedOperation>| step.iter().any(|op| op.axis == MAIN);
    let mut at = 0.0;
    let mut positions = vec![(0.0, 0.0)];
    for step in &plan.steps[1..] {
        let from = at;
        at += f64::from(u8::from(moves(step)));
        positions.push((from, at));
    }
    positions[0] = (at, 0.0);
    positions
}

pub(super) fn operation(
    station: &mut Station,
    place: usize,
    motion: Motion,
    path: Option<Vec<OpId>>,
    hand: HandMode,
    shape: &LineShape,
    random: &mut Random,
) -> Operation {
    let mut signals = |way: &str| {
        let mut input = |what: &str| {
            station.inputs.push(format!("{what}_{place}{way}"));
            InputId::at(station.inputs.len() - 1)
        };
        let complete = input("S");
        let fault = random.chance(shape.sensors).then(|| input("F"));
        let mut output = |what: &str| {
            station.outputs.push(format!("{what}_{place}{way}"));
            OutputId::at(station.outputs.len() - 1)
        };
        let actuator = output("Y");
        let lamp = random.chance(shape.sensors).then(|| output("H"));
        MotionSignals { actuator, complete, fault, lamp }
    };
    let normal = signals("");
    let (duration, watchdog) = (Duration::from_millis(100), Duration::from_millis(1000));
    let module = match path {
        Some(recovery_path) => OperationModule::Irreversible { recovery_path },
        None => OperationModule::Reversible {
            recovery: signals("_back"),
            recovery_duration: duration,
            recovery_watchdog: watchdog,
        },
    };
    let (waits, waits_code, result) = (Vec::new(), 0, None);
    Operation {
        name: format!("op {place}"),
        module,
        duration,
        watchdog,
        motion,
        normal,
        waits,
        waits_code,
        result,
        hand,
    }
}
