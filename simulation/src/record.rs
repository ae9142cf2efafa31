//! What a run leaves behind: every motion with its cause, counts, cycles, waits, faults.
//!
//! It listens to the stations' events and to what each station has heard when. The cause of a start is the last thing
//! that had to come true for it: the operation before it in its own station, or an arrow, at the moment at which the
//! station heard that the arrow's tail is done. Nothing here is asked of a controller.

use std::collections::VecDeque;
use std::time::Duration;

use linewright_line::net::Block;
use linewright_line::{Line, OpId, StationId, Tick};
use linewright_station_logic::{Cause, Event, Happening, Report};

/// What a motion waited for last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// The step before it in its own station.
    Previous,
    /// An arrow, by its place in [`Line::arrows`].
    Arrow(usize),
    /// Neither: a mode, a button, a person.
    Person,
}

/// How a motion ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Not yet.
    Open,
    /// At its end.
    Done,
    /// Before its end.
    Stopped(Cause),
}

/// One motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Whose.
    pub station: StationId,
    /// Of which operation.
    pub op: OpId,
    /// Forward, or being undone.
    pub block: Block,
    /// The station's cycle.
    pub cycle: i32,
    /// When it began.
    pub start: Tick,
    /// When it ended; meaningless while it is open.
    pub end: Tick,
    /// How.
    pub ended: Ended,
    /// What it waited for last.
    pub by: By,
    /// When the step before it was complete.
    pub ready: Tick,
}

/// How long starts have waited for an arrow after everything in their own station was ready.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wait {
    /// How many starts.
    pub starts: u64,
    /// Together.
    pub total: Duration,
}

/// A motion that stopped on a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaultSeen {
    /// When.
    pub at: Tick,
    /// Whose.
    pub station: StationId,
    /// Of which operation.
    pub op: OpId,
    /// Why.
    pub cause: Cause,
}

/// A run that never ends must not eat the machine: beyond this the older half of the motions is forgotten.
const MOTIONS_MAX: usize = 200_000;
/// Faults remembered.
const FAULTS_MAX: usize = 1000;
/// For each arrow, how many counts it is remembered when they were heard: a reader is at most a cycle or two behind.
const HEARD_MAX: usize = 8;

/// The record of a run.
#[derive(Clone, Debug)]
pub struct Record {
    motions: Vec<Motion>,
    forgotten: usize,
    open: Vec<Vec<Option<usize>>>,
    done_at: Vec<Vec<Tick>>,
    base: Vec<Vec<i32>>,
    counts: Vec<Vec<i32>>,
    /// By arrow: counts of its tail, and when the reader heard them.
    heard: Vec<VecDeque<(i32, Tick)>>,
    waits: Vec<Wait>,
    /// Arrows into each operation.
    into: Vec<Vec<Vec<usize>>>,
    /// The step before each operation's.
    before: Vec<Vec<Vec<OpId>>>,
    ends: Vec<Tick>,
    /// Operations that are not yet done in the line's present cycle.
    missing: usize,
    withdrawn: u64,
    begun: Vec<usize>,
    faults: Vec<FaultSeen>,
    errors: Vec<String>,
}

impl Record {
    pub(crate) fn new(line: &Line) -> Self {
        let each = |what: &dyn Fn(StationId, OpId) -> i32| -> Vec<Vec<i32>> {
            line.station_ids().map(|id| line.station(id).op_ids().map(|op| what(id, op)).collect()).collect()
        };
        let base = each(&|id, op| line.station(id).home_count(op, line.station(id).initial_round()));
        let arrows_into = |id: StationId, op: OpId| {
            let arrows = line.arrows.iter().enumerate();
            arrows.filter(|(_, arrow)| arrow.to == (id, op)).map(|(at, _)| at).collect::<Vec<_>>()
        };
        let step_before = |id: StationId, op: OpId| {
            let station = line.station(id);
            station.steps[(station.step_of(op) + station.steps.len() - 1) % station.steps.len()].clone()
        };
        let sized = |_: StationId, station: &linewright_line::Station| station.operations.len();
        let sizes: Vec<usize> = line.station_ids().map(|id| sized(id, line.station(id))).collect();
        Record {
            motions: Vec::new(),
            forgotten: 0,
            open: sizes.iter().map(|&n| vec![None; n]).collect(),
            done_at: sizes.iter().map(|&n| vec![Tick::ZERO; n]).collect(),
            counts: base.clone(),
            base,
            heard: vec![VecDeque::with_capacity(HEARD_MAX + 1); line.arrows.len()],
            waits: vec![Wait::default(); line.arrows.len()],
            into: line
                .station_ids()
                .map(|id| line.station(id).op_ids().map(|op| arrows_into(id, op)).collect())
                .collect(),
            before: line
                .station_ids()
                .map(|id| line.station(id).op_ids().map(|op| step_before(id, op)).collect())
                .collect(),
            ends: Vec::new(),
            missing: sizes.iter().sum(),
            withdrawn: 0,
            begun: vec![0; sizes.len()],
            faults: Vec::new(),
            errors: Vec::new(),
        }
    }

    /// A station has heard a report of the tail of these arrows.
    pub(crate) fn hear(&mut self, line: &Line, now: Tick, arrows: &[usize], report: &Report) {
        for &arrow in arrows {
            let count = report.done[line.arrows[arrow].from.1.index()];
            let heard = &mut self.heard[arrow];
            while heard.back().is_some_and(|&(known, _)| known > count) {
                heard.pop_back();
            }
            if heard.back().is_none_or(|&(known, _)| known < count) {
                heard.push_back((count, now));
                if heard.len() > HEARD_MAX {
                    heard.pop_front();
                }
            }
        }
    }

    pub(crate) fn enter(&mut self, line: &Line, now: Tick, station: StationId, event: &Event) {
        match event.what {
            Happening::Started(op, block) => self.started(line, now, station, op, block, event.cycle),
            Happening::Completed(op, block) => {
                self.ended(now, station, op, Ended::Done);
                if block == Block::Normal {
                    self.completed(line, now, station, op, event.cycle);
                }
            }
            Happening::Stopped(op, _, cause) => {
                self.ended(now, station, op, Ended::Stopped(cause));
                if cause == Cause::NotAtHome {
                    self.take_back(station, 1 << op.0);
                }
                if cause.is_fault() && self.faults.len() < FAULTS_MAX {
                    self.faults.push(FaultSeen { at: now, station, op, cause });
                }
            }
            Happening::Withdrawn(ops) => self.take_back(station, ops),
            Happening::HomeAgain => {
                // The home motion at a path's end completes without a count.
                let home = line.station(station).home;
                self.ended(now, station, home, Ended::Done);
            }
            Happening::Asked(_)
            | Happening::NotAgreed { .. }
            | Happening::Refused
            | Happening::Mode(_)
            | Happening::Devices(_) => {}
        }
    }

    fn started(&mut self, line: &Line, now: Tick, station: StationId, op: OpId, block: Block, cycle: i32) {
        let done_at = &self.done_at[station.index()];
        let before = &self.before[station.index()][op.index()];
        let ready = before.iter().map(|op| done_at[op.index()]).max().unwrap_or(Tick::ZERO);
        let mut by = if ready == now { By::Previous } else { By::Person };
        if block == Block::Normal {
            let mut last = ready;
            for &arrow in &self.into[station.index()][op.index()] {
                let due = cycle - i32::try_from(line.arrows[arrow].lag).unwrap_or(i32::MAX);
                let heard = self.heard[arrow].iter().find(|(count, _)| *count >= due).map_or(Tick::ZERO, |(_, at)| *at);
                if heard > last {
                    last = heard;
                    by = if heard == now { By::Arrow(arrow) } else { By::Person };
                }
            }
            if let By::Arrow(arrow) = by {
                self.waits[arrow].starts += 1;
                self.waits[arrow].total += now.since(ready);
            }
        }
        if self.motions.len() == MOTIONS_MAX {
            self.motions.drain(..MOTIONS_MAX / 2);
            self.forgotten += MOTIONS_MAX / 2;
        }
        self.begun[station.index()] += 1;
        self.open[station.index()][op.index()] = Some(self.forgotten + self.motions.len());
        self.motions.push(Motion { station, op, block, cycle, start: now, end: now, ended: Ended::Open, by, ready });
    }

    fn ended(&mut self, now: Tick, station: StationId, op: OpId, how: Ended) {
        let open = self.open[station.index()][op.index()].take();
        if let Some(motion) = open.and_then(|at| at.checked_sub(self.forgotten)).and_then(|at| self.motions.get_mut(at))
        {
            motion.end = now;
            motion.ended = how;
        }
    }

    fn completed(&mut self, line: &Line, now: Tick, station: StationId, op: OpId, cycle: i32) {
        self.done_at[station.index()][op.index()] = now;
        let count = &mut self.counts[station.index()][op.index()];
        *count += 1;
        if *count != cycle {
            self.errors.push(format!(
                "{}: {} completed in cycle {cycle}, due was {count}",
                line.station(station).name,
                line.operation((station, op)).name
            ));
            *count = cycle;
        }
        if *count - self.base[station.index()][op.index()] == self.cycles() as i32 + 1 {
            self.missing -= 1;
            if self.missing == 0 {
                self.ends.push(now);
                self.count_missing();
            }
        }
    }

    fn take_back(&mut self, station: StationId, ops: u64) {
        for (op, count) in self.counts[station.index()].iter_mut().enumerate() {
            if ops & (1 << op) != 0 {
                *count -= 1;
                self.withdrawn += 1;
            }
        }
        self.count_missing();
    }

    fn count_missing(&mut self) {
        let cycles = self.ends.len() as i32;
        let counts = self.counts.iter().flatten().zip(self.base.iter().flatten());
        self.missing = counts.filter(|(count, base)| **count - **base <= cycles).count();
    }

    /// The cycles of the line that have ended: every operation of every station has been done that many times, as it
    /// stands. A cycle that has ended stays so, even if somebody takes its last operation back.
    pub fn cycles(&self) -> usize {
        self.ends.len()
    }

    /// When each of them ended.
    pub fn cycle_ends(&self) -> &[Tick] {
        &self.ends
    }

    /// The motions, in the order in which they began; of a very long run the latest.
    pub fn motions(&self) -> &[Motion] {
        &self.motions
    }

    /// The last cycle in which an operation is done and not taken back.
    pub fn count(&self, station: StationId, op: OpId) -> i32 {
        self.counts[station.index()][op.index()]
    }

    /// What an operation counted when the line was switched on.
    pub fn base(&self, station: StationId, op: OpId) -> i32 {
        self.base[station.index()][op.index()]
    }

    /// How many motions a station has begun.
    pub fn begun(&self, station: StationId) -> usize {
        self.begun[station.index()]
    }

    /// By arrow of the description: who waited for it.
    pub fn waits(&self) -> &[Wait] {
        &self.waits
    }

    /// Counts taken back.
    pub fn withdrawn(&self) -> u64 {
        self.withdrawn
    }

    /// Motions that stopped on a fault.
    pub fn faults(&self) -> &[FaultSeen] {
        &self.faults
    }

    /// Cycles lost or doubled: a bug of the controllers, if ever.
    pub fn errors(&self) -> &[String] {
        &self.errors
    }
}
