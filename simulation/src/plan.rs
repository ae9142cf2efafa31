//! Cycle time by the description alone: durations and arrows, no controllers, no messages.
//!
//! The timing bar chart is an event graph: an operation starts when the step before it in its own station is complete,
//! and every operation with an arrow for auto into it, or into another of its group, in the cycle the arrow names.
//! [`LinePlan::schedule`] is its earliest schedule from home; [`LinePlan::cycle_time`] what it needs per cycle in the long run,
//! the largest ratio of duration to cycles crossed over all circuits of the graph (Ramamoorthy and Ho, 1980). The ratio
//! is found exactly: a circuit that beats the best ratio so far is a circuit of positive length when every edge is
//! charged that ratio per cycle it crosses.

use linewright_line::{Line, OpId, StationId};

/// An operation of the line.
type Op = (StationId, OpId);

/// An edge of the event graph: `to` in cycle c starts no earlier than `from` in cycle c − `lag` ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct EventGraphEdge {
    from: usize,
    to: usize,
    lag: u32,
}

/// Start and end of one operation in one cycle, in µs after the line began to move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlannedTimes {
    pub start: u64,
    pub end: u64,
}

/// The longest circuit of the event graph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Circuit {
    /// Its operations, in order; the last leads on to the first.
    pub operations: Vec<Op>,
    /// Their durations together, in microseconds.
    pub micros: u64,
    /// The cycles it crosses, at least one.
    pub cycles: u64,
}

/// The event graph of a line.
#[derive(Clone, Debug)]
pub struct LinePlan {
    ops: Vec<Op>,
    /// First operation of each station in `ops`.
    first: Vec<usize>,
    durations: Vec<u64>,
    /// Counts of each operation at home: those cycles are done.
    base: Vec<i32>,
    edges: Vec<EventGraphEdge>,
    /// Operations in an order in which every edge without lag leads onward.
    order: Vec<usize>,
    into: Vec<Vec<usize>>,
}

impl LinePlan {
    /// The event graph of a line.
    pub fn of(line: &Line) -> Self {
        let mut first = Vec::new();
        let mut ops = Vec::new();
        for id in line.station_ids() {
            first.push(ops.len());
            ops.extend(line.station(id).op_ids().map(|op| (id, op)));
        }
        let mut edges = Vec::new();
        for id in line.station_ids() {
            let steps = &line.station(id).steps;
            for (at, step) in steps.iter().enumerate() {
                let before = &steps[(at + steps.len() - 1) % steps.len()];
                for (from, to) in before.iter().flat_map(|from| step.iter().map(move |to| (from, to))) {
                    let index = |op: &OpId| first[id.index()] + op.index();
                    edges.push(EventGraphEdge { from: index(from), to: index(to), lag: u32::from(at == 0) });
                }
            }
        }
        let index = |(id, op): Op| first[id.index()] + op.index();
        for arrow in line.arrows.iter().filter(|arrow| arrow.auto) {
            let (station, op) = arrow.to;
            let described = line.station(station);
            // A group starts together, so it waits for the arrows into each of its members.
            let group = &described.steps[described.step_of(op)];
            edges.extend(group.iter().map(|&op| EventGraphEdge {
                from: index(arrow.from),
                to: index((station, op)),
                lag: arrow.lag,
            }));
        }
        let mut into = vec![Vec::new(); ops.len()];
        for (at, edge) in edges.iter().enumerate() {
            into[edge.to].push(at);
        }
        let base = |&(id, op): &Op| line.station(id).home_count(op, line.station(id).initial_round());
        LinePlan {
            durations: ops.iter().map(|&op| line.operation(op).duration.as_micros() as u64).collect(),
            base: ops.iter().map(base).collect(),
            order: onward(ops.len(), &edges),
            ops,
            first,
            edges,
            into,
        }
    }

    fn index(&self, (id, op): Op) -> usize {
        self.first[id.index()] + op.index()
    }

    /// The earliest schedule from home, until every operation has been done `cycles` times.
    pub fn schedule(&self, cycles: usize) -> EarliestSchedule {
        let cycles = i32::try_from(cycles).unwrap_or(i32::MAX / 2);
        let lowest = self.base.iter().copied().min().unwrap_or(0);
        let highest = self.base.iter().copied().max().unwrap_or(0) + cycles;
        let mut ends: Vec<Vec<u64>> = Vec::new();
        let mut starts = Vec::new();
        for cycle in lowest + 1..=highest {
            let mut start = vec![0; self.ops.len()];
            let mut end = vec![0; self.ops.len()];
            for &op in &self.order {
                if cycle <= self.base[op] {
                    continue;
                }
                let due = |&at: &usize| {
                    let EventGraphEdge { from, lag, .. } = self.edges[at];
                    match lag {
                        0 => end[from],
                        // What came before the first cycle is done.
                        _ => ends.len().checked_sub(lag as usize).map_or(0, |at| ends[at][from]),
                    }
                };
                start[op] = self.into[op].iter().map(due).max().unwrap_or(0);
                end[op] = start[op] + self.durations[op];
            }
            starts.push(start);
            ends.push(end);
        }
        EarliestSchedule { lowest, starts, ends }
    }

    /// When an operation is planned in a cycle; `None` for a cycle that the schedule does not reach or that was done
    /// at home.
    pub fn planned(&self, schedule: &EarliestSchedule, op: Op, cycle: i32) -> Option<PlannedTimes> {
        let at = self.index(op);
        let row = usize::try_from(cycle - schedule.lowest - 1).ok()?;
        (cycle > self.base[at]).then_some(())?;
        Some(PlannedTimes { start: *schedule.starts.get(row)?.get(at)?, end: schedule.ends[row][at] })
    }

    /// The circuit with the largest ratio of duration to cycles crossed.
    pub fn longest_circuit(&self) -> Option<Circuit> {
        let mut best: Option<Circuit> = None;
        loop {
            let (micros, cycles) = best.as_ref().map_or((0, 1), |c| (c.micros, c.cycles));
            match self.better_than(micros, cycles) {
                Some(circuit) => best = Some(circuit),
                None => return best,
            }
        }
    }

    /// Long-run cycle time, in µs.
    pub fn cycle_time(&self) -> f64 {
        self.longest_circuit().map_or(0.0, |circuit| circuit.micros as f64 / circuit.cycles as f64)
    }

    /// A circuit whose ratio is above `micros` / `cycles`, if there is one: longest paths by relaxation, which do not
    /// settle where a circuit of positive length feeds them.
    fn better_than(&self, micros: u64, cycles: u64) -> Option<Circuit> {
        let length = |edge: &EventGraphEdge| {
            i128::from(self.durations[edge.from]) * i128::from(cycles) - i128::from(micros) * i128::from(edge.lag)
        };
        let mut distance = vec![0i128; self.ops.len()];
        let mut by = vec![usize::MAX; self.ops.len()];
        let mut changed = None;
        for _ in 0..=self.ops.len() {
            changed = None;
            for (at, edge) in self.edges.iter().enumerate() {
                let along = distance[edge.from] + length(edge);
                if along > distance[edge.to] {
                    distance[edge.to] = along;
                    by[edge.to] = at;
                    changed = Some(edge.to);
                }
            }
            changed?;
        }
        let mut node = changed?;
        // As many steps back as there are nodes lead into the circuit.
        for _ in 0..self.ops.len() {
            node = self.edges[by[node]].from;
        }
        let (start, mut operations, mut lag) = (node, Vec::new(), 0);
        loop {
            let edge = self.edges[by[node]];
            node = edge.from;
            lag += u64::from(edge.lag);
            operations.push(node);
            if node == start {
                break;
            }
        }
        operations.reverse();
        let micros = operations.iter().map(|&op| self.durations[op]).sum();
        let operations = operations.into_iter().map(|op| self.ops[op]).collect();
        // A circuit without lag would be a deadlock, which no checked line has.
        (lag > 0).then_some(Circuit { operations, micros, cycles: lag })
    }
}

#[derive(Clone, Debug)]
pub struct EarliestSchedule {
    lowest: i32,
    starts: Vec<Vec<u64>>,
    ends: Vec<Vec<u64>>,
}

/// The operations in an order in which every edge without lag leads onward (Kahn). Those on a circuit without lag, of
/// which a checked line has none, are left out.
fn onward(count: usize, edges: &[EventGraphEdge]) -> Vec<usize> {
    let mut waits = vec![0usize; count];
    for edge in edges.iter().filter(|edge| edge.lag == 0) {
        waits[edge.to] += 1;
    }
    let mut order: Vec<usize> = (0..count).filter(|&op| waits[op] == 0).collect();
    let mut next = 0;
    while next < order.len() {
        let from = order[next];
        next += 1;
        for edge in edges.iter().filter(|edge| edge.lag == 0 && edge.from == from) {
            waits[edge.to] -= 1;
            if waits[edge.to] == 0 {
                order.push(edge.to);
            }
        }
    }
    order
}
