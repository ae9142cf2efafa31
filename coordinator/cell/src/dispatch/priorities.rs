//! Inputs of the dispatching rules that are not in the net: due dates, priorities, parts that may enter, and the schedule.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_line::Tick;

use super::super::ids::{ModeId, PartId};
use super::super::reason::HoldReason;

/// Data of a part beside its place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PartPriority {
    /// Due date; none if it does not matter.
    pub due: Option<Tick>,
    /// Priority; more comes first.
    pub priority: i32,
}

/// Candidate for entering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EntryCandidate {
    /// The next part that would.
    pub job: PartPriority,
    /// Time since which it could have.
    pub since: Tick,
}

/// Data of parts beside their places. Parts that are not in it have no due date and priority 0.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PartPriorities {
    /// Of the parts in the cell.
    pub parts: BTreeMap<PartId, PartPriority>,
    /// Of those outside, by the mode that lets them enter. One that is not here never becomes urgent.
    pub outside: BTreeMap<ModeId, EntryCandidate>,
    /// Permitted entries. None lets in what the net has room for.
    pub admission: Option<Admission>,
}

/// Permitted entries. A mode that is not in it may not enter.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Admission {
    /// For each mode that lets parts enter, its product, as an index.
    pub product: BTreeMap<ModeId, usize>,
    /// Number of parts wanted now, by product.
    pub wanted: Vec<u32>,
    /// Of each product when more will be, if that is known.
    pub more: Vec<Option<Tick>>,
}

impl Admission {
    /// Number of parts that may still enter by a mode, when so many of each product already do.
    pub(in super::super) fn room(&self, mode: ModeId, entered: &BTreeMap<usize, u32>) -> u32 {
        let Some(&product) = self.product.get(&mode) else { return 0 };
        let wanted = self.wanted.get(product).copied().unwrap_or(0);
        wanted.saturating_sub(entered.get(&product).copied().unwrap_or(0))
    }

    /// Time of the next question about a mode that lets none enter.
    pub(super) fn again(&self, mode: ModeId) -> Option<Tick> {
        self.product.get(&mode).and_then(|&product| *self.more.get(product)?)
    }
}

/// Window of a start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Not before (the earliest start time of seed 000, L2835).
    pub from: Tick,
    /// Not after (the latest start time).
    pub until: Tick,
}

/// Planned starts. What is not in it is neither held nor preferred by [`super::DispatchRule::Schedule`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Timetable {
    /// For a part, or the next that enters, and a mode.
    pub windows: BTreeMap<(Option<PartId>, ModeId), Window>,
    /// Next mode of a part; its other modes are held.
    pub next: BTreeMap<PartId, ModeId>,
    /// Largest distance of a start from its window.
    pub tolerance: Duration,
}

impl Timetable {
    /// Nothing is planned.
    pub const EMPTY: Timetable =
        Timetable { windows: BTreeMap::new(), next: BTreeMap::new(), tolerance: Duration::ZERO };

    /// Time until which something is held.
    pub fn held_until(&self, now: Tick, part: Option<PartId>, mode: ModeId) -> Option<Tick> {
        let window = self.windows.get(&(part, mode))?;
        let from = window.from - self.tolerance;
        (now < from).then_some(from)
    }

    /// Reason why something is held, if it is, and until when, if that is certain.
    pub(super) fn holds(&self, now: Tick, part: Option<PartId>, mode: ModeId) -> Option<(HoldReason, Option<Tick>)> {
        match part.and_then(|part| self.next.get(&part)) {
            Some(&next) if next != mode => Some((HoldReason::PlannedOtherwise(next), None)),
            Some(_) | None => self.held_until(now, part, mode).map(|until| (HoldReason::NotYet(until), Some(until))),
        }
    }
}
