//! The chain of operations and arrows that made the line as slow as it was.
//!
//! Every start has a cause that came true last. Followed back from the end of the last cycle, causes lead from motion to
//! motion; whenever an operation comes up again, a cycle or more earlier, the motions in between are a loop. The loop in
//! which most of the time went by decides the cycle time: all else could be a little slower without effect. Near the end
//! others may come up as well, where cycles differ in turn; in the long run no loop stays but the slowest (the critical
//! circuits of a timed event graph).

use std::collections::HashMap;
use std::time::Duration;

use linewright_line::net::Block;
use linewright_line::{Line, OpId, StationId, Tick};

use crate::record::{LastWait, MotionEnd, RecordedMotion, RunRecord};

/// One motion of the chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalMotion {
    pub motion: RecordedMotion,
    /// From the end of the motion that caused it to its start: messages, and nothing else.
    pub late: Duration,
}

/// The chain that determines the cycle time.
#[derive(Clone, Debug, PartialEq)]
pub struct CriticalPath {
    /// Its motions, in order; each is the one that the next waited for, and the last the one that the first waits for
    /// again.
    pub links: Vec<CriticalMotion>,
    /// The time from the first motion's start to its next start by the same chain.
    pub time: Duration,
    /// Number of cycles that took.
    pub cycles: u32,
}

impl CriticalPath {
    /// The chain, if a steady one is on record: none before the second cycle, or where a person's command was last.
    pub fn of(line: &Line, record: &RunRecord) -> Option<Self> {
        let end = *record.cycle_ends().last()?;
        let motions: HashMap<(StationId, OpId, i32), &RecordedMotion> = record
            .motions()
            .iter()
            .filter(|m| m.block == Block::Normal && m.ended == MotionEnd::Done)
            .map(|m| ((m.station, m.op, m.cycle), m))
            .collect();
        let last = *motions.values().copied().filter(|m| m.end == end).min_by_key(|m| (m.station, m.op))?;
        // Loops by what they consist of: the latest of them, and the time that went by in all.
        let mut loops: Vec<(CriticalPath, Duration)> = Vec::new();
        let mut known: HashMap<Vec<(StationId, OpId)>, usize> = HashMap::new();
        let mut chain: Vec<RecordedMotion> = vec![last];
        while let Some(&motion) = chain.last().and_then(|last| cause(line, &motions, last)) {
            let again = chain.iter().position(|m| (m.station, m.op) == (motion.station, motion.op));
            if let Some(again) = again {
                let mut round = chain.split_off(again);
                round.push(motion);
                if let Some(path) = CriticalPath::around(round) {
                    let at = *known.entry(path.operations()).or_insert(loops.len());
                    match loops.get_mut(at) {
                        Some((_, time)) => *time += path.time,
                        None => loops.push((path.clone(), path.time)),
                    }
                }
            }
            chain.push(motion);
        }
        let slowest = loops.iter().map(|(_, time)| *time).max()?;
        loops.into_iter().find(|(_, time)| *time == slowest).map(|(path, _)| path)
    }

    /// A loop of causes, latest first: it begins and ends with the same operation.
    fn around(mut chain: Vec<RecordedMotion>) -> Option<Self> {
        let (last, first) = (*chain.first()?, *chain.last()?);
        let cycles = u32::try_from(last.cycle - first.cycle).ok().filter(|&cycles| cycles > 0)?;
        chain.reverse();
        let late = |pair: &[RecordedMotion]| CriticalMotion { motion: pair[1], late: pair[1].start.since(pair[0].end) };
        let mut links: Vec<CriticalMotion> = chain.windows(2).map(late).collect();
        // The last is the first again, a round later.
        links.rotate_right(1);
        Some(CriticalPath { links, time: last.start.since(first.start), cycles })
    }

    /// Its operations in order, wherever it was closed.
    fn operations(&self) -> Vec<(StationId, OpId)> {
        let mut operations: Vec<_> = self.links.iter().map(|link| (link.motion.station, link.motion.op)).collect();
        let lowest = operations.iter().enumerate().min_by_key(|(_, op)| **op).map_or(0, |(at, _)| at);
        operations.rotate_left(lowest);
        operations
    }

    /// Seconds per cycle.
    pub fn cycle_time_s(&self) -> f64 {
        self.time.as_secs_f64() / f64::from(self.cycles)
    }
}

fn cause<'a>(
    line: &Line,
    motions: &HashMap<(StationId, OpId, i32), &'a RecordedMotion>,
    motion: &RecordedMotion,
) -> Option<&'a RecordedMotion> {
    match motion.by {
        LastWait::Person => None,
        LastWait::Arrow(arrow) => {
            let arrow = &line.arrows[arrow];
            let cycle = motion.cycle - i32::try_from(arrow.lag).ok()?;
            motions.get(&(arrow.from.0, arrow.from.1, cycle)).copied()
        }
        LastWait::Previous => {
            let station = line.station(motion.station);
            let step = station.step_of(motion.op);
            let before = &station.steps[(step + station.steps.len() - 1) % station.steps.len()];
            let cycle = motion.cycle - i32::from(step == 0);
            let ended: fn(&&RecordedMotion) -> Tick = |m| m.end;
            before.iter().filter_map(|&op| motions.get(&(motion.station, op, cycle)).copied()).max_by_key(ended)
        }
    }
}
