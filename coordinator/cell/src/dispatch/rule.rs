//! The rules, and what they measure.
//!
//! A rule gives each candidate and part a [`Measure`]; the smaller one comes first. Rules stand in a chain: what the
//! first leaves equal the next decides. What all leave equal is decided by who has waited longest, then by the part's
//! number, then by the mode's: so every decision has one answer. Measures are whole numbers, compared exactly.
//!
//! Of a part the net knows where it is and since when. When it is due, how much it matters, and what has been planned
//! for it stands beside it in [`PartPriorities`] and [`Timetable`], which whoever keeps the production orders fills.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::time::Duration;

pub use linewright_cell::DispatchRule;
use linewright_line::Tick;
use serde::{Deserialize, Serialize};

use super::super::ids::{ModeId, PartId};
use super::super::reason::HoldReason;
use super::super::serial;
use super::super::state::PlayerState;
use super::ways::{ShortestRoutes, time};

/// What is known of a part beside where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PartPriority {
    /// When it is to be finished; none if it does not matter.
    pub due: Option<Tick>,
    /// How much it matters; more comes first.
    pub priority: i32,
}

/// What could enter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EntryCandidate {
    /// The next part that would.
    pub job: PartPriority,
    /// Since when it could have.
    pub since: Tick,
}

/// What is known of parts beside where they are. Parts that are not in it have no due date and priority 0.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PartPriorities {
    /// Of the parts in the cell.
    pub parts: BTreeMap<PartId, PartPriority>,
    /// Of those outside, by the mode that lets them enter. One that is not here never becomes urgent.
    pub outside: BTreeMap<ModeId, EntryCandidate>,
    /// Who may enter. None lets in what the net has room for.
    pub admission: Option<Admission>,
}

/// Who may enter. What is not in it may not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Admission {
    /// For each mode that lets parts enter, its product, as an index.
    pub product: BTreeMap<ModeId, usize>,
    /// Of each product how many are wanted now.
    pub wanted: Vec<u32>,
    /// Of each product when more will be, if that is known.
    pub more: Vec<Option<Tick>>,
}

impl Admission {
    /// How many more may enter by a mode, when so many of each product already do.
    pub(in super::super) fn room(&self, mode: ModeId, entered: &BTreeMap<usize, u32>) -> u32 {
        let Some(&product) = self.product.get(&mode) else { return 0 };
        let wanted = self.wanted.get(product).copied().unwrap_or(0);
        wanted.saturating_sub(entered.get(&product).copied().unwrap_or(0))
    }

    /// When to ask again about a mode that may let nobody enter.
    fn again(&self, mode: ModeId) -> Option<Tick> {
        self.product.get(&mode).and_then(|&product| *self.more.get(product)?)
    }
}

/// When something is to start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Not before (the earliest start time of seed 000, L2835).
    pub from: Tick,
    /// Not after (the latest start time).
    pub until: Tick,
}

/// What has been planned. What is not in it is neither held nor preferred by [`DispatchRule::Schedule`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Timetable {
    /// For a part, or the next that enters, and a mode.
    pub windows: BTreeMap<(Option<PartId>, ModeId), Window>,
    /// For a part what it is to do next; whatever else it could do is held.
    pub next: BTreeMap<PartId, ModeId>,
    /// How far from its window something may start.
    pub tolerance: Duration,
}

impl Timetable {
    /// Nothing is planned.
    pub const EMPTY: Timetable =
        Timetable { windows: BTreeMap::new(), next: BTreeMap::new(), tolerance: Duration::ZERO };

    /// Until when something is held.
    pub fn held_until(&self, now: Tick, part: Option<PartId>, mode: ModeId) -> Option<Tick> {
        let window = self.windows.get(&(part, mode))?;
        let from = window.from - self.tolerance;
        (now < from).then_some(from)
    }

    /// Why something is held, if it is, and until when, if that is known.
    pub(super) fn holds(&self, now: Tick, part: Option<PartId>, mode: ModeId) -> Option<(HoldReason, Option<Tick>)> {
        match part.and_then(|part| self.next.get(&part)) {
            Some(&next) if next != mode => Some((HoldReason::PlannedOtherwise(next), None)),
            Some(_) | None => self.held_until(now, part, mode).map(|until| (HoldReason::NotYet(until), Some(until))),
        }
    }
}

/// What a rule says of a candidate, at the time of the decision. Of two by one rule the smaller comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    #[serde(with = "serial::rule")]
    pub rule: DispatchRule,
    /// First by this: 0 before 1 before 2.
    pub(crate) class: u8,
    /// Then by this, times `1 / over`.
    pub(crate) value: i64,
    pub(crate) over: u64,
}

impl Measure {
    /// Which of two by the same rule comes first.
    pub fn compare(&self, other: &Measure) -> Ordering {
        // 64 times 64 bits fit.
        let [ours, theirs] = [(self, other), (other, self)].map(|(a, b)| i128::from(a.value) * i128::from(b.over));
        self.class.cmp(&other.class).then(ours.cmp(&theirs))
    }
}

/// What rules look at.
#[derive(Clone, Copy)]
pub(super) struct RuleInputs<'a> {
    pub(super) now: Tick,
    pub(super) state: &'a PlayerState,
    pub(super) ways: &'a ShortestRoutes,
    pub(super) jobs: &'a PartPriorities,
    pub(super) timetable: &'a Timetable,
}

impl RuleInputs<'_> {
    /// Why something is held whatever the others do, and until when, if that is known.
    pub(super) fn holds(&self, part: Option<PartId>, mode: ModeId) -> Option<(HoldReason, Option<Tick>)> {
        if part.is_none() && self.state.table().part_out(mode).is_some() {
            let admission = self.jobs.admission.as_ref();
            if let Some(admission) = admission.filter(|admission| admission.room(mode, &BTreeMap::new()) == 0) {
                return Some((HoldReason::NotOrdered, admission.again(mode)));
            }
        }
        self.timetable.holds(self.now, part, mode)
    }

    /// Since when a part, or the next that a mode lets enter, waits.
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

    /// The work that remains, from where the part is now and on the shortest way, whichever mode is asked about.
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
