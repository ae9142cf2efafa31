//! The dispatcher that has schedules made, follows them, and has them revised when reality deviates.
//!
//! Where `schedule` is among the rules, it ensures before each question that there is a schedule which holds; the rules then
//! follow its windows. A schedule does not hold any more when production orders change, something fails or is put right,
//! something else has started than was planned, or something is later than its float and the tolerance allow. It is made
//! anew at most once for a question. Where `schedule` is no rule, it looks ahead if that is configured, and else goes by the
//! rules.

use std::collections::VecDeque;
use std::time::Duration;

use linewright_line::Tick;

use super::super::ahead::LookAhead;
use super::super::dispatch::{DispatchRule, Timetable};
use super::super::exception::ExceptionStep;
use super::super::question::{DispatchDecision, Dispatcher, Question};
use super::super::reason::HoldReason;
use super::super::record::{Record, RecordKind};
use super::slots::{PlanActualBar, Schedule};
use super::timetable::RevisionReason;
use super::{PlanningSituation, Scheduler};

/// Activities kept of schedules that were revised.
const BARS_MAX: usize = 10_000;
/// Revisions kept.
const REVISIONS_MAX: usize = 100;

/// A schedule was made anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Revision {
    pub at: Tick,
    pub why: RevisionReason,
}

/// Has schedules made and follows them.
pub struct ScheduleFollower {
    /// Decides where nothing is planned, with the rules and production orders.
    pub look: LookAhead,
    /// Largest distance of a start from its window, and lateness beyond its float before the schedule is revised.
    pub tolerance: Duration,
    scheduler: Box<dyn Scheduler + Send>,
    schedule: Option<Schedule>,
    pending: Option<RevisionReason>,
    revisions: VecDeque<Revision>,
    past: VecDeque<PlanActualBar>,
}

impl ScheduleFollower {
    /// Over rules that may look ahead, with a scheduler.
    pub fn new(look: LookAhead, scheduler: Box<dyn Scheduler + Send>) -> Self {
        let tolerance = look.desk.rules.timetable.tolerance;
        ScheduleFollower {
            look,
            tolerance,
            scheduler,
            schedule: None,
            pending: Some(RevisionReason::First),
            revisions: VecDeque::new(),
            past: VecDeque::new(),
        }
    }

    /// The schedule that is followed, if there is one.
    pub fn schedule(&self) -> Option<&Schedule> {
        self.schedule.as_ref()
    }

    /// Times and reasons of schedules, the newest last.
    pub fn revisions(&self) -> impl ExactSizeIterator<Item = &Revision> {
        self.revisions.iter()
    }

    /// Something has been put right without a record: it is planned anew before the next question.
    pub fn restored(&mut self) {
        self.pending = Some(RevisionReason::Restored);
    }

    /// Plan against actual, activities that are over first.
    pub fn bars(&self) -> impl Iterator<Item = PlanActualBar> + '_ {
        self.past.iter().copied().chain(self.schedule.iter().flat_map(Schedule::bars))
    }

    fn follows(&self) -> bool {
        self.look.desk.rules.rules.contains(&DispatchRule::Schedule)
    }

    fn revise(&mut self, question: &Question<'_>) {
        let (now, state) = (question.now, question.state);
        let holds = |schedule: &Schedule| schedule.deviation(now, self.tolerance);
        let mut why = self.pending.take().or_else(|| self.schedule.as_ref().and_then(holds));
        if why.is_none() && self.schedule.as_ref().is_some_and(Schedule::is_over) {
            // Nothing is held any more, so what starts now is what was not planned.
            self.look.desk.rules.timetable = Timetable::EMPTY;
            let goes_on = !self.look.desk.decide(question).start.is_empty();
            why = goes_on.then_some(RevisionReason::Over);
        }
        let Some(why) = why else { return };
        let previous = self.schedule.as_ref();
        let situation = PlanningSituation { now, state, desk: &self.look.desk, basis: self.look.basis(), previous };
        let mut new = self.scheduler.plan(&situation);
        if let Some(previous) = self.schedule.take() {
            new.keep(&previous, self.tolerance);
            // What is in progress is in the new one as well.
            let is_over = |bar: &PlanActualBar| bar.failed || matches!(bar.actual, Some((_, Some(_))));
            self.past.extend(previous.bars().filter(is_over));
            let too_many = self.past.len().saturating_sub(BARS_MAX);
            self.past.drain(..too_many);
        }
        self.schedule = Some(new);
        self.revisions.push_back(Revision { at: now, why });
        let too_many = self.revisions.len().saturating_sub(REVISIONS_MAX);
        self.revisions.drain(..too_many);
    }
}

impl Dispatcher for ScheduleFollower {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        if !self.follows() {
            return self.look.decide(question);
        }
        let now = question.now;
        self.look.desk.refresh(now);
        self.revise(question);
        let rules = &mut self.look.desk.rules;
        if let Some(schedule) = &self.schedule {
            let patience = rules.fairness.patience;
            rules.timetable = schedule.timetable(question.state, &rules.jobs, now, patience, self.tolerance);
        }
        let mut answer = self.look.decide(question);
        // A candidate that waits for another activity is posed again when that does not come in time.
        let until = self.schedule.as_ref().and_then(|schedule| schedule.holds_until(self.tolerance));
        let until = until.filter(|&until| until >= now).map(|until| until + Duration::from_micros(1));
        for held in answer.held.iter_mut().filter(|held| matches!(held.reason, HoldReason::PlannedOtherwise(_))) {
            held.until = held.until.or(until);
        }
        answer
    }

    fn note(&mut self, record: &Record) {
        self.look.note(record);
        if let Some(schedule) = &mut self.schedule {
            schedule.note(self.look.basis().table(), record);
        }
        match &record.fact {
            RecordKind::Raised { firing, cause: _ } => self.pending = Some(RevisionReason::Failed(*firing)),
            RecordKind::Production { change: _ } => self.pending = Some(RevisionReason::Orders),
            RecordKind::Exception(ExceptionStep::Down { resource, .. }) => {
                self.pending = Some(RevisionReason::Down(*resource))
            }
            RecordKind::Exception(
                ExceptionStep::Up { .. } | ExceptionStep::Closed { .. } | ExceptionStep::Missing { .. },
            ) => self.pending = Some(RevisionReason::Restored),
            RecordKind::Exception(
                ExceptionStep::Secured { .. }
                | ExceptionStep::Alarmed { .. }
                | ExceptionStep::Answered { .. }
                | ExceptionStep::Carried { .. }
                | ExceptionStep::Mismatch { .. }
                | ExceptionStep::Stopped { .. }
                | ExceptionStep::Reset { .. },
            )
            | RecordKind::Epoch { .. }
            | RecordKind::Memory { .. }
            | RecordKind::Decided { .. }
            | RecordKind::Started { .. }
            | RecordKind::Acknowledged { .. }
            | RecordKind::OrderEnded { .. }
            | RecordKind::OrderFailed { .. }
            | RecordKind::Ended { .. }
            | RecordKind::Fired { .. } => (),
        }
    }
}
