//! The dispatcher that has schedules made, follows them, and has them revised when reality deviates.
//!
//! Where `schedule` is among the rules, it sees to it that there is a schedule which holds; the rules then follow its windows.
//! A schedule does not hold any more when production orders change, something fails or is put right, something else has
//! started than was planned, or something is later than its float and the tolerance allow.
//!
//! Schedules are made in one of two ways. *At once*: within the decision, at most once for a question; where time is virtual
//! that costs none. There, where `schedule` is no rule, it looks ahead if that is configured, and else goes by the rules.
//! *Beside*: no decision plans or simulates anything; requests are taken and schedules returned by the caller, and rules
//! decide where there is none ([`super::beside`]). Looking ahead is then a schedule as well, as far as the time looked
//! ahead, made anew when half of that has passed.

use std::collections::VecDeque;
use std::time::Duration;

use linewright_line::Tick;

use super::super::ahead::LookAhead;
use super::super::dispatch::{DispatchRule, Timetable};
use super::super::question::{DispatchDecision, Dispatcher, Question};
use super::super::reason::HoldReason;
use super::super::record::Record;
use super::super::state::PlayerState;
use super::beside::{LATE_LEAST, PlanningBeside, PlanningRequest};
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

/// Where schedules are made.
enum Planning {
    AtOnce(Box<dyn Scheduler + Send>),
    Beside(PlanningBeside),
}

/// Has schedules made and follows them.
pub struct ScheduleFollower {
    /// Decides where nothing is planned, with the rules and production orders.
    pub look: LookAhead,
    /// Largest distance of a start from its window, and lateness beyond its float before the schedule is revised.
    pub tolerance: Duration,
    planning: Planning,
    schedule: Option<Schedule>,
    pending: Option<RevisionReason>,
    revisions: VecDeque<Revision>,
    past: VecDeque<PlanActualBar>,
}

impl ScheduleFollower {
    /// Over rules that may look ahead, with a scheduler that plans within decisions.
    pub fn new(look: LookAhead, scheduler: Box<dyn Scheduler + Send>) -> Self {
        ScheduleFollower::with(look, Planning::AtOnce(scheduler))
    }

    /// The same with a planner beside the decisions: its requests are taken by [`ScheduleFollower::take_request`].
    pub fn beside(mut look: LookAhead) -> Self {
        let rules = &mut look.desk.rules.rules;
        if !look.horizon.is_zero() && !rules.contains(&DispatchRule::Schedule) {
            // What was looked ahead is followed as a schedule.
            rules.insert(0, DispatchRule::Schedule);
        } else {
            look.horizon = Duration::ZERO;
        }
        ScheduleFollower::with(look, Planning::Beside(PlanningBeside::new()))
    }

    fn with(look: LookAhead, planning: Planning) -> Self {
        let tolerance = look.desk.rules.timetable.tolerance;
        ScheduleFollower {
            look,
            tolerance,
            planning,
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

    /// The planning problem for the planner beside, if one is due and none is under way. `state` is that of the cell now,
    /// after a step: the schedule begins from it.
    pub fn take_request(&mut self, now: Tick, state: &PlayerState) -> Option<PlanningRequest> {
        let follows = self.follows();
        let Planning::Beside(beside) = &mut self.planning else { return None };
        // What was recorded is planned before the next question; what is late may only wait for something.
        if let Some(why) = self.pending.filter(|_| follows && beside.is_idle()) {
            beside.ask(now, why);
        }
        let (number, why) = beside.begin(now)?;
        self.pending = None;
        let (desk, basis) = (self.look.desk.clone(), self.look.basis().clone());
        let until = if self.look.horizon.is_zero() { Tick::NEVER } else { now + self.look.horizon };
        let previous = self.schedule.clone();
        Some(PlanningRequest { number, why, now, until, state: state.clone(), desk, basis, previous })
    }

    /// Takes the schedule of the request with that number, which is followed from the next question on; true then, and the
    /// question should be put ([`Coordination::reconsider`](super::super::Coordination::reconsider)). That of any other request
    /// is dropped.
    pub fn take_schedule(&mut self, now: Tick, number: u64, mut schedule: Schedule) -> bool {
        let Planning::Beside(beside) = &mut self.planning else { return false };
        let Some((why, records)) = beside.end(number) else { return false };
        let Some(records) = records else {
            self.pending.get_or_insert(why);
            return false;
        };
        beside.replaced();
        records.iter().for_each(|record| schedule.note(self.look.basis().table(), record));
        self.follow(now, why, schedule);
        let is_good = self.deviation(now).is_none();
        if let Planning::Beside(beside) = &mut self.planning
            && is_good
        {
            beside.holds();
        }
        true
    }

    /// The planner beside has ended without a schedule for what was requested: it is requested again.
    pub fn planner_lost(&mut self) {
        let Planning::Beside(beside) = &mut self.planning else { return };
        let ended = beside.under_way().and_then(|number| beside.end(number));
        if let Some((why, _)) = ended {
            self.pending.get_or_insert(why);
        }
    }

    /// Whether the rules alone decide because no schedule that holds has come for too long ([`super::WITHIN`]).
    pub fn is_overdue(&self, now: Tick) -> bool {
        match &self.planning {
            Planning::AtOnce(_) => false,
            Planning::Beside(beside) => beside.deadline().is_some_and(|deadline| deadline <= now),
        }
    }

    fn follows(&self) -> bool {
        self.look.desk.rules.rules.contains(&DispatchRule::Schedule)
    }

    /// Least lateness beyond its float that is a deviation.
    fn lateness(&self) -> Duration {
        match self.planning {
            Planning::AtOnce(_) => self.tolerance,
            Planning::Beside(_) => self.tolerance.max(LATE_LEAST),
        }
    }

    /// Whether all that was planned has started, and there is more to do.
    fn is_outdone(&mut self, question: &Question<'_>) -> bool {
        self.schedule.as_ref().is_some_and(Schedule::is_over) && {
            // Nothing is held any more, so what starts now is what was not planned.
            self.look.desk.rules.timetable = Timetable::EMPTY;
            !self.look.desk.decide(question).start.is_empty()
        }
    }

    /// Reason why the schedule does not hold any more, by what was recorded and by the time.
    fn deviation(&self, now: Tick) -> Option<RevisionReason> {
        let holds = |schedule: &Schedule| schedule.deviation(now, self.lateness());
        self.pending.or_else(|| self.schedule.as_ref().and_then(holds))
    }

    /// Makes a schedule at once, if none holds.
    fn revise(&mut self, question: &Question<'_>) {
        let (now, state) = (question.now, question.state);
        let mut why = self.deviation(now);
        if why.is_none() && self.is_outdone(question) {
            why = Some(RevisionReason::Over);
        }
        let Planning::AtOnce(scheduler) = &mut self.planning else { return };
        let Some(why) = why else { return };
        self.pending = None;
        let (basis, previous) = (self.look.basis(), self.schedule.as_ref());
        let desk = &self.look.desk;
        let new = scheduler.plan(&PlanningSituation { now, until: Tick::NEVER, state, desk, basis, previous });
        self.follow(now, why, new);
    }

    /// Goes on by another schedule.
    fn follow(&mut self, now: Tick, why: RevisionReason, mut new: Schedule) {
        if let Some(previous) = self.schedule.take() {
            new.keep(&previous, self.tolerance);
            // What is in progress is in the new one as well.
            self.past.extend(previous.over_before(&new));
            let too_many = self.past.len().saturating_sub(BARS_MAX);
            self.past.drain(..too_many);
        }
        self.schedule = Some(new);
        self.revisions.push_back(Revision { at: now, why });
        let too_many = self.revisions.len().saturating_sub(REVISIONS_MAX);
        self.revisions.drain(..too_many);
    }

    /// Planned starts that count at a question.
    fn timetable(&self, question: &Question<'_>) -> Timetable {
        let rules = &self.look.desk.rules;
        let Some(schedule) = &self.schedule else { return Timetable::EMPTY };
        schedule.timetable(question.state, &rules.jobs, question.now, rules.fairness.patience, self.tolerance)
    }

    fn decide_at_once(&mut self, question: &Question<'_>) -> DispatchDecision {
        self.revise(question);
        if self.schedule.is_some() {
            self.look.desk.rules.timetable = self.timetable(question);
        }
        let mut answer = self.look.decide(question);
        self.wake(&mut answer, question.now);
        answer
    }

    fn decide_beside(&mut self, question: &Question<'_>) -> DispatchDecision {
        let now = question.now;
        let is_half_over =
            |schedule: &Schedule| !self.look.horizon.is_zero() && now.since(schedule.made) >= self.look.horizon / 2;
        let ahead = self.schedule.as_ref().is_some_and(is_half_over).then_some(RevisionReason::Ahead);
        let why = self.deviation(now).or(ahead);
        let has_strayed = self.schedule.as_ref().is_some_and(|schedule| schedule.strays().next().is_some());
        let Planning::Beside(beside) = &mut self.planning else { return DispatchDecision::default() };
        match why {
            Some(why) if beside.is_idle() => beside.ask(now, why),
            None if beside.is_idle() => beside.holds(),
            Some(_) | None => (),
        }
        let (is_followed, deadline) = (beside.is_followed(now) && !has_strayed, beside.deadline());
        self.look.desk.rules.timetable = if is_followed { self.timetable(question) } else { Timetable::EMPTY };
        let mut answer = self.look.desk.decide(question);
        match deadline {
            Some(deadline) if is_followed => {
                let by_plan =
                    |held: &HoldReason| matches!(held, HoldReason::PlannedOtherwise(_) | HoldReason::NotYet(_));
                for held in answer.held.iter_mut().filter(|held| by_plan(&held.reason)) {
                    held.until = Some(held.until.map_or(deadline, |until| until.min(deadline)));
                }
            }
            Some(_) => (),
            None => {
                self.wake(&mut answer, now);
                if self.schedule.as_ref().is_some_and(Schedule::is_over)
                    && !answer.start.is_empty()
                    && let Planning::Beside(beside) = &mut self.planning
                {
                    beside.ask(now, RevisionReason::Over);
                }
            }
        }
        answer
    }

    /// A candidate that waits for another activity is posed again when that does not come in time.
    fn wake(&self, answer: &mut DispatchDecision, now: Tick) {
        let until = self.schedule.as_ref().and_then(|schedule| schedule.holds_until(self.lateness()));
        let until = until.filter(|&until| until >= now).map(|until| until + Duration::from_micros(1));
        for held in answer.held.iter_mut().filter(|held| matches!(held.reason, HoldReason::PlannedOtherwise(_))) {
            held.until = held.until.or(until);
        }
    }
}

impl Dispatcher for ScheduleFollower {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        match (self.follows(), &self.planning) {
            (false, Planning::AtOnce(_)) => self.look.decide(question),
            (false, Planning::Beside(_)) => self.look.desk.decide(question),
            (true, planning) => {
                let is_beside = matches!(planning, Planning::Beside(_));
                self.look.desk.refresh(question.now);
                if is_beside { self.decide_beside(question) } else { self.decide_at_once(question) }
            }
        }
    }

    fn note(&mut self, record: &Record) {
        self.look.note(record);
        if let Some(schedule) = &mut self.schedule {
            schedule.note(self.look.basis().table(), record);
        }
        let why = RevisionReason::of(record);
        self.pending = why.or(self.pending);
        if let Planning::Beside(beside) = &mut self.planning {
            beside.note(record, why);
        }
    }
}
