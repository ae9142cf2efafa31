//! From a schedule to the windows that the rule `schedule` follows, and when a schedule does not hold any more.
//!
//! A part is held until the window of what it is to do next, and from everything else it could do. That never makes it wait
//! for longer than parts should wait: a part that has waited so long is not held by any schedule, however often that is revised,
//! and is then as urgent as any. So the argument why no part waits for ever stands as it is (the head of `urgency.rs`).

use std::time::Duration;

use linewright_line::Tick;

use super::super::dispatch::{PartPriorities, Timetable, Window};
use super::super::exception::ExceptionStep;
use super::super::ids::{FiringId, ModeId, PartId, ResourceId};
use super::super::record::{Record, RecordKind};
use super::super::state::{PartPlace, PlayerState};
use super::slots::{Schedule, ScheduleSlot};

/// Reason why a schedule is made anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RevisionReason {
    /// There was none.
    First,
    /// Production orders have changed.
    Orders,
    /// An activity has failed; its tokens do not come back by themselves.
    Failed(FiringId),
    /// A resource is not to be counted on.
    Down(ResourceId),
    /// A failed activity goes on again, or something has been put right by hand.
    Restored,
    /// Something starts, or ends, later than it may.
    Late {
        mode: ModeId,
        /// Its part; none if it has not entered, or takes none.
        part: Option<PartId>,
        /// Deviation beyond its window and the tolerance.
        by: Duration,
    },
    /// All that was planned has started, and there is more to do.
    Over,
    /// Something else has started than was planned.
    Stray(ModeId, Option<PartId>),
    /// Half of the time looked ahead has passed.
    Ahead,
}

impl RevisionReason {
    /// Reason for a revision that a record gives; none if the record can be part of the plan.
    pub(super) fn of(record: &Record) -> Option<Self> {
        match &record.fact {
            RecordKind::Raised { firing, cause: _ } => Some(RevisionReason::Failed(*firing)),
            RecordKind::Production { change: _ } => Some(RevisionReason::Orders),
            RecordKind::Exception(ExceptionStep::Down { resource, .. }) => Some(RevisionReason::Down(*resource)),
            RecordKind::Exception(step) if step.changes_the_cell() => Some(RevisionReason::Restored),
            RecordKind::Exception(_)
            | RecordKind::Epoch { .. }
            | RecordKind::Memory { .. }
            | RecordKind::Decided { .. }
            | RecordKind::Started { .. }
            | RecordKind::Acknowledged { .. }
            | RecordKind::OrderEnded { .. }
            | RecordKind::OrderFailed { .. }
            | RecordKind::Ended { .. }
            | RecordKind::Fired { .. } => None,
        }
    }

    /// Whether the schedule counts on something that is not there any more.
    pub(super) fn is_failure(self) -> bool {
        matches!(self, RevisionReason::Failed(_) | RevisionReason::Down(_))
    }

    /// Whether it is the schedule's progress, and no record.
    pub(super) fn is_deviation(self) -> bool {
        match self {
            RevisionReason::Late { .. } | RevisionReason::Over | RevisionReason::Stray(..) | RevisionReason::Ahead => {
                true
            }
            RevisionReason::First
            | RevisionReason::Orders
            | RevisionReason::Failed(_)
            | RevisionReason::Down(_)
            | RevisionReason::Restored => false,
        }
    }
}

impl Schedule {
    /// Planned starts for the rule `schedule`.
    pub fn timetable(
        &self,
        state: &PlayerState,
        jobs: &PartPriorities,
        now: Tick,
        patience: Option<Duration>,
        tolerance: Duration,
    ) -> Timetable {
        let mut timetable = Timetable { tolerance, ..Timetable::EMPTY };
        // The window is open, tolerance and all, when patience has run out.
        let capped = |slot: &ScheduleSlot, since: Tick| {
            let Window { from, until } = slot.window();
            let last = patience.map_or(Tick::NEVER, |patience| since + patience + tolerance);
            Window { from: from.min(last), until: until.min(last) }
        };
        let is_over = |since: Tick| patience.is_some_and(|patience| since + patience <= now);
        for (id, slot) in self.next_of_parts() {
            let Some(part) = state.part(id).filter(|part| !is_over(part.since)) else { continue };
            match part.place {
                PartPlace::On { cell, arrival: _ } if state.table().part_in(slot.mode) == Some(cell) => {
                    timetable.next.insert(id, slot.mode);
                    timetable.windows.insert((Some(id), slot.mode), capped(slot, part.since));
                }
                // It is on its way, or not where the schedule expects it.
                PartPlace::On { .. } | PartPlace::In(_) => (),
            }
        }
        for (mode, slot) in self.next_entering() {
            let since = jobs.outside.get(&mode).map_or(Tick::NEVER, |waiting| waiting.since);
            if !is_over(since) {
                timetable.windows.insert((None, mode), capped(slot, since));
            }
        }
        timetable
    }

    /// Reason why the schedule does not hold any more, if it does not.
    pub fn deviation(&self, now: Tick, tolerance: Duration) -> Option<RevisionReason> {
        if let Some(stray) = self.strays().next() {
            return Some(RevisionReason::Stray(stray.mode, self.part_of(stray)));
        }
        let late = self.limits(tolerance).filter(|(limit, _)| *limit < now);
        let (limit, slot) = late.min_by_key(|&(limit, slot)| (limit, slot.mode, slot.part))?;
        Some(RevisionReason::Late { mode: slot.mode, part: self.part_of(slot), by: now.since(limit) })
    }

    /// Time until which the schedule holds, if nothing happens before.
    pub fn holds_until(&self, tolerance: Duration) -> Option<Tick> {
        self.limits(tolerance).map(|(limit, _)| limit).min()
    }

    /// Latest starts of what is to start next, and latest ends of what is in progress.
    fn limits(&self, tolerance: Duration) -> impl Iterator<Item = (Tick, &ScheduleSlot)> {
        let starts = self.next_of_parts().map(|(_, slot)| slot).chain(self.next_entering().map(|(_, slot)| slot));
        let starts = starts.map(move |slot| (slot.from + slot.float + tolerance, slot));
        let ends = self.in_progress().map(move |slot| (slot.to + slot.float + tolerance, slot));
        starts.chain(ends).filter(|(limit, _)| *limit != Tick::NEVER)
    }
}
