//! Measured positions: the switches that measure a station's mechanisms, and what follows from them for conflicts.
//!
//! A motion ends at a switch. Where the chart has an axis at rest, the switches of every motion that ends there are on. From
//! this follow, for each marked place, the inputs that must be on ([`Station::rest_inputs`]), and for each side of a conflict
//! the inputs that are all on outside it and never all on inside it, and those that contradict them ([`Line::clearance`]).
//!
//! No memory is involved: the same answer follows from the image alone, whatever a controller's state.

use crate::net::{Block, MotionStage, StationPlace};
use crate::{AxisId, Line, Motion, OpId, Operation, OperationModule, StateSpan, Station};

/// Coordinates nearer than this are one place, in millimetres or degrees.
const SAME_PLACE: f64 = 1e-6;

fn same_place(a: f64, b: f64) -> bool {
    (a - b).abs() < SAME_PLACE
}

/// Reason why no switches measure whether a station is outside a state of a conflict.
#[derive(Clone, Debug, PartialEq)]
pub enum NoClearance {
    /// No axis with a switch stands still all the time the station is outside the state.
    NothingStandsStill,
    /// Neither does any, since an axis that moves inside the state goes on outside it, next to it.
    CutShort(CutShort),
    /// The axes that stand still outside the state stand there during this operation too, which is inside it.
    NotSeen {
        /// The operation.
        op: OpId,
    },
}

/// Inputs that measure a station outside a state of a conflict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClearanceInputs {
    /// All on wherever the station is outside the state, and never all on inside it. 0 where nothing measures it.
    pub on: u128,
    /// The switches at the other places of the same axes: where one of them is on, one of `on` sticks.
    pub off: u128,
}

impl ClearanceInputs {
    /// Whether an image measures the station outside the state.
    pub fn hold(self, image: u128) -> bool {
        self.wrong(image) == 0
    }

    /// The inputs that differ from what they are outside the state.
    pub fn wrong(self, image: u128) -> u128 {
        (image & (self.on | self.off)) ^ self.on
    }

    /// All inputs that are looked at.
    pub fn all(self) -> u128 {
        self.on | self.off
    }
}

/// An operation outside a state of a conflict, with which the state would begin and end with an axis at one place.
#[derive(Clone, Debug, PartialEq)]
pub struct CutShort {
    pub op: OpId,
    /// Where the axis stands between this operation and the state.
    pub away: f64,
    /// Where it stands at the other end of the state.
    pub rest: f64,
    /// The operation follows the state; it comes before it otherwise.
    pub follows: bool,
}

impl CutShort {
    fn text(&self, station: &Station) -> String {
        let operation = &station.operations[self.op.index()];
        let (name, axis) = (&operation.name, &station.axes[operation.motion.axis.index()].name);
        let (away, rest, of) = (self.away, self.rest, &station.name);
        match self.follows {
            true => format!(
                "`{name}` of {of} is outside this state: `{axis}` stands at {away} where the state ends, and is back at {rest} only after \
                 this operation; if it is in the way until then, write `until = \"{name}\"`"
            ),
            false => format!(
                "`{name}` of {of} is outside this state: `{axis}` leaves {rest} with this operation, and stands at {away} where the state \
                 begins; if it is in the way from then on, write `from = \"{name}\"`"
            ),
        }
    }
}

impl NoClearance {
    /// The reason, for a station of the line.
    pub fn text(&self, station: &Station) -> String {
        match self {
            NoClearance::NothingStandsStill => {
                format!("every axis of {} with a limit switch moves outside this state too", station.name)
            }
            NoClearance::CutShort(cut) => cut.text(station),
            NoClearance::NotSeen { op } => {
                let name = &station.operations[op.index()].name;
                format!("no limit switch of {} tells `{name}` from being outside this state", station.name)
            }
        }
    }
}

impl Station {
    /// The inputs that are on while the axis stands at `at`: the completion inputs of the motions that end there. A motion
    /// without a way is left out, for its completion is no position. Where several inputs measure one place none is given:
    /// each has a reach of its own, and a motion that ends in the wider one may not have come to the narrower.
    pub fn switches_at(&self, axis: AxisId, at: f64) -> u128 {
        let bits = self.inputs_at(axis, at);
        if bits.count_ones() == 1 { bits } else { 0 }
    }

    /// The completion inputs of the motions with a way that end there.
    fn inputs_at(&self, axis: AxisId, at: f64) -> u128 {
        let here = self.completions().filter(|&(of, place, _)| of == axis && same_place(place, at));
        here.fold(0, |bits, (_, _, input)| bits | input)
    }

    /// The switches of the axis at its other places, each of one place alone and of no other axis.
    fn switches_elsewhere(&self, axis: AxisId, at: f64) -> u128 {
        let (there, others): (Vec<_>, Vec<_>) =
            self.completions().partition(|&(of, place, _)| of == axis && !same_place(place, at));
        let of = |completions: &[(AxisId, f64, u128)]| completions.iter().fold(0, |bits, (_, _, input)| bits | input);
        of(&there) & !of(&others)
    }

    /// The switch at the end that a motion leaves: while it is on, the motion has not come to its other end. 0 for a motion
    /// without a way, for an index, and where that end has no switch, several, or the one that the motion is complete by.
    pub fn switch_left_behind(&self, op: OpId, block: Block) -> u128 {
        let Operation { motion, module, normal, .. } = &self.operations[op.index()];
        let (left, complete) = match (block, module) {
            (Block::Recovery, OperationModule::Reversible { recovery, .. }) => (motion.to, recovery.complete),
            (Block::Normal | Block::Recovery, _) => (motion.from, normal.complete),
        };
        let has_two_ends = self.goes(*motion) && self.axes[motion.axis.index()].index.is_none();
        if has_two_ends { self.switches_at(motion.axis, left) & !complete.bit() } else { 0 }
    }

    /// Every input that completes a motion with a way.
    pub fn all_switches(&self) -> u128 {
        self.completions().fold(0, |bits, (_, _, input)| bits | input)
    }

    /// Whether a motion has a way: to another place, or round to the same one.
    fn goes(&self, motion: Motion) -> bool {
        self.axes[motion.axis.index()].index.is_some() || !same_place(motion.from, motion.to)
    }

    /// For each motion with a way, and for each way back: its axis, where it ends, and its completion input.
    fn completions(&self) -> impl Iterator<Item = (AxisId, f64, u128)> + '_ {
        self.operations.iter().filter(|operation| self.goes(operation.motion)).flat_map(|operation| {
            let motion = operation.motion;
            let back = match &operation.module {
                OperationModule::Reversible { recovery, .. } => {
                    Some((motion.axis, motion.from, recovery.complete.bit()))
                }
                OperationModule::Irreversible { .. } => None,
            };
            std::iter::once((motion.axis, motion.to, operation.normal.complete.bit())).chain(back)
        })
    }

    /// The switches that are on when all axes stand where the chart has them after a step; none where the place of an axis
    /// that moves has no switch, or several.
    pub fn measured_after(&self, step: usize) -> Option<u128> {
        let mut at = self.positions_before_steps().swap_remove(step);
        self.move_axes(step, &mut at);
        self.measured_at(&at, None)
    }

    /// The switches that are on while the operation's axis is on its way; none as for [`Station::measured_after`], for the
    /// other axes.
    pub fn measured_within(&self, op: OpId) -> Option<u128> {
        let at = self.positions_before_steps().swap_remove(self.step_of(op));
        self.measured_at(&at, Some(self.operations[op.index()].motion.axis))
    }

    fn measured_at(&self, at: &[f64], but: Option<AxisId>) -> Option<u128> {
        let moves = |axis: AxisId| self.completions().any(|(of, _, _)| of == axis);
        let axes = at.iter().enumerate().map(|(axis, &at)| (AxisId::at(axis), at));
        axes.filter(|&(axis, _)| Some(axis) != but && moves(axis)).try_fold(0, |bits, (axis, at)| {
            let here = self.switches_at(axis, at);
            (here != 0).then_some(bits | here)
        })
    }

    /// Position of each axis before the first operation of a step, by the chart; one list for each step.
    pub fn positions_before_steps(&self) -> Vec<Vec<f64>> {
        let home: Vec<f64> = self.axes.iter().map(|axis| axis.home).collect();
        let mut before = vec![home.clone(); self.steps.len()];
        if self.is_task_driven() {
            for task in &self.tasks {
                let mut at = self.rests[task.from.index()].at.clone();
                for step in task.steps.clone() {
                    before[step].clone_from(&at);
                    self.move_axes(step, &mut at);
                }
            }
        } else {
            let mut at = home;
            let first = self.step_of(self.home) + 1;
            for step in (first..first + self.steps.len()).map(|step| step % self.steps.len()) {
                before[step].clone_from(&at);
                self.move_axes(step, &mut at);
            }
        }
        before
    }

    /// The operation that a state of a conflict has to take in so that the axis with which it begins, or else the one with which it ends,
    /// stands at its end where it stood at its beginning: the nearer one, of those after the state and before it.
    fn cut_short(&self, span: &StateSpan, before: &[Vec<f64>], inside: &[usize], end: &[f64]) -> Option<CutShort> {
        // Before and after a task comes whatever is ordered.
        if self.is_task_driven() {
            return None;
        }
        let (count, outside) = (self.steps.len(), self.steps.len() - inside.len());
        let (first, last) = (inside[0], inside[inside.len() - 1]);
        let axis_of = |op: OpId| self.operations[op.index()].motion.axis.index();
        let moves = |step: usize, axis: usize| self.steps[step].iter().copied().find(|op| axis_of(*op) == axis);
        let is_away = |axis: &usize| self.axes[*axis].index.is_none() && !same_place(before[first][*axis], end[*axis]);
        let axis = [span.from, span.until].map(axis_of).into_iter().find(is_away)?;
        let (rest, end) = (before[first][axis], end[axis]);
        let after = (1..=outside).find_map(|n| {
            let op = moves((last + n) % count, axis)?;
            let is_back = same_place(self.operations[op.index()].motion.to, rest);
            is_back.then_some((n, CutShort { op, away: end, rest, follows: true }))
        });
        let earlier = (1..=outside).find_map(|n| {
            let step = (first + count - n) % count;
            let op = moves(step, axis)?;
            let is_left = same_place(before[step][axis], end);
            is_left.then_some((n, CutShort { op, away: rest, rest: end, follows: false }))
        });
        after.into_iter().chain(earlier).min_by_key(|(n, _)| *n).map(|(_, cut)| cut)
    }

    fn move_axes(&self, step: usize, at: &mut [f64]) {
        for op in &self.steps[step] {
            let motion = self.operations[op.index()].motion;
            at[motion.axis.index()] = motion.to;
        }
    }

    fn moves_in_step(&self, step: usize, axis: usize) -> bool {
        self.steps[step].iter().any(|op| {
            let motion = self.operations[op.index()].motion;
            motion.axis.index() == axis && self.goes(motion)
        })
    }

    /// The inputs that must be on while this place is marked: the switches of every axis that stands still there. Where the
    /// operation itself is at rest, its own end is among them; while it moves, or was stopped, it is not. It does not hold on a
    /// recovery path, which begins wherever a fault has left the mechanism.
    pub fn rest_inputs(&self, place: StationPlace) -> u128 {
        self.at_rest(place).fold(0, |bits, (axis, at)| bits | self.switches_at(axis, at))
    }

    /// The inputs of which one at least must be on while this place is marked: for every axis that stands still there at a
    /// place that several inputs measure. The last motion that ended there ended by one of them. As for
    /// [`Station::rest_inputs`], not on a recovery path. Endless axes are left out.
    pub fn rest_alternatives(&self, place: StationPlace) -> Vec<u128> {
        let straight = self.at_rest(place).filter(|&(axis, _)| self.axes[axis.index()].index.is_none());
        straight.map(|(axis, at)| self.inputs_at(axis, at)).filter(|bits| bits.count_ones() > 1).collect()
    }

    /// The axes that stand still while this place is marked, with where they stand.
    fn at_rest(&self, place: StationPlace) -> impl Iterator<Item = (AxisId, f64)> + '_ {
        let step = self.step_of(place.op);
        let mut at = self.positions_before_steps().swap_remove(step);
        let motion = self.operations[place.op.index()].motion;
        let own = match (place.block, place.stage) {
            (_, MotionStage::Operating | MotionStage::Incomplete) => None,
            (Block::Normal, MotionStage::Completed) => Some(motion.to),
            (Block::Recovery, MotionStage::Completed) => Some(motion.from),
        };
        if let Some(own) = own {
            at[motion.axis.index()] = own;
        }
        let rests = move |axis: usize| match own {
            Some(_) if axis == motion.axis.index() => true,
            Some(_) | None => axis != motion.axis.index() && !self.moves_in_step(step, axis),
        };
        let axes = at.into_iter().enumerate().filter(move |&(axis, _)| rests(axis));
        axes.map(|(axis, at)| (AxisId::at(axis), at))
    }

    /// The steps of a stretch of the cycle, from `from` until `until`, across the end of the list where it lies so.
    pub fn steps_of_span(&self, span: &StateSpan) -> Vec<usize> {
        let (from, count) = (self.step_of(span.from), self.steps.len());
        let length = (self.step_of(span.until) + count - from) % count;
        (0..=length).map(|n| (from + n) % count).collect()
    }
}

/// Part of a step during which an axis is at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meets {
    AtItsStart,
    OnItsWay,
    AtItsEnd,
    /// It turns from the place round to it again.
    AtBothEnds,
    Always,
}

impl Meets {
    fn of(place: f64, start: f64, end: f64) -> Option<Meets> {
        match (same_place(start, place), same_place(end, place)) {
            (true, true) => Some(Meets::Always),
            (true, false) => Some(Meets::AtItsStart),
            (false, true) => Some(Meets::AtItsEnd),
            (false, false) => ((start - place) * (end - place) < 0.0).then_some(Meets::OnItsWay),
        }
    }
}

impl Line {
    /// The inputs of the span's station that are all on wherever it stands or moves outside this state of a conflict, and
    /// never all on inside it.
    ///
    /// They are the switches of the axes that stand still, by the chart, all the time outside the state. At every moment inside
    /// it one of these axes must be elsewhere.
    ///
    /// # Errors
    /// When there are no such switches; the reason contains what is not measured.
    pub fn clearance(&self, span: &StateSpan) -> Result<ClearanceInputs, NoClearance> {
        let station = self.station(span.station);
        let before = station.positions_before_steps();
        let inside = station.steps_of_span(span);
        let rest = &before[inside[0]];
        let after = |step: usize| {
            let mut at = before[step].clone();
            station.move_axes(step, &mut at);
            at
        };
        let end = after(inside[inside.len() - 1]);
        let outside = (0..station.steps.len()).filter(|step| !inside.contains(step));
        let moved: Vec<usize> = outside
            .flat_map(|step| (0..station.axes.len()).filter(move |&axis| station.moves_in_step(step, axis)))
            .collect();
        let still: Vec<usize> = (0..station.axes.len())
            .filter(|axis| !moved.contains(axis) && same_place(rest[*axis], end[*axis]))
            .filter(|&axis| station.switches_at(AxisId::at(axis), rest[axis]) != 0)
            .collect();
        if still.is_empty() {
            let cut = station.cut_short(span, &before, &inside, &end);
            return Err(cut.map_or(NoClearance::NothingStandsStill, NoClearance::CutShort));
        }
        for (nth, &step) in inside.iter().enumerate() {
            let (start, end) = (&before[step], after(step));
            // Axes that move in one step keep no order: each may be at its start still, or at its end already.
            let meets: Option<Vec<Meets>> = still
                .iter()
                .map(|&axis| {
                    let moves = station.moves_in_step(step, axis);
                    if moves && station.axes[axis].index.is_some() {
                        return Some(Meets::AtBothEnds);
                    }
                    Meets::of(rest[axis], start[axis], if moves { end[axis] } else { start[axis] })
                })
                .collect();
            let only = |end: Meets| {
                let of =
                    |meets: &Vec<Meets>| meets.contains(&end) && meets.iter().all(|m| [end, Meets::Always].contains(m));
                meets.as_ref().is_some_and(of)
            };
            // Where the state begins and where it ends the station is outside it.
            let (begins, ends) = (nth == 0, nth + 1 == inside.len());
            let at_the_border = (begins && only(Meets::AtItsStart))
                || (ends && only(Meets::AtItsEnd))
                || (begins && ends && only(Meets::AtBothEnds));
            if meets.is_some() && !at_the_border {
                let cut = station.cut_short(span, &before, &inside, &end);
                return Err(cut.map_or(NoClearance::NotSeen { op: station.steps[step][0] }, NoClearance::CutShort));
            }
        }
        let on = still.iter().fold(0, |bits, &axis| bits | station.switches_at(AxisId::at(axis), rest[axis]));
        let off = still.iter().fold(0, |bits, &axis| bits | station.switches_elsewhere(AxisId::at(axis), rest[axis]));
        Ok(ClearanceInputs { on, off: off & !on })
    }
}
