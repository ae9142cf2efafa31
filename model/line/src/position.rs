//! Measured positions: the switches that measure a station's mechanisms, and what follows from them for conflicts.
//!
//! A motion ends at a switch. Where the chart has an axis at rest, the switches of every motion that ends there are on. From
//! this follow, for each marked place, the inputs that must be on ([`Station::rest_inputs`]), and for each side of a conflict
//! the inputs that are all on outside it and never all on inside it ([`Line::clearance`]).
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
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoClearance {
    /// No axis with a switch stands still all the time the station is outside the state.
    NothingStandsStill,
    /// The axes that stand still outside the state stand there during this operation too, which is inside it.
    NotSeen {
        /// The operation.
        op: OpId,
    },
}

impl NoClearance {
    /// The reason, for a station of the line.
    pub fn text(&self, station: &Station) -> String {
        match self {
            NoClearance::NothingStandsStill => {
                format!("no axis of {} with a limit switch stands still outside this state", station.name)
            }
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
        let here = self.completions().filter(|&(of, place, _)| of == axis && same_place(place, at));
        let bits = here.fold(0, |bits, (_, _, input)| bits | input);
        if bits.count_ones() == 1 { bits } else { 0 }
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
        let rests = |axis: usize| match own {
            Some(_) if axis == motion.axis.index() => true,
            Some(_) | None => axis != motion.axis.index() && !self.moves_in_step(step, axis),
        };
        let axes = at.iter().enumerate().filter(|&(axis, _)| rests(axis));
        axes.fold(0, |bits, (axis, &at)| bits | self.switches_at(AxisId::at(axis), at))
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
    pub fn clearance(&self, span: &StateSpan) -> Result<u128, NoClearance> {
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
            return Err(NoClearance::NothingStandsStill);
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
                return Err(NoClearance::NotSeen { op: station.steps[step][0] });
            }
        }
        Ok(still.iter().fold(0, |bits, &axis| bits | station.switches_at(AxisId::at(axis), rest[axis])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{StationId, TransferLine, parse};

    fn shipped() -> Line {
        parse("line.toml", &TransferLine::default().text()).expect("the shipped line is sound").line
    }

    fn names(station: &Station, bits: u128) -> Vec<&str> {
        let on = |(bit, _): &(usize, &String)| bits & (1 << bit) != 0;
        station.inputs.iter().enumerate().filter(on).map(|(_, name)| name.as_str()).collect()
    }

    #[test]
    fn the_conflicts_of_the_shipped_line_are_told_by_one_switch_on_each_side() {
        let line = shipped();
        let of =
            |span: &StateSpan| names(line.station(span.station), line.clearance(span).expect("measured")).join(" ");
        let sides: Vec<(String, String)> = line.conflicts.iter().map(|c| (of(&c.a), of(&c.b))).collect();
        let pair = |a: &str, b: &str| (a.to_owned(), b.to_owned());
        assert_eq!(sides, [pair("LS_vertical_0", "LS_open"), pair("LS_positioning_0", "LS_closed")]);
    }

    #[test]
    fn at_rest_every_axis_is_measured_and_under_way_all_but_the_one_that_moves() {
        let line = shipped();
        let bar = &line.stations[0];
        let at = |place| names(bar, bar.rest_inputs(place));
        let op = |name| bar.operation_named(name).expect("it has it");
        assert_eq!(at(StationPlace::completed(bar.home)), ["LS_vertical_0", "LS_horizontal_0"]);
        assert_eq!(at(StationPlace::operating(op("advance transfer"))), ["LS_vertical_200"]);
        assert_eq!(at(StationPlace::incomplete(op("advance transfer"))), ["LS_vertical_200"]);
        assert_eq!(at(StationPlace::undone(op("advance transfer"))), ["LS_vertical_200", "LS_horizontal_0"]);
        assert_eq!(at(StationPlace::completed(op("2nd lower"))), ["LS_vertical_100", "LS_horizontal_500"]);
    }

    #[test]
    fn the_switch_that_a_motion_leaves_is_that_of_its_other_end() {
        let line = shipped();
        let behind = |station: usize, op: &str, block| {
            let station = &line.stations[station];
            names(station, station.switch_left_behind(station.operation_named(op).expect("it has it"), block)).join(" ")
        };
        assert_eq!(behind(1, "advance clamp", Block::Normal), "LS_open");
        assert_eq!(behind(1, "advance clamp", Block::Recovery), "LS_closed");
        assert_eq!(behind(0, "2nd lift", Block::Normal), "LS_vertical_50");
        assert_eq!(behind(0, "2nd lift", Block::Recovery), "LS_vertical_100");
    }

    #[test]
    fn a_state_outside_which_its_axis_moves_is_not_told_by_switches() {
        let line = shipped();
        let bar = &line.stations[0];
        let op = |name| bar.operation_named(name).expect("it has it");
        // Outside it the bar also lifts to 50 and back from there.
        let span = StateSpan { station: StationId(0), from: op("2nd lift"), until: op("3rd lower") };
        assert_eq!(line.clearance(&span), Err(NoClearance::NothingStandsStill));
    }

    #[test]
    fn a_state_in_which_a_mechanism_returns_to_where_it_stands_outside_is_not_told_by_switches() {
        let line = shipped();
        let clamp = &line.stations[1];
        // All of its cycle but the rest at home: open at both ends, and open once more in no place between.
        let all = StateSpan { station: StationId(1), from: OpId(1), until: OpId(0) };
        assert_eq!(names(clamp, line.clearance(&all).expect("measured")), ["LS_open"]);
        // The mill's main slide stands at 60 while the positioning slide returns to 0 inside this state.
        let mill = &line.stations[2];
        let op = |name| mill.operation_named(name).expect("it has it");
        let whole = StateSpan {
            station: StationId(2),
            from: op("rapid advance positioning slide"),
            until: op("reset main slide"),
        };
        let inputs = line.clearance(&whole).expect("the two slides together tell it");
        assert_eq!(names(mill, inputs), ["LS_positioning_0", "LS_main_0"]);
    }

    #[test]
    fn a_table_is_told_from_under_way_by_the_switch_it_begins_and_ends_at() {
        let text = include_str!("../../../examples/rotary-table.toml");
        let line = parse("rotary-table.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line;
        let table = &line.stations[0];
        let told = line.clearance(&line.conflicts[0].a).expect("its switch is off under way");
        assert_eq!(names(table, told), ["LS_in_place"]);
        let index = table.home;
        let at = |place| names(table, table.rest_inputs(place));
        assert_eq!(at(StationPlace::completed(index)), ["LS_in_place"]);
        assert_eq!((at(StationPlace::operating(index)), at(StationPlace::incomplete(index))), (vec![], vec![]));
        assert_eq!(table.measured_after(0), Some(told));
        assert_eq!(table.measured_within(index), Some(0));
        // In a longer state it would be on at the end of the index as well, which is inside.
        let mut line = line;
        let mut drill = line.stations[2].operations[1].clone();
        drill.motion.axis = AxisId(1);
        line.stations[0].axes.push(crate::Axis { name: "spindle".to_owned(), home: 0.0, index: None });
        line.stations[0].operations.push(drill);
        line.stations[0].steps.push(vec![OpId(1)]);
        let span = StateSpan { station: StationId(0), from: OpId(0), until: OpId(1) };
        assert!(line.clearance(&span).is_err());
    }

    /// Inside the state the one slide comes back to where it stands outside, and the other one, at the same time, leaves it.
    #[test]
    fn two_axes_that_change_over_in_one_step_do_not_tell_the_state() {
        let mut line = shipped();
        let mill = &line.stations[2];
        let op = |name| mill.operation_named(name).expect("it has it");
        let span = StateSpan {
            station: StationId(2),
            from: op("rapid advance positioning slide"),
            until: op("reset main slide"),
        };
        assert!(line.clearance(&span).is_ok());
        // Out; over to the other slide, both at once; back.
        let station = &mut line.stations[2];
        let way = |axis: u16, from: f64, to: f64| Motion { axis: AxisId(axis), from, to };
        let ways = [way(0, 0.0, 100.0), way(0, 100.0, 0.0), way(1, 0.0, 60.0), way(1, 60.0, 30.0), way(1, 30.0, 0.0)];
        // A switch for each place of each slide.
        let mut switches = Vec::new();
        let mut switch = |axis: AxisId, at: f64| {
            let nth = switches.iter().position(|known| *known == (axis, at)).unwrap_or_else(|| {
                switches.push((axis, at));
                switches.len() - 1
            });
            crate::InputId::at(station.inputs.len() + nth)
        };
        for (operation, motion) in station.operations.iter_mut().zip(ways) {
            operation.motion = motion;
            operation.normal.complete = switch(motion.axis, motion.to);
            if let OperationModule::Reversible { recovery, .. } = &mut operation.module {
                recovery.complete = switch(motion.axis, motion.from);
            }
        }
        station.steps = vec![vec![OpId(0)], vec![OpId(1), OpId(2)], vec![OpId(3)], vec![OpId(4)]];
        assert_eq!(line.clearance(&span), Err(NoClearance::NotSeen { op: OpId(1) }));
        // One after the other, the first one first out again, is measured.
        line.stations[2].steps = vec![vec![OpId(0), OpId(2)], vec![OpId(1)], vec![OpId(3)], vec![OpId(4)]];
        assert!(line.clearance(&span).is_ok());
    }

    #[test]
    fn a_place_that_two_inputs_tell_of_cannot_be_read_off() {
        let mut line = shipped();
        let clamp = &line.stations[1];
        let op = |name| clamp.operation_named(name).expect("it has it");
        let (opened, closes) = (clamp.step_of(op("return clamp")), op("advance clamp"));
        assert_eq!(clamp.measured_after(opened).map(|bits| names(clamp, bits)), Some(vec!["LS_open"]));
        assert_eq!(clamp.measured_within(closes).map(|bits| names(clamp, bits)), Some(vec![]));
        // Undone, the clamp is open by another switch than after its return.
        let station = &mut line.stations[1];
        let other = crate::InputId::at(station.inputs.len());
        station.inputs.push("LS_open_2".to_owned());
        if let OperationModule::Reversible { recovery, .. } = &mut station.operations[closes.index()].module {
            recovery.complete = other;
        }
        assert_eq!(line.stations[1].measured_after(opened), None);
    }
}
