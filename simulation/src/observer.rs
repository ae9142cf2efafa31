//! Has a conflict of the description happened? Decided by where the mechanisms stand, and by nothing else.
//!
//! A conflict names a stretch of each station's cycle. Outside of that stretch the chart leads the station's axes along
//! certain ways: each operation along its own, several at once along their common box. A station on none of these ways
//! is in the stretch. Where the same positions belong to the stretch and to the rest of the cycle, positions cannot tell
//! them apart; the observer then reports nothing, so its reports are certain and its silence is not.
//!
//! It looks whenever a motion of one of the two begins, ends or passes a switch, and judges the way covered since it
//! looked last. Two stretches touched between the same two looks count as held together. That errs on the safe side, and
//! an honest line never comes near it: what follows a motion waits for its switch, and the switch is a look.

use linewright_line::{AxisId, Conflict, Line, OpId, StateSpan, StationId, Tick};
use linewright_plant::Plant;

/// As part of an operation's way: an axis within this of where it should be is there. A switch is on within a
/// thousandth, and a motion stopped by its switch stands at the edge of that.
const TOLERANCE: f64 = 0.002;

/// For each axis of a station, its range.
type Ranges = Vec<(f64, f64)>;

/// One station's part in a conflict.
#[derive(Clone)]
struct ObservedSide {
    station: StationId,
    axes: usize,
    /// Ranges of the rest of the cycle.
    outside: Vec<Ranges>,
    before: Vec<f64>,
    now: Vec<f64>,
}

/// A conflict that happened.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenConflict {
    /// Time of the observation.
    pub at: Tick,
    /// The conflict, by its place in [`Line::conflicts`].
    pub conflict: usize,
    /// Positions of the axes, in words.
    pub positions: String,
}

/// The observer of all conflicts of a line.
#[derive(Clone)]
pub struct ConflictObserver {
    pairs: Vec<[ObservedSide; 2]>,
    holds: Vec<bool>,
    /// By station: the conflicts it takes part in.
    of: Vec<Vec<usize>>,
    seen: Vec<SeenConflict>,
}

/// Enough to understand a run; one conflict is too many already.
const SEEN_MAX: usize = 100;

impl ConflictObserver {
    /// An observer that begins at the present positions; `plant_of` gives the plant with a station's mechanisms.
    pub fn new<'p>(line: &Line, plant_of: impl Fn(StationId) -> &'p Plant) -> Self {
        let side = |span: &StateSpan| side(line, plant_of(span.station), span);
        let pair = |conflict: &Conflict| [side(&conflict.a), side(&conflict.b)];
        let takes_part = |id: StationId| {
            let conflicts = line.conflicts.iter().enumerate();
            conflicts.filter(|(_, c)| c.a.station == id || c.b.station == id).map(|(at, _)| at).collect()
        };
        ConflictObserver {
            pairs: line.conflicts.iter().map(pair).collect(),
            holds: vec![false; line.conflicts.len()],
            of: line.station_ids().map(takes_part).collect(),
            seen: Vec::new(),
        }
    }

    /// Looks at the conflicts of a station, whose motion has begun, ended or passed a switch.
    pub fn look<'p>(&mut self, line: &Line, plant_of: impl Fn(StationId) -> &'p Plant, station: usize) {
        for at in 0..self.of[station].len() {
            self.look_at(line, &plant_of, self.of[station][at]);
        }
    }

    /// Looks at every conflict.
    pub fn look_everywhere<'p>(&mut self, line: &Line, plant_of: impl Fn(StationId) -> &'p Plant) {
        for at in 0..self.pairs.len() {
            self.look_at(line, &plant_of, at);
        }
    }

    fn look_at<'p>(&mut self, line: &Line, plant_of: &impl Fn(StationId) -> &'p Plant, at: usize) {
        let [a, b] = &mut self.pairs[at];
        let holds = a.look(plant_of(a.station)) & b.look(plant_of(b.station));
        if holds && !self.holds[at] && self.seen.len() < SEEN_MAX {
            let positions = format!("{}; {}", a.text(line), b.text(line));
            self.seen.push(SeenConflict { at: plant_of(a.station).now(), conflict: at, positions });
        }
        self.holds[at] = holds;
    }

    /// What has been seen, as far as it is kept.
    pub fn seen(&self) -> &[SeenConflict] {
        &self.seen
    }
}

impl ObservedSide {
    /// Whether the stretch was touched since the last look.
    fn look(&mut self, plant: &Plant) -> bool {
        std::mem::swap(&mut self.before, &mut self.now);
        for axis in 0..self.axes {
            self.now[axis] = plant.position(self.station, AxisId::at(axis));
        }
        !self.outside.iter().any(|ranges| {
            ranges.iter().enumerate().all(|(axis, &(low, high))| {
                let (before, now) = (self.before[axis], self.now[axis]);
                low <= before.min(now) && before.max(now) <= high
            })
        })
    }

    fn text(&self, line: &Line) -> String {
        let described = line.station(self.station);
        let axis = |(axis, at): (&linewright_line::Axis, &f64)| format!("{} at {at:.1}", axis.name);
        let axes: Vec<String> = described.axes.iter().zip(&self.now).map(axis).collect();
        format!("{}: {}", described.name, axes.join(", "))
    }
}

fn side(line: &Line, plant: &Plant, span: &StateSpan) -> ObservedSide {
    let described = line.station(span.station);
    let axes = described.axes.len();
    let here: Vec<f64> = (0..axes).map(|axis| plant.position(span.station, AxisId::at(axis))).collect();
    ObservedSide { station: span.station, axes, outside: outside(line, span), before: here.clone(), now: here }
}

/// Walks the cycle, or the tasks, once and collects where it leads outside of the stretch.
fn outside(line: &Line, span: &StateSpan) -> Vec<Ranges> {
    let described = line.station(span.station);
    let slack = slacks(line, span.station);
    let count = described.steps.len();
    let (from, until) = (described.step_of(span.from), described.step_of(span.until));
    // Position of a step in the stretch; the stretch may cross the boundary of the cycle.
    let length = (until + count - from) % count;
    let mut outside = Vec::new();
    for (step, before) in described.positions_before_steps().into_iter().enumerate() {
        let inside = (step + count - from) % count <= length;
        let mut at = before.clone();
        for &OpId(op) in &described.steps[step] {
            let motion = described.operations[usize::from(op)].motion;
            at[motion.axis.index()] = motion.to;
        }
        let widen = |(axis, (a, b)): (usize, (&f64, &f64))| (a.min(*b) - slack[axis], a.max(*b) + slack[axis]);
        let way = |a: &[f64], b: &[f64]| a.iter().zip(b).enumerate().map(widen).collect::<Ranges>();
        if inside {
            // Where the stretch begins and ends the station is not yet, or no longer, in it, wherever what else moves in that step is.
            let with = |op: OpId, from: &[f64], other: &[f64]| {
                let axis = described.operations[op.index()].motion.axis.index();
                let mut with = other.to_vec();
                with[axis] = from[axis];
                with
            };
            if step == from {
                outside.push(way(&before, &with(span.from, &before, &at)));
            }
            if step == until {
                outside.push(way(&with(span.until, &at, &before), &at));
            }
        } else {
            outside.push(way(&before, &at));
        }
    }
    outside
}

/// Tolerance of the position of each axis.
fn slacks(line: &Line, station: StationId) -> Vec<f64> {
    let described = line.station(station);
    let way = |axis: usize| {
        let motions = described.operations.iter().map(|operation| operation.motion);
        let ways = motions.filter(|m| m.axis.index() == axis).map(|m| (m.to - m.from).abs());
        ways.chain(described.axes[axis].index).fold(0.0, f64::max)
    };
    (0..described.axes.len()).map(|axis| way(axis) * TOLERANCE).collect()
}
