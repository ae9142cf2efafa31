//! The scheduler that is always there.
//!
//! It tries, in this order, what was planned before, the rules of the cell, each single rule, and looking ahead over all of
//! it; where the cell is small enough, all that can be decided ([`super::search`]); and as long as that has not proved
//! anything, futures by chance near the best one ([`super::randomised_rollouts`]). The best counts, of equals the one
//! that was found first; so what was planned stays planned unless something is better. It can be stopped after any of these,
//! and is, when so many firings have been simulated: a large order is then planned as far as that goes.

use std::collections::VecDeque;
use std::time::Duration;

use linewright_line::Tick;

use super::super::ahead::{
    Ending, ForwardSimulation, LookAhead, PlanPolicy, PlannedStart, RolloutPolicy, Score, SimulatedActivity,
};
use super::super::dispatch::{DispatchRule, Timetable};
use super::super::production::DispatchConfiguration;
use super::randomised_rollouts::{RandomPolicy, Xorshift};
use super::search::{Best, ScheduleSearch};
use super::slots::Schedule;
use super::{PlanningSituation, Scheduler};

/// Default number of firings simulated for a schedule.
pub const EFFORT: usize = 20_000;

/// Everything is looked through only if cells and modes, times firings, are at most so many: a node of the search is a copy
/// of the cell, and as many are kept as the cell has firings before it.
const SMALL: usize = 100_000;

/// The scheduler that is always there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RolloutScheduler {
    /// Most firings simulated for a schedule.
    pub effort: usize,
    /// Whether everything is looked through where the cell is small.
    pub exact: bool,
    /// Whether it looks ahead.
    pub looks_ahead: bool,
    /// Whether it tries futures by chance.
    pub samples: bool,
}

impl Default for RolloutScheduler {
    fn default() -> Self {
        RolloutScheduler { effort: EFFORT, exact: true, looks_ahead: true, samples: true }
    }
}

/// One plan that is being made.
struct ScheduleSearchState<'a> {
    situation: &'a PlanningSituation<'a>,
    best: Option<Best>,
    /// Firings left.
    left: usize,
    /// Number that the last future took.
    took: usize,
}

impl ScheduleSearchState<'_> {
    fn tries(&mut self, mut policy: impl RolloutPolicy, most: usize) {
        let PlanningSituation { now, until, state, basis, .. } = *self.situation;
        let mut simulation = ForwardSimulation::new(state, basis.table(), now);
        let ending = simulation.play(&mut policy, until, most);
        self.took = simulation.firings();
        self.left = self.left.saturating_sub(self.took);
        let score = Score::of(&simulation, policy.desk(), basis, ending);
        self.offer(score, simulation.acts(), ending);
    }

    fn offer(&mut self, score: Score, acts: &[SimulatedActivity], ending: Ending) {
        match ending {
            Ending::Worn if self.best.is_some() => return,
            Ending::Worn | Ending::Still | Ending::Horizon => (),
        }
        if self.best.as_ref().is_none_or(|best| score < best.score) {
            self.best = Some(Best { score, acts: acts.to_vec() });
        }
    }
}

/// A configuration without influence of a timetable.
fn free(desk: &DispatchConfiguration) -> DispatchConfiguration {
    let mut desk = desk.clone();
    desk.rules.timetable = Timetable::EMPTY;
    desk.rules.rules.retain(|rule| *rule != DispatchRule::Schedule);
    desk
}

impl Scheduler for RolloutScheduler {
    fn plan(&mut self, situation: &PlanningSituation<'_>) -> Schedule {
        let PlanningSituation { now, until, state, desk, basis, previous } = *situation;
        let desk = free(desk);
        let mut making = ScheduleSearchState { situation, best: None, left: self.effort, took: 0 };
        if let Some(previous) = previous {
            // As soon as it can be, in its order: its times do not hold any more.
            let rest: VecDeque<_> = previous
                .rest(state)
                .into_iter()
                .map(|mut start| {
                    start.at = now;
                    start
                })
                .collect();
            making.tries(PlanPolicy::new(desk.clone(), rest), self.effort / 2);
        }
        let left = making.left;
        making.tries(desk.clone(), left);
        for (_, rule) in DispatchRule::ALL.into_iter().filter(|(_, rule)| *rule != DispatchRule::Schedule) {
            if making.left < 2 * making.took {
                break;
            }
            let mut other = desk.clone();
            other.rules.rules = vec![rule];
            let left = making.left;
            making.tries(other, left);
        }
        if self.looks_ahead {
            self.look(&mut making, &desk);
        }
        let size = (basis.table().cell_count() + basis.table().mode_count()).saturating_mul(making.took);
        let mut proved = false;
        // What is looked through is looked through to the end.
        if self.exact && size <= SMALL && until == Tick::NEVER {
            let search = ScheduleSearch::new(basis.clone(), making.best.take(), making.left / 2);
            making.left /= 2;
            (making.best, proved) = search.run(ForwardSimulation::new(state, basis.table(), now), desk.clone());
        }
        if !proved {
            self.sample(&mut making, &desk);
        }
        let (score, acts) = making.best.map(|best| (best.score, best.acts)).unwrap_or_default();
        Schedule::new(state, now, &acts, score, proved)
    }
}

impl RolloutScheduler {
    /// Tries futures near the best one, as many as the rest of the limit allows.
    fn sample(&self, making: &mut ScheduleSearchState<'_>, desk: &DispatchConfiguration) {
        let (table, mut chance) = (making.situation.basis.table(), Xorshift::new());
        let took = making.took.max(1);
        while self.samples && making.left >= 2 * took {
            let acts = making.best.iter().flat_map(|best| &best.acts).filter(|act| !act.was_running);
            let plan: Vec<PlannedStart> = acts
                .map(|act| {
                    let part = act.part.filter(|_| table.part_in(act.mode).is_some());
                    PlannedStart { at: act.from, mode: act.mode, part }
                })
                .collect();
            making.tries(RandomPolicy::new(desk, &plan, &mut chance), 2 * took);
            // Firings of rejected plans count as well.
            making.left = making.left.saturating_sub(1);
        }
    }

    /// Plays on looking ahead, as far as half of the rest of the limit allows.
    fn look(&self, making: &mut ScheduleSearchState<'_>, desk: &DispatchConfiguration) {
        let (budget, took) = (making.left / 2, making.took.max(1));
        // As many questions as firings at most; for each a few futures that become shorter and shorter.
        let each = budget / took;
        let mut look = LookAhead::with(
            making.situation.basis.clone(),
            desk.clone(),
            making.situation.until.since(making.situation.now),
        );
        look.effort = each;
        if each < 2 * took {
            // Not even two whole futures: shorter ones.
            let span = making.best.as_ref().map_or(Duration::ZERO, |best| Duration::from_micros(best.score.makespan));
            look.horizon = span.mul_f64((each as f64 / (8.0 * took as f64)).min(1.0));
        }
        if each < 64 {
            return;
        }
        let left = making.left;
        making.tries(look, took.saturating_mul(2).min(left));
        making.left = left.saturating_sub(budget);
    }
}
