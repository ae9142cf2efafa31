//! The order in which the stations of one activity do their operations: it is undone in reverse.
//!
//! A robot lets go when the clamp has closed. So the clamp is not opened before the hand has closed again, in whichever order the
//! buttons would take less time. Which operation waits for which of another station follows from the inputs that it waits for, and
//! from what these see: the tasks are played once by the chart, and what has moved an axis last to where an input sees it has to be done
//! first. Two stations of which no input of the one sees the other keep the order of the chart by time. Where one of them waits for an input
//! of which the description does not say what it sees, that order would be a guess: then there is none.

use std::time::Duration;

use linewright_line::{AxisId, Grip, InputId, Line, OpId, Sign, Stand, StationId, TaskId};

/// An operation of a station.
type OpOf = (StationId, OpId);

/// Two operations of different stations, of which the second one begins when the first one is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct OrderedPair {
    pub first: OpOf,
    pub then: OpOf,
}

/// All pairs of tasks that stations do at the same time; none where the description does not tell the order.
pub(crate) fn pairs(line: &Line, tasks: &[(StationId, TaskId)]) -> Option<Vec<OrderedPair>> {
    let mut chart = Chart::new(line, tasks);
    while chart.step() {}
    let Chart { done, mut pairs, .. } = chart;
    let is_seen = |station: StationId, input: InputId| {
        line.handling.sensors.iter().any(|sensor| (sensor.station, sensor.input) == (station, input))
    };
    // The chart assumes that each motion has its result.
    let waits_unseen = |of: &ChartedOp| line.operation(of.op).waits.iter().any(|&input| !is_seen(of.op.0, input));
    // What starts by such an input is too early in the chart, and so is all that follows from it.
    if tasks.len() > 1 && done.iter().any(waits_unseen) {
        return None;
    }
    let is_of = |pair: &OrderedPair, a: StationId, b: StationId| {
        let both = (pair.first.0, pair.then.0);
        both == (a, b) || both == (b, a)
    };
    let known = pairs.clone();
    for first in &done {
        for then in done.iter().filter(|then| then.op.0 != first.op.0 && first.end <= then.start) {
            if !known.iter().any(|pair| is_of(pair, first.op.0, then.op.0)) {
                pairs.push(OrderedPair { first: first.op, then: then.op });
            }
        }
    }
    Some(pairs)
}

/// An operation as it was played.
struct ChartedOp {
    op: OpOf,
    start: Duration,
    end: Duration,
}

/// A task that is played.
struct ChartedTask {
    station: StationId,
    steps: std::ops::Range<usize>,
    /// The end of the step under way.
    busy_until: Option<Duration>,
    /// Position of each axis; none while it moves.
    at: Vec<Option<f64>>,
    /// The operation that has moved each axis last.
    moved_by: Vec<Option<OpId>>,
}

/// The tasks without faults, as soon as what they wait for is so.
struct Chart<'l> {
    line: &'l Line,
    now: Duration,
    tasks: Vec<ChartedTask>,
    done: Vec<ChartedOp>,
    pairs: Vec<OrderedPair>,
}

impl<'l> Chart<'l> {
    fn new(line: &'l Line, tasks: &[(StationId, TaskId)]) -> Self {
        let charted = |&(station, task): &(StationId, TaskId)| {
            let of = line.station(station);
            let steps = of.task(task).steps.clone();
            ChartedTask {
                station,
                busy_until: None,
                at: of.positions_before_steps()[steps.start].iter().copied().map(Some).collect(),
                moved_by: vec![None; of.axes.len()],
                steps,
            }
        };
        let tasks = tasks.iter().map(charted).collect();
        Chart { line, now: Duration::ZERO, tasks, done: Vec::new(), pairs: Vec::new() }
    }

    /// Begins whatever can begin, then goes on to the next end. False when all is done.
    fn step(&mut self) -> bool {
        let ready = |of: &ChartedTask| of.busy_until.is_none() && !of.steps.is_empty();
        let free: Vec<usize> = (0..self.tasks.len()).filter(|&at| ready(&self.tasks[at])).collect();
        let can_begin = |at: &&usize| self.awaited(**at).iter().all(|stand| self.holds(stand));
        let begun: Vec<usize> = free.iter().filter(can_begin).copied().collect();
        begun.into_iter().for_each(|at| self.begin(at));
        let next = self.tasks.iter().filter_map(|of| of.busy_until).min();
        match (next, free.first()) {
            (Some(end), _) => self.end(end),
            // What it waits for does not come by these tasks.
            (None, Some(&at)) => self.begin(at),
            (None, None) => return false,
        }
        true
    }

    /// What axes of the tasks have to stand for the inputs to be on for which the next step waits.
    fn awaited(&self, at: usize) -> Vec<Stand> {
        let ChartedTask { station, ref steps, .. } = self.tasks[at];
        let ops = &self.line.station(station).steps[steps.start];
        let inputs = ops.iter().flat_map(|&op| self.line.station(station).awaited_by(op));
        let flow = &self.line.handling;
        let seen = inputs
            .filter_map(|input| flow.sensors.iter().find(|sensor| (sensor.station, sensor.input) == (station, input)));
        let stand = |sign: &Sign| match sign {
            Sign::Stands(stand) => Some(*stand),
            // A part in a hand: while it is closed. Of a nest no axis shows whether there is one.
            Sign::Part(holder) => match flow.holder(*holder).grip {
                Grip::Hand(stand) => Some(stand),
                Grip::Clamp(_) | Grip::Loose => None,
            },
        };
        seen.flat_map(|sensor| sensor.when.iter().filter_map(stand)).collect()
    }

    fn task_of(&self, station: StationId) -> Option<&ChartedTask> {
        self.tasks.iter().find(|of| of.station == station)
    }

    /// Whether an axis stands so; an axis of no task is taken to.
    fn holds(&self, stand: &Stand) -> bool {
        let is_there = |at: Option<f64>| at.is_some_and(|at| (at - stand.at).abs() < SAME_PLACE);
        self.task_of(stand.station).is_none_or(|of| is_there(of.at[stand.axis.index()]))
    }

    /// The operation that has moved an axis last.
    fn moved_by(&self, station: StationId, axis: AxisId) -> Option<OpId> {
        self.task_of(station)?.moved_by[axis.index()]
    }

    fn begin(&mut self, at: usize) {
        let awaited = self.awaited(at);
        let station = self.tasks[at].station;
        let ops = self.line.station(station).steps[self.tasks[at].steps.start].clone();
        let others = awaited.iter().filter(|stand| stand.station != station && self.holds(stand));
        let causes: Vec<OpOf> =
            others.filter_map(|of| Some((of.station, self.moved_by(of.station, of.axis)?))).collect();
        let mut last = self.now;
        for op in ops {
            let operation = self.line.operation((station, op));
            self.pairs.extend(causes.iter().map(|&first| OrderedPair { first, then: (station, op) }));
            let end = self.now + operation.duration;
            self.done.push(ChartedOp { op: (station, op), start: self.now, end });
            self.tasks[at].at[operation.motion.axis.index()] = None;
            last = last.max(end);
        }
        self.tasks[at].busy_until = Some(last);
    }

    fn end(&mut self, end: Duration) {
        self.now = end;
        let line = self.line;
        for of in self.tasks.iter_mut().filter(|of| of.busy_until == Some(end)) {
            let Some(step) = of.steps.next() else { continue };
            for &op in &line.station(of.station).steps[step] {
                let motion = line.operation((of.station, op)).motion;
                of.at[motion.axis.index()] = Some(motion.to);
                of.moved_by[motion.axis.index()] = Some(op);
            }
            of.busy_until = None;
        }
    }
}

/// Coordinates nearer than this are one place.
const SAME_PLACE: f64 = 1e-6;
