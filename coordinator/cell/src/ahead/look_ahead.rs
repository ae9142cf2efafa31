//! The dispatcher that simulates decisions before it makes one.
//!
//! For each group of candidates that compete, the first of them by the rules are tried, waiting for what happens next, and
//! doing without a way where there are others: each is simulated, with the rules deciding all that follows, until the
//! horizon; the best future counts (a rollout; Bertsekas, Tsitsiklis and Wu 1997). The best future found so far is kept and
//! tried again at the next question, so that it is left only for a better one (their *fortified* rollout).
//!
//! # What holds
//! - *Never worse than its rules*, if the horizon covers all the work and everything takes its nominal time: the first
//!   question tries the rules themselves, what is kept is at least as good, and in a cell that goes as simulated it is
//!   repeated to the end. With a shorter horizon, or where times differ, that is a hope.
//! - *No part waits for ever.* When a part has waited longer than its patience, the rules alone decide, and these make it
//!   go on ([`Fairness`](super::super::dispatch::Fairness)). A candidate held here is posed again at the latest at that time.
//! - *The timetable goes before.* Where one is in force, its scheduler has looked further than this.
//! - *Bounded.* At most so many firings are simulated for a question; what could not be tried is not chosen.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::Duration;

use linewright_line::Tick;

use super::super::dispatch::DispatchRule;
use super::super::ids::{ModeId, PartId};
use super::super::production::DispatchConfiguration;
use super::super::question::{DispatchDecision, Dispatcher, HeldCandidate, Question, Start};
use super::super::reason::{HoldReason, ProgressComparison};
use super::super::record::{Record, RecordKind};
use super::super::state::PlayerState;
use super::super::table::CellTable;
use super::bounds::SimulationBasis;
use super::forward_simulation::{Ending, ForwardSimulation};
use super::rollout_policy::{DeviatingPolicy, PlanPolicy, PlannedStart, PolicyChoice, RolloutPolicy};
use super::score::Score;

/// Default number of firings simulated for a question.
pub const EFFORT: usize = 4000;

/// Candidates tried of a group.
const TRIED: usize = 8;

#[derive(Clone, Debug)]
pub struct LookAhead {
    /// The rules, and the production orders.
    pub desk: DispatchConfiguration,
    /// Time looked ahead; zero for not at all.
    pub horizon: Duration,
    /// Most firings simulated for a question.
    pub effort: usize,
    basis: SimulationBasis,
    /// The rest of the best future found so far.
    best: VecDeque<PlannedStart>,
    worn: u64,
}

/// A future that was tried.
struct EvaluatedDecision {
    score: Score,
    /// Starts in it at this question.
    first: Vec<PlannedStart>,
    all: VecDeque<PlannedStart>,
}

impl LookAhead {
    /// Over the rules of a desk, so far ahead.
    pub fn new(table: &CellTable, desk: DispatchConfiguration, horizon: Duration) -> Self {
        LookAhead::with(SimulationBasis::new(table), desk, horizon)
    }

    /// The same, on a basis that exists already.
    pub fn with(basis: SimulationBasis, desk: DispatchConfiguration, horizon: Duration) -> Self {
        LookAhead { desk, horizon, effort: EFFORT, basis, best: VecDeque::new(), worn: 0 }
    }

    pub fn basis(&self) -> &SimulationBasis {
        &self.basis
    }

    /// Number of questions that had to be decided before everything was tried.
    pub fn worn(&self) -> u64 {
        self.worn
    }

    /// Whether the rules alone decide.
    fn is_bound(&self, question: &Question<'_>) -> bool {
        let rules = &self.desk.rules;
        let timetable = &rules.timetable;
        let is_planned = !timetable.windows.is_empty() || !timetable.next.is_empty();
        let by_plan = rules.rules.contains(&DispatchRule::Schedule) && is_planned;
        self.horizon.is_zero() || by_plan || rules.is_pressed(question.now, question.state)
    }

    fn tries(
        &self,
        question: &Question<'_>,
        mut policy: impl RolloutPolicy,
        left: &mut usize,
    ) -> Option<EvaluatedDecision> {
        let mut simulation = ForwardSimulation::new(question.state, self.basis.table(), question.now);
        let ending = simulation.play(&mut policy, question.now + self.horizon, *left);
        *left = left.saturating_sub(simulation.firings());
        match ending {
            Ending::Worn => return None,
            Ending::Still | Ending::Horizon => (),
        }
        let table = question.state.table();
        let before = simulation.acts().iter().take_while(|act| act.was_running).count();
        let all: Vec<PlannedStart> = simulation.acts()[before..]
            .iter()
            .map(|act| {
                let part = act.part.filter(|_| table.part_in(act.mode).is_some());
                PlannedStart { at: act.from, mode: act.mode, part }
            })
            .collect();
        let first = simulation.first().unwrap_or(before) - before;
        let score = Score::of(&simulation, policy.desk(), &self.basis, ending);
        Some(EvaluatedDecision { score, first: all[..first].to_vec(), all: all.into() })
    }

    /// Alternatives to the decision by rules.
    fn choices(&self, question: &Question<'_>, usual: &DispatchDecision) -> Vec<PolicyChoice> {
        let preference = self.desk.rules.preference(question);
        let mut choices = Vec::new();
        for group in question.groups {
            let mut known = BTreeSet::new();
            let of_group = preference.iter().filter(|start| group.candidates.contains(&start.candidate));
            // Of equal parts the first is enough.
            let distinct = of_group.filter(|start| {
                let job = start.part.map(|part| self.desk.job(part));
                known.insert((start.candidate, job.map(|job| (job.due, job.priority))))
            });
            let others = distinct.filter(|start| !usual.start.contains(start)).take(TRIED);
            let mode = |candidate: usize| question.candidates[candidate].mode;
            choices.extend(others.map(|start| PolicyChoice::Start(mode(start.candidate), start.part)));
            if usual.start.iter().any(|start| group.candidates.contains(&start.candidate)) {
                let modes = group.candidates.iter().map(|&candidate| mode(candidate)).collect();
                choices.push(PolicyChoice::Wait(modes, question.now));
            }
            // A part with several routes could wait for a better one.
            let table = question.state.table();
            let ways = |mode: ModeId| table.part_in(mode).map_or(0, |cell| table.consumers(cell).len());
            let several = group.candidates.iter().map(|&candidate| mode(candidate)).filter(|&mode| ways(mode) > 1);
            choices.extend(several.take(TRIED).map(PolicyChoice::Without));
        }
        choices
    }

    fn answer(
        &self,
        question: &Question<'_>,
        usual: &DispatchDecision,
        base: &Score,
        best: &EvaluatedDecision,
    ) -> DispatchDecision {
        let index = |mode: ModeId| question.candidates.iter().position(|candidate| candidate.mode == mode);
        let starts = best.first.iter().filter_map(|of| Some(Start { candidate: index(of.mode)?, part: of.part }));
        let start: Vec<Start> = starts.collect();
        let same = |a: &[Start], b: &[Start]| a.iter().all(|start| b.contains(start));
        if same(&start, &usual.start) && same(&usual.start, &start) {
            return usual.clone();
        }
        let instead = best.first.first().map(|of| (of.mode, of.part));
        let worse = HoldReason::LooksWorse(ProgressComparison { instead, gain: best.score.gain(base) });
        let pressed = self.pressed_at(question.now, question.state);
        let usual_hold: BTreeMap<usize, &HeldCandidate> =
            usual.held.iter().map(|held| (held.candidate, held)).collect();
        let idle = (0..question.candidates.len()).filter(|at| start.iter().all(|start| start.candidate != *at));
        let held = idle.map(|candidate| match usual_hold.get(&candidate).map(|held| (held.reason, held.until)) {
            Some((
                reason @ (HoldReason::NotYet(_) | HoldReason::NotOrdered | HoldReason::PlannedOtherwise(_)),
                until,
            )) => HeldCandidate { candidate, reason, until },
            Some((HoldReason::LostTo(_) | HoldReason::ReservedFor { .. } | HoldReason::LooksWorse(_), _)) | None => {
                HeldCandidate { candidate, reason: worse, until: pressed }
            }
        });
        DispatchDecision { held: held.collect(), start }
    }

    /// Time at which the first part will have waited too long, if nothing moves.
    fn pressed_at(&self, now: Tick, state: &PlayerState) -> Option<Tick> {
        let patience = self.desk.rules.fairness.patience?;
        let inside = state.waiting().map(|part| part.since);
        let outside = self.desk.rules.jobs.outside.values().map(|waiting| waiting.since);
        inside.chain(outside).map(|since| since + patience).filter(|&at| at > now && at != Tick::NEVER).min()
    }

    /// Removes a start that was made.
    fn started(&mut self, mode: ModeId, part: Option<PartId>) {
        let part = part.filter(|_| self.basis.table().part_in(mode).is_some());
        let at = self.best.iter().position(|of| (of.mode, of.part) == (mode, part));
        at.into_iter().for_each(|at| _ = self.best.remove(at));
    }
}

impl RolloutPolicy for LookAhead {
    fn desk(&self) -> &DispatchConfiguration {
        &self.desk
    }
}

impl Dispatcher for LookAhead {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        let usual = self.desk.decide(question);
        if self.is_bound(question) {
            self.best.clear();
            return usual;
        }
        let mut left = self.effort;
        let Some(base) = self.tries(question, self.desk.clone(), &mut left) else {
            self.worn += 1;
            self.best.clear();
            return usual;
        };
        let base_score = base.score;
        let mut best = base;
        if !self.best.is_empty() {
            let kept = self.tries(question, PlanPolicy::new(self.desk.clone(), self.best.clone()), &mut left);
            // What was begun goes on unless something is better.
            best = kept.filter(|kept| kept.score <= best.score).unwrap_or(best);
        }
        let mut is_worn = false;
        for choice in self.choices(question, &usual) {
            let tried = self.tries(question, DeviatingPolicy::new(self.desk.clone(), choice), &mut left);
            is_worn |= tried.is_none();
            best = tried.filter(|tried| tried.score < best.score).unwrap_or(best);
        }
        self.worn += u64::from(is_worn);
        let answer = self.answer(question, &usual, &base_score, &best);
        self.best = best.all;
        answer
    }

    fn note(&mut self, record: &Record) {
        self.desk.note(record);
        if let RecordKind::Started { firing: _, mode, part, orders: _ } = &record.fact {
            self.started(*mode, *part);
        }
    }
}
