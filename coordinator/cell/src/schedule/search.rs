//! Optimal schedules by branch and bound, depth first.
//!
//! A node is a forward simulation at an instant at which a decision is possible. Its branches are the single starts, and
//! waiting for the next event. Every schedule can be shifted left until each of its starts is at such an instant
//! (semi-active schedules), so no better schedule lies between them. A start without alternative is made at once: taking on a
//! part that only one mode takes and that needs no resource. A node is pruned when its bound is not below the best schedule
//! found, or when the same state was reached no later and with no more tardiness. Tardiness is minimised first, then the
//! makespan; the mean flow time reported is that of the schedule found.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use linewright_line::Tick;

use super::super::ahead::{CostBound, Ending, ForwardSimulation, Score, SimulatedActivity, SimulationBasis, weight};
use super::super::dispatch::PartPriority;
use super::super::firing::ActivityPhase;
use super::super::ids::ModeId;
use super::super::plan::{ActivityTiming, CellKind, PartPick};
use super::super::production::DispatchConfiguration;
use super::super::question::{Dispatcher, Question, Start};
use super::super::table::CellTable;

/// At most so many cells are remembered as seen.
const SEEN_MAX: usize = 200_000;

/// The best that is known.
#[derive(Clone, Debug)]
pub(super) struct Best {
    pub score: Score,
    pub acts: Vec<SimulatedActivity>,
}

/// Key of a node: equal for simulations that differ only in the time and in parts that have left.
type SearchKey = Vec<u64>;

pub(super) struct ScheduleSearch {
    basis: SimulationBasis,
    seen: BTreeMap<SearchKey, (Tick, u64)>,
    best: Option<Best>,
    stack: Vec<SearchNode>,
    /// Firings left.
    left: usize,
}

struct SearchNode {
    simulation: ForwardSimulation,
    desk: DispatchConfiguration,
    /// Options still to be tried, the last first; none is to wait.
    options: Vec<Option<(ModeId, Start)>>,
    /// Time of the next event.
    next: Option<Tick>,
}

impl ScheduleSearch {
    /// With the best that is known so far, and a limit of firings.
    pub fn new(basis: SimulationBasis, best: Option<Best>, effort: usize) -> Self {
        ScheduleSearch { basis, seen: BTreeMap::new(), best, stack: Vec::new(), left: effort }
    }

    /// Looks through everything; the best there is, and whether nothing better can be.
    pub fn run(mut self, root: ForwardSimulation, desk: DispatchConfiguration) -> (Option<Best>, bool) {
        self.open(root, desk);
        while let Some(node) = self.stack.last_mut() {
            let Some(option) = node.options.pop() else {
                self.stack.pop();
                continue;
            };
            if self.left == 0 {
                return (self.best, false);
            }
            // The last branch needs the node no longer.
            let (mut simulation, mut desk) = (node.simulation.clone(), node.desk.clone());
            let before = simulation.firings();
            match option {
                Some((mode, start)) => simulation.start(mode, start.part, &mut desk),
                None => node.next.into_iter().for_each(|next| simulation.advance(next)),
            }
            self.left = self.left.saturating_sub((simulation.firings() - before).max(1));
            self.open(simulation, desk);
        }
        (self.best, true)
    }

    /// Goes on to the next decision from here, and puts it on the stack, unless it leads nowhere.
    fn open(&mut self, mut simulation: ForwardSimulation, mut desk: DispatchConfiguration) {
        let before = simulation.firings();
        let options = loop {
            if !simulation.settle(&mut desk, before + self.left) {
                self.left = 0;
                return;
            }
            desk.refresh(simulation.now());
            let options = options(&simulation, &mut desk);
            match options.iter().find(|(mode, _)| is_free(simulation.state().table(), *mode)) {
                Some(&(mode, start)) => simulation.start(mode, start.part, &mut desk),
                None => break options,
            }
        };
        self.left = self.left.saturating_sub(simulation.firings() - before);
        let release = desk.production().and_then(|production| production.next_release(simulation.now()));
        let next = simulation.next_end().into_iter().chain(release).min();
        if options.is_empty() && next.is_none() {
            return self.close(&simulation, &desk);
        }
        if self.is_beaten(self.basis.bounds().bound(&simulation, &desk)) || self.was_seen(&simulation, &desk) {
            return;
        }
        let mut tries: Vec<Option<(ModeId, Start)>> = next.map(|_| None).into_iter().collect();
        tries.extend(options.into_iter().rev().map(Some));
        self.stack.push(SearchNode { simulation, desk, options: tries, next });
    }

    fn close(&mut self, simulation: &ForwardSimulation, desk: &DispatchConfiguration) {
        let score = Score::of(simulation, desk, &self.basis, Ending::Still);
        if self.best.as_ref().is_none_or(|best| score < best.score) {
            self.best = Some(Best { score, acts: simulation.acts().to_vec() });
        }
    }

    fn is_beaten(&self, bound: CostBound) -> bool {
        // What leaves something stuck is beaten by what does not, even if that takes longer.
        self.best.as_ref().is_some_and(|best| {
            best.score.stuck == 0 && (best.score.tardiness, best.score.makespan) <= (bound.tardiness, bound.makespan)
        })
    }

    fn was_seen(&mut self, simulation: &ForwardSimulation, desk: &DispatchConfiguration) -> bool {
        let late = |(job, at): &(PartPriority, Tick)| {
            let by = job.due.map_or(Duration::ZERO, |due| at.since(due)).as_micros();
            u64::try_from(by).unwrap_or(u64::MAX).saturating_mul(weight(job))
        };
        let tardiness = simulation.left().iter().map(late).fold(0, u64::saturating_add);
        let (key, now) = (key(simulation, desk), simulation.now());
        match self.seen.get_mut(&key) {
            Some((at, least)) if *at <= now && *least <= tardiness => true,
            Some(known) if now <= known.0 && tardiness <= known.1 => {
                *known = (now, tardiness);
                false
            }
            Some(_) => false,
            None => {
                if self.seen.len() < SEEN_MAX {
                    self.seen.insert(key, (now, tardiness));
                }
                false
            }
        }
    }
}

/// Possible starts, in the order of preference; of equal parts one.
fn options(simulation: &ForwardSimulation, desk: &mut DispatchConfiguration) -> Vec<(ModeId, Start)> {
    let (candidates, groups) = simulation.candidates();
    if candidates.is_empty() {
        return Vec::new();
    }
    let (now, state) = (simulation.now(), simulation.state());
    let question = Question { now, state, candidates: &candidates, groups: &groups };
    let usual = desk.decide(&question).start;
    let others = desk.rules.preference(&question);
    let mut known = BTreeSet::new();
    let all = usual.iter().chain(others.iter().filter(|start| !usual.contains(start)));
    let distinct = all.filter(|start| {
        let job = start.part.map(|part| desk.job(part));
        known.insert((start.candidate, job.map(|job| (job.due, job.priority))))
    });
    distinct.map(|start| (candidates[start.candidate].mode, *start)).collect()
}

/// Whether a start as soon as possible is never worse: it takes nothing but its part, which nothing else takes, and no
/// later start of it is better for another.
fn is_free(table: &CellTable, mode: ModeId) -> bool {
    let ([(cell, 1)], Some(from)) = (table.takes(mode), table.part_in(mode)) else { return false };
    *cell == from && table.consumers(from).len() == 1
}

fn key(simulation: &ForwardSimulation, desk: &DispatchConfiguration) -> SearchKey {
    let (state, now) = (simulation.state(), simulation.now());
    let table = state.table();
    let job_of = |part| {
        let job: PartPriority = desk.job(part);
        [job.due.map_or(u64::MAX, Tick::as_micros), u64::from_ne_bytes(i64::from(job.priority).to_ne_bytes())]
    };
    let mut key: SearchKey = Vec::with_capacity(table.cell_count() + 16);
    for cell in table.cells() {
        match table.kind(cell) {
            CellKind::Tokens => key.push(state.marking().count(cell)),
            CellKind::Parts(pick) => {
                let mut jobs: Vec<[u64; 2]> = state.marking().parts(cell).map(job_of).collect();
                match pick {
                    PartPick::Any => jobs.sort_unstable(),
                    PartPick::Oldest | PartPick::Newest => (),
                }
                key.push(jobs.len() as u64);
                key.extend(jobs.into_iter().flatten());
            }
        }
    }
    let mut running: Vec<[u64; 4]> = state
        .firings()
        .filter(|firing| firing.phase == ActivityPhase::Running)
        .map(|firing| {
            let ActivityTiming::Decided { time, limit: _ } = table.activity(firing.mode).kind else { return [0; 4] };
            let left = (firing.began + time).since(now).as_micros();
            let [due, priority] = firing.part.map_or([0; 2], job_of);
            [u64::from(firing.mode.0), u64::try_from(left).unwrap_or(u64::MAX), due, priority]
        })
        .collect();
    running.sort_unstable();
    key.extend(running.into_iter().flatten());
    key.push(u64::MAX);
    let orders = desk.production().into_iter().flat_map(|production| production.orders());
    key.extend(orders.flat_map(|order| [u64::from(order.entered), u64::from(order.done)]));
    key
}
