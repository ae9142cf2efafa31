//! The dispatcher that has schedules made, follows them, and has them revised when reality deviates.
//!
//! Where `schedule` is among the rules, it sees to it before each question that there is a schedule which holds; its windows
//! are what the rules then follow. A schedule does not hold any more when production orders change, something fails or is
//! put right, something else has started than was planned, or something is later than its float and the tolerance allow.
//! It is made anew at most once for a question. Where `schedule` is no rule, it looks ahead if that is asked for, and else
//! goes by the rules.

use std::collections::VecDeque;
use std::time::Duration;

use linewright_line::Tick;

use super::super::ahead::LookAhead;
use super::super::dispatch::{Rule, Timetable};
use super::super::exception::Step;
use super::super::question::{Answer, Dispatcher, Question};
use super::super::reason::Reason;
use super::super::record::{Fact, Record};
use super::slots::{Bar, Schedule};
use super::timetable::Deviation;
use super::{Scheduler, Situation};

/// So many activities of schedules that were revised are remembered.
const BARS_MAX: usize = 10_000;
/// So many revisions are remembered.
const REVISIONS_MAX: usize = 100;

/// A schedule was made anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Revision {
    /// When.
    pub at: Tick,
    /// Why.
    pub why: Deviation,
}

/// Has schedules made and follows them.
pub struct Foreman {
    /// What decides where nothing is planned, with the rules and production orders.
    pub look: LookAhead,
    /// How far from its window something may start, and how much later than its float allows before the schedule is revised.
    pub tolerance: Duration,
    scheduler: Box<dyn Scheduler + Send>,
    schedule: Option<Schedule>,
    pending: Option<Deviation>,
    revisions: VecDeque<Revision>,
    past: VecDeque<Bar>,
}

impl Foreman {
    /// Over rules that may look ahead, with somebody who makes schedules.
    pub fn new(look: LookAhead, scheduler: Box<dyn Scheduler + Send>) -> Self {
        let tolerance = look.desk.rules.timetable.tolerance;
        Foreman {
            look,
            tolerance,
            scheduler,
            schedule: None,
            pending: Some(Deviation::First),
            revisions: VecDeque::new(),
            past: VecDeque::new(),
        }
    }

    /// The schedule that is followed, if there is one.
    pub fn schedule(&self) -> Option<&Schedule> {
        self.schedule.as_ref()
    }

    /// When and why schedules were made, the newest last.
    pub fn revisions(&self) -> impl ExactSizeIterator<Item = &Revision> {
        self.revisions.iter()
    }

    /// Something has been put right that no record says: it is planned anew before the next question.
    pub fn restored(&mut self) {
        self.pending = Some(Deviation::Restored);
    }

    /// Plan against actual, what is over first.
    pub fn bars(&self) -> impl Iterator<Item = Bar> + '_ {
        self.past.iter().copied().chain(self.schedule.iter().flat_map(Schedule::bars))
    }

    fn follows(&self) -> bool {
        self.look.desk.rules.rules.contains(&Rule::Schedule)
    }

    fn revise(&mut self, question: &Question<'_>) {
        let (now, state) = (question.now, question.state);
        let holds = |schedule: &Schedule| schedule.deviation(now, self.tolerance);
        let mut why = self.pending.take().or_else(|| self.schedule.as_ref().and_then(holds));
        if why.is_none() && self.schedule.as_ref().is_some_and(Schedule::is_over) {
            // Nothing is held any more, so what starts now is what was not planned.
            self.look.desk.rules.timetable = Timetable::EMPTY;
            let goes_on = !self.look.desk.decide(question).start.is_empty();
            why = goes_on.then_some(Deviation::Over);
        }
        let Some(why) = why else { return };
        let previous = self.schedule.as_ref();
        let situation = Situation { now, state, desk: &self.look.desk, thought: self.look.thought(), previous };
        let mut new = self.scheduler.plan(&situation);
        if let Some(previous) = self.schedule.take() {
            new.keep(&previous, self.tolerance);
            // What is in progress is in the new one as well.
            let is_over = |bar: &Bar| bar.failed || matches!(bar.actual, Some((_, Some(_))));
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

impl Dispatcher for Foreman {
    fn decide(&mut self, question: &Question<'_>) -> Answer {
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
        // Whoever waits for something else than time is asked about when that does not come.
        let until = self.schedule.as_ref().and_then(|schedule| schedule.holds_until(self.tolerance));
        let until = until.filter(|&until| until >= now).map(|until| until + Duration::from_micros(1));
        for held in answer.held.iter_mut().filter(|held| matches!(held.reason, Reason::PlannedOtherwise(_))) {
            held.until = held.until.or(until);
        }
        answer
    }

    fn note(&mut self, record: &Record) {
        self.look.note(record);
        if let Some(schedule) = &mut self.schedule {
            schedule.note(self.look.thought().table(), record);
        }
        match &record.fact {
            Fact::Raised { firing, cause: _ } => self.pending = Some(Deviation::Failed(*firing)),
            Fact::Production { change: _ } => self.pending = Some(Deviation::Orders),
            Fact::Exception(Step::Down { resource, .. }) => self.pending = Some(Deviation::Down(*resource)),
            Fact::Exception(Step::Up { .. } | Step::Closed { .. } | Step::Missing { .. }) => {
                self.pending = Some(Deviation::Restored)
            }
            Fact::Exception(
                Step::Secured { .. }
                | Step::Alarmed { .. }
                | Step::Answered { .. }
                | Step::Carried { .. }
                | Step::Mismatch { .. }
                | Step::Stopped { .. }
                | Step::Reset { .. },
            )
            | Fact::Epoch { .. }
            | Fact::Memory { .. }
            | Fact::Decided { .. }
            | Fact::Started { .. }
            | Fact::Acknowledged { .. }
            | Fact::OrderEnded { .. }
            | Fact::OrderFailed { .. }
            | Fact::Ended { .. }
            | Fact::Fired { .. } => (),
        }
    }
}
