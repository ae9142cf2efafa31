//! Record of a run: every motion with its cause, counts, cycles, waits, faults.
//!
//! It takes the stations' events and the reports received by each, with times. The cause of a start is the last thing
//! that had to come true for it: the operation before it in its own station, or an arrow, at the moment at which the
//! station received that the arrow's tail is done. Nothing here comes from a controller's state.

use std::collections::VecDeque;
use std::time::Duration;

use linewright_line::net::{Block, ControlMode};
use linewright_line::{Line, OpId, StationId, Tick};
use linewright_station_logic::{HappeningKind, StationHappening, StationReport, StopCause};

use crate::idle::Idle;

/// Last wait of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LastWait {
    /// The step before it in its own station.
    Previous,
    /// An arrow, by its place in [`Line::arrows`].
    Arrow(usize),
    /// Neither: a mode, a button, a person.
    Person,
}

/// End of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionEnd {
    /// Not yet.
    Open,
    Done,
    /// Before its end.
    Stopped(StopCause),
}

/// One motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedMotion {
    pub station: StationId,
    /// Its operation.
    pub op: OpId,
    /// Forward, or being undone.
    pub block: Block,
    /// The station's cycle.
    pub cycle: i32,
    pub start: Tick,
    /// End; meaningless while it is open.
    pub end: Tick,
    pub ended: MotionEnd,
    pub by: LastWait,
}

/// Time that starts in auto have waited for an arrow after everything in their own station was ready, without time of
/// the station in other modes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ArrowWait {
    pub starts: u64,
    /// Together.
    pub total: Duration,
}

/// A motion that stopped on a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaultSeen {
    /// Time of the event, in µs of the caller's clock.
    pub at: Tick,
    pub station: StationId,
    /// Its operation.
    pub op: OpId,
    pub cause: StopCause,
}

/// Bound of the memory of an endless run: beyond this the older half of the motions is dropped.
const MOTIONS_MAX: usize = 200_000;
/// Faults remembered.
const FAULTS_MAX: usize = 1000;
/// Number of counts kept for each arrow, with times of arrival: a reader is at most a cycle or two behind.
const HEARD_MAX: usize = 8;

#[derive(Clone, Debug)]
pub struct RunRecord {
    motions: Vec<RecordedMotion>,
    forgotten: usize,
    open: Vec<Vec<Option<usize>>>,
    done_at: Vec<Vec<Tick>>,
    /// Time each station had been out of auto when an operation was done.
    idle_at: Vec<Vec<Duration>>,
    idle: Vec<Idle>,
    /// Start of the first motion.
    began: Option<Tick>,
    /// Something has kept the line's present cycle from going its way.
    is_disturbed: bool,
    undisturbed: Vec<bool>,
    /// Counts of stations at home.
    home: Vec<Vec<i32>>,
    /// Counts before the line's first cycle.
    base: Vec<Vec<i32>>,
    /// Stations whose counts are valid; not those that have lost their memory, until they are founded anew.
    is_counted: Vec<bool>,
    counts: Vec<Vec<i32>>,
    /// By arrow: counts of its tail, and when the reader received them.
    heard: Vec<VecDeque<(i32, Tick)>>,
    waits: Vec<ArrowWait>,
    /// Arrows into each operation and into the others of its group, with which it starts.
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

impl RunRecord {
    pub(crate) fn new(line: &Line) -> Self {
        let each = |what: &dyn Fn(StationId, OpId) -> i32| -> Vec<Vec<i32>> {
            line.station_ids().map(|id| line.station(id).op_ids().map(|op| what(id, op)).collect()).collect()
        };
        let base = each(&|id, op| line.station(id).home_count(op, line.station(id).initial_round()));
        let arrows_into = |id: StationId, op: OpId| {
            let arrows = line.arrows.iter().enumerate();
            let step = |op: OpId| line.station(id).step_of(op);
            let joins = |to: (StationId, OpId)| to.0 == id && step(to.1) == step(op);
            arrows.filter(|(_, arrow)| joins(arrow.to)).map(|(at, _)| at).collect::<Vec<_>>()
        };
        let step_before = |id: StationId, op: OpId| {
            let station = line.station(id);
            station.steps[(station.step_of(op) + station.steps.len() - 1) % station.steps.len()].clone()
        };
        let sized = |_: StationId, station: &linewright_line::Station| station.operations.len();
        let sizes: Vec<usize> = line.station_ids().map(|id| sized(id, line.station(id))).collect();
        RunRecord {
            motions: Vec::new(),
            forgotten: 0,
            open: sizes.iter().map(|&n| vec![None; n]).collect(),
            done_at: sizes.iter().map(|&n| vec![Tick::ZERO; n]).collect(),
            idle_at: sizes.iter().map(|&n| vec![Duration::ZERO; n]).collect(),
            idle: vec![Idle::from_the_start(); sizes.len()],
            began: None,
            is_disturbed: false,
            undisturbed: Vec::new(),
            counts: base.clone(),
            home: base.clone(),
            base,
            is_counted: vec![true; sizes.len()],
            heard: vec![VecDeque::with_capacity(HEARD_MAX + 1); line.arrows.len()],
            waits: vec![ArrowWait::default(); line.arrows.len()],
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

    /// A station has received a report of the tail of these arrows.
    pub(crate) fn hear(&mut self, line: &Line, now: Tick, arrows: &[usize], report: &StationReport) {
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

    pub(crate) fn enter(&mut self, line: &Line, now: Tick, station: StationId, event: &StationHappening) {
        match event.what {
            HappeningKind::Started(op, block) => self.started(line, now, station, op, block, event.cycle),
            HappeningKind::Completed(op, block) => {
                self.ended(now, station, op, MotionEnd::Done);
                if block == Block::Normal {
                    self.completed(line, now, station, op, event.cycle);
                }
            }
            HappeningKind::Stopped(op, _, cause) => {
                self.ended(now, station, op, MotionEnd::Stopped(cause));
                if cause == StopCause::NotAtHome {
                    self.take_back(station, 1 << op.0);
                }
                if cause.is_fault() {
                    self.is_disturbed = true;
                    if self.faults.len() < FAULTS_MAX {
                        self.faults.push(FaultSeen { at: now, station, op, cause });
                    }
                }
            }
            HappeningKind::Withdrawn(ops) => self.take_back(station, ops),
            HappeningKind::HomeAgain => {
                // The home motion at a path's end completes without a count.
                let home = line.station(station).home;
                self.ended(now, station, home, MotionEnd::Done);
            }
            HappeningKind::Mode(mode) => {
                self.idle[station.index()].enter(now, mode);
                self.is_disturbed |= mode != ControlMode::Auto;
            }
            HappeningKind::PositionLost(..) | HappeningKind::IndexDoubtful(..) => self.is_disturbed = true,
            HappeningKind::Founded => self.found(station),
            HappeningKind::Asked(_)
            | HappeningKind::NotAgreed { .. }
            | HappeningKind::Refused
            | HappeningKind::Devices(_)
            | HappeningKind::Rejoined
            | HappeningKind::PositionFound => {}
            // There are no task orders in a simulated line.
            HappeningKind::Ordered(_)
            | HappeningKind::OrderRefused(_)
            | HappeningKind::OrderDone(_)
            | HappeningKind::OrderFailed(..)
            | HappeningKind::OrderLeft(..)
            | HappeningKind::Securing(_) => {}
        }
    }

    /// A station's process has died: it obeys no mode any more.
    pub(crate) fn lost(&mut self, now: Tick, station: StationId) {
        self.idle[station.index()].enter(now, ControlMode::StandBy);
        self.is_disturbed = true;
    }

    /// A station has been started without its memory.
    pub(crate) fn forgotten_by(&mut self, station: StationId) {
        self.is_counted[station.index()] = false;
    }

    /// A station's counts begin anew; the line goes on with the cycle it is in.
    fn found(&mut self, station: StationId) {
        let (at, cycles) = (station.index(), self.cycles() as i32);
        self.is_counted[at] = true;
        self.counts[at].clone_from(&self.home[at]);
        self.base[at] = self.home[at].iter().map(|home| home - cycles).collect();
        self.count_missing();
    }

    fn started(&mut self, line: &Line, now: Tick, station: StationId, op: OpId, block: Block, cycle: i32) {
        let done_at = &self.done_at[station.index()];
        let before = &self.before[station.index()][op.index()];
        let idle_at = &self.idle_at[station.index()];
        let ended = before.iter().map(|op| (done_at[op.index()], idle_at[op.index()]));
        let (ready, idle_at) = ended.max().unwrap_or_default();
        let mut by = if ready == now { LastWait::Previous } else { LastWait::Person };
        if block == Block::Normal {
            let mut last = ready;
            let is_auto = !self.idle[station.index()].is_on();
            let holds = |arrow: &&usize| !is_auto || line.arrows[**arrow].auto;
            for &arrow in self.into[station.index()][op.index()].iter().filter(holds) {
                let due = cycle - i32::try_from(line.arrows[arrow].lag).unwrap_or(i32::MAX);
                let heard = self.heard[arrow].iter().find(|(count, _)| *count >= due).map_or(Tick::ZERO, |(_, at)| *at);
                if heard > last {
                    last = heard;
                    by = if heard == now { LastWait::Arrow(arrow) } else { LastWait::Person };
                }
            }
            let idle = self.idle[station.index()];
            // A group that starts together has waited once.
            if let LastWait::Arrow(arrow) = by
                && is_auto
                && line.arrows[arrow].to == (station, op)
            {
                self.waits[arrow].starts += 1;
                self.waits[arrow].total += now.since(ready).saturating_sub(idle.until(now).saturating_sub(idle_at));
            }
        }
        if self.motions.len() == MOTIONS_MAX {
            self.motions.drain(..MOTIONS_MAX / 2);
            self.forgotten += MOTIONS_MAX / 2;
        }
        self.begun[station.index()] += 1;
        self.began.get_or_insert(now);
        self.open[station.index()][op.index()] = Some(self.forgotten + self.motions.len());
        self.motions.push(RecordedMotion {
            station,
            op,
            block,
            cycle,
            start: now,
            end: now,
            ended: MotionEnd::Open,
            by,
        });
    }

    fn ended(&mut self, now: Tick, station: StationId, op: OpId, how: MotionEnd) {
        let open = self.open[station.index()][op.index()].take();
        if let Some(motion) = open.and_then(|at| at.checked_sub(self.forgotten)).and_then(|at| self.motions.get_mut(at))
        {
            motion.end = now;
            motion.ended = how;
        }
    }

    fn completed(&mut self, line: &Line, now: Tick, station: StationId, op: OpId, cycle: i32) {
        self.done_at[station.index()][op.index()] = now;
        self.idle_at[station.index()][op.index()] = self.idle[station.index()].until(now);
        if !self.is_counted[station.index()] {
            return;
        }
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
                self.undisturbed.push(!self.is_disturbed);
                self.is_disturbed = self.idle.iter().any(|idle| idle.is_on());
                self.count_missing();
            }
        }
    }

    fn take_back(&mut self, station: StationId, ops: u64) {
        if !self.is_counted[station.index()] {
            return;
        }
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
    /// stands. A cycle that has ended stays so, even if its last operation is taken back.
    pub fn cycles(&self) -> usize {
        self.ends.len()
    }

    /// End of each of them.
    pub fn cycle_ends(&self) -> &[Tick] {
        &self.ends
    }

    /// For each of them, whether it went its way: every station in auto all the time, and no motion stopped on a fault.
    pub fn undisturbed(&self) -> &[bool] {
        &self.undisturbed
    }

    /// Start of the first motion.
    pub fn began(&self) -> Option<Tick> {
        self.began
    }

    /// The motions, in the order in which they began; of a very long run the latest.
    pub fn motions(&self) -> &[RecordedMotion] {
        &self.motions
    }

    /// The last cycle in which an operation is done and not taken back.
    pub fn count(&self, station: StationId, op: OpId) -> i32 {
        self.counts[station.index()][op.index()]
    }

    /// Number of motions that a station has begun.
    pub fn begun(&self, station: StationId) -> usize {
        self.begun[station.index()]
    }

    /// By arrow of the description: waits for it.
    pub fn waits(&self) -> &[ArrowWait] {
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
