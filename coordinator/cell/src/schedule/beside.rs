//! Planning beside the decisions: a decision never waits for a schedule.
//!
//! ```text
//!                  it does not hold                the caller takes a copy
//!   holds or none ─────────────────▶ due ──────────────────────────────────▶ under way
//!      ▲                              ▲                                          │
//!      │                              └── the planner is lost ───────────────────┤
//!      └── the schedule comes: what was recorded since the copy is noted in it ──┘
//! ```
//!
//! [`ScheduleFollower`](super::ScheduleFollower) never plans in this mode. Its caller takes a [`PlanningRequest`] after a
//! step, has it planned elsewhere, and returns the schedule with the request's number. One request is under way at a time. The
//! copy is taken after the step, so it has what that step has started, and its cost delays no order.
//!
//! # What holds meanwhile
//! - The schedule before is followed while it only is late, or knows less than there is. Where it counts on something that has
//!   failed, or something has started against it, the rules alone decide.
//! - [`WITHIN`] after the moment since which no schedule has held, the rules alone decide until one does. So no candidate
//!   is held for longer by a planner that is slow, stands still or has ended; it is posed again at that time.
//! - A schedule that comes late is followed like any other if it still holds. If it does not, the next request is due, and the
//!   time counts on.
//! - Urgency, and with it that no part waits for ever, is the rules' and does not depend on a planner.

use std::time::Duration;

use linewright_line::Tick;

use super::super::ahead::SimulationBasis;
use super::super::production::DispatchConfiguration;
use super::super::record::Record;
use super::super::state::PlayerState;
use super::slots::Schedule;
use super::timetable::RevisionReason;
use super::{PlanningSituation, Scheduler};

/// Longest time for which a schedule that does not hold is followed while the next is made. Some ten times as long as the
/// built-in scheduler takes.
pub const WITHIN: Duration = Duration::from_secs(2);

/// Least lateness that is a deviation here. Orders and reports take some milliseconds, and a schedule that is made takes
/// longer than that: what is late by less is not worth another one.
pub(super) const LATE_LEAST: Duration = Duration::from_millis(100);

/// Least time between the copies of two requests, if the second is due to a deviation: a cell that deviates all the time, as one
/// with a station that is away, must not keep a processor busy with planning. What was recorded is planned at once.
pub(super) const REST: Duration = Duration::from_millis(500);

/// Records that may be noted in a schedule that comes; of more it is not used.
const RECORDS_MAX: usize = 10_000;

/// A planning problem with all that it takes, for a planner on a thread of its own.
#[derive(Clone, Debug)]
pub struct PlanningRequest {
    pub(super) number: u64,
    pub(super) why: RevisionReason,
    pub(super) now: Tick,
    pub(super) until: Tick,
    pub(super) state: PlayerState,
    pub(super) desk: DispatchConfiguration,
    pub(super) basis: SimulationBasis,
    pub(super) previous: Option<Schedule>,
}

impl PlanningRequest {
    /// Number of the request, which its schedule is returned with.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// Reason why a schedule is made.
    pub fn reason(&self) -> RevisionReason {
        self.why
    }

    /// The schedule. The same request has the same one, for schedulers that keep nothing.
    pub fn plan(&self, scheduler: &mut dyn Scheduler) -> Schedule {
        let PlanningRequest { now, until, ref state, ref desk, ref basis, ref previous, .. } = *self;
        scheduler.plan(&PlanningSituation { now, until, state, desk, basis, previous: previous.as_ref() })
    }
}

/// Progress of planning.
#[derive(Debug)]
enum PlanningPhase {
    /// Nothing is requested.
    Idle,
    /// The next request.
    Due(RevisionReason),
    /// A request is being planned.
    UnderWay {
        number: u64,
        why: RevisionReason,
        /// Records since the copy, to be replayed into the schedule when it is ready; none if there are too many.
        records: Option<Vec<Record>>,
    },
}

/// What is known of a planner beside the decisions.
#[derive(Debug)]
pub(super) struct PlanningBeside {
    phase: PlanningPhase,
    /// Number of the newest request.
    last: u64,
    /// Time before which no deviation is a request.
    rests_until: Tick,
    /// Time since which no schedule has held.
    since: Option<Tick>,
    /// Something that the schedule counts on has failed.
    is_broken: bool,
    /// The same since the copy for the request under way.
    is_copy_broken: bool,
}

impl PlanningBeside {
    pub fn new() -> Self {
        PlanningBeside {
            phase: PlanningPhase::Idle,
            last: 0,
            rests_until: Tick::ZERO,
            since: None,
            is_broken: false,
            is_copy_broken: false,
        }
    }

    /// Whether nothing is requested, so that a deviation makes a request due.
    pub fn is_idle(&self) -> bool {
        matches!(self.phase, PlanningPhase::Idle)
    }

    /// A request is due.
    pub fn ask(&mut self, now: Tick, why: RevisionReason) {
        self.phase = PlanningPhase::Due(why);
        self.since.get_or_insert(now);
    }

    /// The schedule holds.
    pub fn holds(&mut self) {
        self.since = None;
    }

    /// Time from which on the rules alone decide; none while a schedule holds.
    pub fn deadline(&self) -> Option<Tick> {
        self.since.map(|since| since + WITHIN)
    }

    /// Whether a schedule that does not hold is followed all the same.
    pub fn is_followed(&self, now: Tick) -> bool {
        !self.is_broken && self.deadline().is_none_or(|deadline| now < deadline)
    }

    /// The reason of a request that is due, which is then under way.
    pub fn begin(&mut self, now: Tick) -> Option<(u64, RevisionReason)> {
        let PlanningPhase::Due(why) = self.phase else { return None };
        if why.is_deviation() && now < self.rests_until {
            return None;
        }
        self.rests_until = now + REST;
        self.last += 1;
        self.phase = PlanningPhase::UnderWay { number: self.last, why, records: Some(Vec::new()) };
        self.is_copy_broken = false;
        Some((self.last, why))
    }

    /// The end of a request that is under way. Reason, and what was recorded meanwhile, unless that is too much; none if it is
    /// another request.
    pub fn end(&mut self, number: u64) -> Option<(RevisionReason, Option<Vec<Record>>)> {
        match &mut self.phase {
            PlanningPhase::UnderWay { number: of, why, records } if *of == number => {
                let ended = (*why, records.take());
                self.phase = PlanningPhase::Idle;
                Some(ended)
            }
            PlanningPhase::Idle | PlanningPhase::Due(_) | PlanningPhase::UnderWay { .. } => None,
        }
    }

    /// The schedule of the copy is there.
    pub fn replaced(&mut self) {
        self.is_broken = self.is_copy_broken;
    }

    /// Number of the request under way.
    pub fn under_way(&self) -> Option<u64> {
        match self.phase {
            PlanningPhase::UnderWay { number, .. } => Some(number),
            PlanningPhase::Idle | PlanningPhase::Due(_) => None,
        }
    }

    /// Takes a record, and the reason that it is for another schedule.
    pub fn note(&mut self, record: &Record, why: Option<RevisionReason>) {
        let is_broken = why.is_some_and(RevisionReason::is_failure);
        self.is_broken |= is_broken;
        self.is_copy_broken |= is_broken;
        let PlanningPhase::UnderWay { records, .. } = &mut self.phase else { return };
        if record.fact.activity_step().is_some()
            && let Some(all) = records
        {
            all.push(record.clone());
            if all.len() > RECORDS_MAX {
                *records = None;
            }
        }
    }
}
