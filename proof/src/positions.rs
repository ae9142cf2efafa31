//! The second barrier by itself: what measured positions exclude, whatever the controllers' memories.
//!
//! Two stations of one conflict, with their axes where they physically are. Any motion of either may be commanded at
//! any moment, in any order and from any place, forward, back or on a recovery path, may miss its end and stop
//! anywhere: so this covers every marking, every count, a lost memory, a restart, and any mode. Only the controller's
//! conditions on measured positions ([`Program::guards`], [`Program::off_at_rest`]) keep a motion from starting or
//! going on, and a switch is on exactly where its axis stands at it.
//!
//! ```text
//!   axis:   0 ───────── 50 ───────── 100      a coordinate of the chart, or somewhere between two
//!           │  between  │  between   │
//!           LS_0        LS_50        LS_100
//! ```
//!
//! An endless axis has one place, and the way round from it to itself, which it goes one way:
//!
//! ```text
//!   0 ── under way ──▶ 0      its switch is on at 0; nothing tells before an index from after it
//! ```
//!
//! **What is assumed.** A report is there before the other station decides: of two motions that start within the time a
//! report takes, neither is seen by the other. And an image that is lost stops no motion under way. Against both stand the
//! counts.
//!
//! The state of the conflict is judged by the axes alone: every configuration that the chart does not have outside the
//! stretch counts as inside.

use std::collections::{HashMap, HashSet, VecDeque};

use linewright_line::net::{Block, MotionStage, StationNet, StationPlace, TransitionKind};
use linewright_line::{Conflict, Line, OpId, OperationModule, StateSpan, StationId};
use linewright_station_logic::{CompileError, PositionsKnown, Program};

/// Parts of the second barrier in force. On a machine all are; without one the exploration must find what it prevents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PositionRules {
    /// A motion starts only while the other station is measured clear.
    pub starts: bool,
    /// A motion stops while the other station is measured not to be clear.
    pub stops: bool,
}

impl PositionRules {
    /// All rules in force; what a machine has.
    pub const ALL: PositionRules = PositionRules { starts: true, stops: true };
}

/// Result for one conflict.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PositionsExplored {
    /// Number of states seen.
    pub states: usize,
    /// There are no others.
    pub exhausted: bool,
    /// Path to both states of the conflict, if there is one.
    pub counterexample: Option<Vec<String>>,
}

/// Explores the two stations of a conflict as far as `states_max`.
///
/// # Errors
/// When a station does not compile.
pub fn explore_positions(
    line: &Line,
    conflict: &Conflict,
    rules: PositionRules,
    states_max: usize,
) -> Result<PositionsExplored, CompileError> {
    let sides = [
        PositionSide::of(line, &conflict.a, conflict.b.station)?,
        PositionSide::of(line, &conflict.b, conflict.a.station)?,
    ];
    let start = [sides[0].home(), sides[1].home()].concat();
    let mut numbers: HashMap<Vec<u16>, usize> = HashMap::from([(start.clone(), 0)]);
    let mut from: Vec<(usize, String)> = vec![(0, String::new())];
    let mut queue = VecDeque::from([(0, start)]);
    let mut next = Vec::new();
    while let Some((number, state)) = queue.pop_front() {
        follow(&sides, rules, &state, &mut next);
        for (state, what) in next.drain(..) {
            if numbers.contains_key(&state) {
                continue;
            }
            if numbers.len() == states_max {
                return Ok(PositionsExplored { states: states_max, exhausted: false, counterexample: None });
            }
            let meet = sides[0].is_inside(&state) && sides[1].is_inside(&state[sides[0].width()..]);
            let entered = from.len();
            numbers.insert(state.clone(), entered);
            from.push((number, what));
            if meet {
                let counterexample = Some(way(&from));
                return Ok(PositionsExplored { states: numbers.len(), exhausted: false, counterexample });
            }
            queue.push_back((entered, state));
        }
    }
    Ok(PositionsExplored { states: numbers.len(), exhausted: true, counterexample: None })
}

/// The steps to the last state.
fn way(from: &[(usize, String)]) -> Vec<String> {
    let mut steps = Vec::new();
    let mut at = from.len() - 1;
    while at != 0 {
        steps.push(from[at].1.clone());
        at = from[at].0;
    }
    steps.reverse();
    steps
}

/// A motion that may be commanded.
struct MotionCommand {
    place: StationPlace,
    path: Option<OpId>,
    axis: usize,
    /// End of the motion.
    target: u16,
    /// Towards greater coordinates, from where the chart has it.
    up: bool,
    text: String,
}

/// One station of the conflict. Its part of a state is, for each axis, where it stands (an even number is a coordinate, an
/// odd one the way between two), then, for each axis, the command that moves it, counted from 1; 0 for none.
struct PositionSide {
    name: String,
    other: StationId,
    program: Program,
    /// For each axis its name and the coordinates of the chart, ascending.
    axes: Vec<(String, Vec<f64>)>,
    /// For each axis, whether its last coordinate is its first one again.
    endless: Vec<bool>,
    /// For each axis, the inputs that are on at each coordinate.
    switches: Vec<Vec<u128>>,
    commands: Vec<MotionCommand>,
    home: Vec<u16>,
    /// The configurations that the chart has outside the stretch, and those that it has inside.
    outside: HashSet<Vec<u16>>,
    inside: HashSet<Vec<u16>>,
}

impl PositionSide {
    fn of(line: &Line, span: &StateSpan, other: StationId) -> Result<Self, CompileError> {
        let station = line.station(span.station);
        let mut axes: Vec<(String, Vec<f64>)> =
            station.axes.iter().map(|axis| (axis.name.clone(), vec![axis.home])).collect();
        for operation in &station.operations {
            let motion = operation.motion;
            axes[motion.axis.index()].1.extend([motion.from, motion.to]);
        }
        for (axis, (_, at)) in station.axes.iter().zip(&mut axes) {
            at.extend(axis.index.map(|by| axis.home + by));
        }
        for (_, at) in &mut axes {
            at.sort_by(f64::total_cmp);
            at.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        }
        let mut side = PositionSide {
            name: station.name.clone(),
            other,
            program: Program::compile(line, span.station)?,
            endless: station.axes.iter().map(|axis| axis.index.is_some()).collect(),
            switches: axes.iter().map(|(_, at)| vec![0; at.len()]).collect(),
            axes,
            commands: Vec::new(),
            home: Vec::new(),
            outside: HashSet::new(),
            inside: HashSet::new(),
        };
        side.home = station.axes.iter().enumerate().map(|(axis, of)| side.point(axis, of.home)).collect();
        for (op, operation) in station.operations.iter().enumerate() {
            let motion = operation.motion;
            let goes = side.point(motion.axis.index(), motion.from) != side.point(motion.axis.index(), motion.to);
            if !goes && station.index_of(OpId::at(op)).is_none() {
                continue;
            }
            side.switch(motion.axis.index(), motion.to, operation.normal.complete.bit());
            if let OperationModule::Reversible { recovery, .. } = &operation.module {
                side.switch(motion.axis.index(), motion.from, recovery.complete.bit());
            }
        }
        side.command_all(line, span.station);
        side.draw_chart(line, span);
        Ok(side)
    }

    fn point(&self, axis: usize, at: f64) -> u16 {
        let near = |coordinate: &f64| (coordinate - at).abs() < 1e-6;
        let index = self.axes[axis].1.iter().position(near).expect("all coordinates of the chart are in the list");
        2 * index as u16
    }

    /// The greatest coordinate of an axis.
    fn last(&self, axis: usize) -> u16 {
        2 * (self.axes[axis].1.len() as u16 - 1)
    }

    fn switch(&mut self, axis: usize, at: f64, bit: u128) {
        let point = usize::from(self.point(axis, at)) / 2;
        self.switches[axis][point] |= bit;
    }

    /// Every motion of the station's net: forward, back, and on each recovery path.
    fn command_all(&mut self, line: &Line, id: StationId) {
        let station = line.station(id);
        let net = StationNet::of(line, id);
        let mut all: Vec<(StationPlace, Option<OpId>)> = Vec::new();
        let is_irreversible =
            |op: &OpId| matches!(station.operations[op.index()].module, OperationModule::Irreversible { .. });
        let paths: Vec<Option<OpId>> = station.op_ids().filter(is_irreversible).map(Some).collect();
        for transition in net.transitions() {
            // A hop may be one of several paths.
            let of = match transition.kind {
                TransitionKind::EnterPath(failed) => vec![Some(failed)],
                TransitionKind::FollowPath { .. } => paths.clone(),
                _ => vec![None],
            };
            let operating = transition.to.iter().filter(|place| place.stage == MotionStage::Operating);
            all.extend(operating.flat_map(|&place| of.iter().map(move |&path| (place, path))));
        }
        all.sort_unstable_by_key(|(place, path)| (place.op, place.block == Block::Recovery, *path));
        all.dedup();
        for (place, path) in all {
            let operation = &station.operations[place.op.index()];
            let motion = operation.motion;
            let axis = motion.axis.index();
            let (from, to) = (self.point(axis, motion.from), self.point(axis, motion.to));
            let (from, target) = match place.block {
                Block::Recovery => (to, from),
                Block::Normal if self.endless[axis] => (from, self.last(axis)),
                Block::Normal => (from, to),
            };
            if from == target {
                continue;
            }
            let undoing = if place.block == Block::Recovery { "undoing " } else { "" };
            let text = format!("{} started {undoing}{}", station.name, operation.name);
            self.commands.push(MotionCommand { place, path, axis, target, up: target > from, text });
        }
    }

    /// The configurations of the chart, outside the stretch and inside it.
    fn draw_chart(&mut self, line: &Line, span: &StateSpan) {
        let station = line.station(span.station);
        let (before, stretch) = (station.positions_before_steps(), station.steps_of_span(span));
        for (step, start) in before.iter().enumerate() {
            let start: Vec<u16> = start.iter().enumerate().map(|(axis, &at)| self.point(axis, at)).collect();
            let mut end = start.clone();
            for op in &station.steps[step] {
                let motion = station.operations[op.index()].motion;
                end[motion.axis.index()] = self.point(motion.axis.index(), motion.to);
            }
            let mut all = between(&start, &end);
            // Round to where it began, which it is at both ends.
            let turns = station.steps[step].iter().map(|op| station.operations[op.index()].motion.axis.index());
            for axis in turns.filter(|&axis| self.endless[axis]) {
                all.push(start.iter().enumerate().map(|(at, &n)| if at == axis { n + 1 } else { n }).collect());
            }
            if !stretch.contains(&step) {
                self.outside.extend(all);
                continue;
            }
            // The stretch begins when its first operation starts and ends when its last one is complete; of a group, the one
            // named alone.
            let begins = stretch.first() == Some(&step);
            let ends = stretch.last() == Some(&step);
            let axis_of = |op: OpId| station.operations[op.index()].motion.axis.index();
            let (first, last) = (axis_of(span.from), axis_of(span.until));
            for at in all {
                let outside = (begins && at[first] == start[first]) || (ends && at[last] == end[last]);
                if outside {
                    self.outside.insert(at.clone());
                }
                if !outside || (start == end && at == start && !(begins && ends)) {
                    self.inside.insert(at);
                }
            }
        }
    }

    fn home(&self) -> Vec<u16> {
        let mut part = self.home.clone();
        part.resize(self.width(), 0);
        part
    }

    fn width(&self) -> usize {
        2 * self.axes.len()
    }

    fn is_inside(&self, part: &[u16]) -> bool {
        let at = &part[..self.axes.len()];
        self.inside.contains(at) || !self.outside.contains(at)
    }

    fn image(&self, part: &[u16]) -> u128 {
        let on = |(axis, &at): (usize, &u16)| if at % 2 == 0 { self.switches[axis][usize::from(at) / 2] } else { 0 };
        part[..self.axes.len()].iter().enumerate().map(on).fold(0, |bits, on| bits | on)
    }

    fn stands(&self, part: &[u16]) -> bool {
        part[self.axes.len()..self.width()].iter().all(|&command| command == 0)
    }

    /// Whether measured positions let a motion start or go on.
    fn is_free(&self, command: &MotionCommand, images: (u128, u128), other_stands: bool) -> bool {
        let known = PositionsKnown { own: Some(images.0), is_placed: true, other: Some(images.1), counts: true };
        self.program.guards(command.place, command.path).all(|(guard, leaves)| {
            self.program.peers()[usize::from(guard.peer)] != self.other
                || guard.holds(known)
                || (leaves && other_stands)
        })
    }

    fn is_placed(&self, command: &MotionCommand, own: u128) -> bool {
        command.path.is_some() || self.program.off_at_rest(command.place, own) == 0
    }

    fn where_text(&self, axis: usize, at: u16) -> String {
        let (name, coordinates) = &self.axes[axis];
        let index = usize::from(at) / 2;
        if at.is_multiple_of(2) {
            format!("{}: {name} comes to {}", self.name, coordinates[index])
        } else {
            format!("{}: {name} is between {} and {}", self.name, coordinates[index], coordinates[index + 1])
        }
    }
}

/// All configurations on the way from one to the other, the axes each at their own pace.
fn between(start: &[u16], end: &[u16]) -> Vec<Vec<u16>> {
    start.iter().zip(end).fold(vec![Vec::new()], |all, (&a, &b)| {
        let on_the_way = a.min(b)..=a.max(b);
        all.iter().flat_map(|head| on_the_way.clone().map(move |at| [&head[..], &[at]].concat())).collect()
    })
}

/// Everything that may follow a state, with its text.
fn follow(sides: &[PositionSide; 2], rules: PositionRules, state: &[u16], out: &mut Vec<(Vec<u16>, String)>) {
    let (first, second) = state.split_at(sides[0].width());
    let parts = [first, second];
    for nth in 0..2 {
        let (side, part, other) = (&sides[nth], parts[nth], &sides[1 - nth]);
        let images = (side.image(part), other.image(parts[1 - nth]));
        let other_stands = other.stands(parts[1 - nth]);
        let begin = if nth == 0 { 0 } else { sides[0].width() };
        let axes = side.axes.len();
        let mut push = |index: usize, value: u16, what: String| {
            let mut next = state.to_vec();
            next[begin + index] = value;
            out.push((next, what));
        };
        for (number, command) in side.commands.iter().enumerate() {
            let idle = part[axes + command.axis] == 0;
            let free = !rules.starts || side.is_free(command, images, other_stands);
            if idle && free && side.is_placed(command, images.0) {
                push(axes + command.axis, number as u16 + 1, command.text.clone());
            }
        }
        for axis in 0..axes {
            let Some(number) = part[axes + axis].checked_sub(1) else { continue };
            let command = &side.commands[usize::from(number)];
            push(axes + axis, 0, format!("{}: {} stops", side.name, side.axes[axis].0));
            let free = !rules.stops || side.is_free(command, images, other_stands);
            // A relay moves its axis one way, past its end if no switch stops it; a drive goes to its target from either side.
            let (at, last) = (part[axis], side.last(axis));
            let up = (command.up || at < command.target) && at < last;
            let down = (!command.up || at > command.target) && at > 0;
            for to in [up.then(|| at + 1), down.then(|| at - 1)].into_iter().flatten() {
                if free && side.is_placed(command, images.0) {
                    let is_round = side.endless[axis] && to == last;
                    push(axis, if is_round { 0 } else { to }, side.where_text(axis, to));
                }
            }
        }
    }
}
