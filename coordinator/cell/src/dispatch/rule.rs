//! The rules, and what they measure.
//!
//! A rule gives each candidate and part a [`Measure`]; the smaller one comes first. Rules stand in a chain: what the
//! first leaves equal the next decides. What all leave equal is decided by the longest wait, then by the part's number,
//! then by the mode's: so every decision has one answer. Measures are whole numbers, compared exactly.
//!
//! The net has a part's place and time of arrival. Due date, priority and planned start stand beside it in
//! [`PartPriorities`] and [`Timetable`], which are filled from the production orders.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_cell::DispatchRule;
use linewright_line::Tick;

use super::super::ids::{ModeId, PartId};
use super::super::reason::HoldReason;
use super::super::state::PlayerState;
use super::measure::Measure;
use super::priorities::{PartPriorities, PartPriority, Timetable};
use super::ways::{ShortestRoutes, time};

/// Input of rules.
#[derive(Clone, Copy)]
pub(super) struct RuleInputs<'a> {
    pub(super) now: Tick,
    pub(super) state: &'a PlayerState,
    pub(super) ways: &'a ShortestRoutes,
    pub(super) jobs: &'a PartPriorities,
    pub(super) timetable: &'a Timetable,
}

impl RuleInputs<'_> {
    /// Reason why something is held whatever the others do, and until when, if that is certain.
    pub(super) fn holds(&self, part: Option<PartId>, mode: ModeId) -> Option<(HoldReason, Option<Tick>)> {
        if part.is_none() && self.state.table().part_out(mode).is_some() {
            let admission = self.jobs.admission.as_ref();
            if let Some(admission) = admission.filter(|admission| admission.room(mode, &BTreeMap::new()) == 0) {
                return Some((HoldReason::NotOrdered, admission.again(mode)));
            }
        }
        self.timetable.holds(self.now, part, mode)
    }

    /// Time since which a part, or the next that a mode lets enter, waits.
    pub(super) fn since(&self, part: Option<PartId>, mode: ModeId) -> Option<Tick> {
        match part {
            Some(part) => self.state.part(part).map(|part| part.since),
            None => self.jobs.outside.get(&mode).map(|waiting| waiting.since),
        }
    }

    fn job(&self, part: Option<PartId>, mode: ModeId) -> PartPriority {
        match part {
            Some(part) => self.jobs.parts.get(&part).copied().unwrap_or_default(),
            None => self.jobs.outside.get(&mode).map(|waiting| waiting.job).unwrap_or_default(),
        }
    }

    /// The work that remains, from where the part is now and on the shortest way, whatever the mode.
    fn work(&self, mode: ModeId) -> Duration {
        let table = self.state.table();
        match (table.part_in(mode), table.part_out(mode)) {
            (Some(from), _) => self.ways.remaining(from),
            (None, Some(to)) => time(table, mode) + self.ways.remaining(to),
            (None, None) => time(table, mode),
        }
    }

    pub(super) fn measure(&self, rule: DispatchRule, part: Option<PartId>, mode: ModeId) -> Measure {
        let micros = |tick: Tick| i64::try_from(tick.as_micros()).unwrap_or(i64::MAX);
        let span = |span: Duration| i64::try_from(span.as_micros()).unwrap_or(i64::MAX);
        let from_now = |tick: Tick| micros(tick).saturating_sub(micros(self.now));
        let due = self.job(part, mode).due;
        let never = (1, 0, 1);
        let (class, value, over) = match rule {
            DispatchRule::Fifo => self.since(part, mode).map_or(never, |since| (0, from_now(since), 1)),
            DispatchRule::ShortestProcessingTime => (0, span(self.ways.run(mode)), 1),
            DispatchRule::EarliestDueDate => due.map_or(never, |due| (0, from_now(due), 1)),
            DispatchRule::LeastSlack => {
                due.map_or(never, |due| (0, from_now(due).saturating_sub(span(self.work(mode))), 1))
            }
            DispatchRule::CriticalRatio => {
                // Where nothing remains to be done, a microsecond does: the ratio is very great, or very small.
                let work = u64::try_from(self.work(mode).as_micros()).unwrap_or(u64::MAX).max(1);
                due.map_or(never, |due| (0, from_now(due), work))
            }
            DispatchRule::Priority => (0, -i64::from(self.job(part, mode).priority), 1),
            DispatchRule::Schedule => match self.timetable.windows.get(&(part, mode)) {
                Some(window) if self.now > window.until + self.timetable.tolerance => (0, from_now(window.from), 1),
                Some(window) => (1, from_now(window.from), 1),
                None => (2, 0, 1),
            },
        };
        Measure { rule, class, value, over }
    }
}
