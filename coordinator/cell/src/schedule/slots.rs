//! A schedule: planned starts, and their progress.
//!
//! Parts that have not entered have no number yet that could be relied on; so a schedule numbers parts by itself, and maps
//! each to its part as soon as it enters. Each slot has a *window*: from its planned start to the latest one that moves
//! nothing else in the schedule (its free float). The first promise stays with a slot through all revisions, so that plan
//! and actual can be compared.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::Duration;

use linewright_line::Tick;

use super::super::ahead::{PlannedStart, Score, SimulatedActivity};
use super::super::dispatch::Window;
use super::super::exception::Whereabouts;
use super::super::ids::{CellId, FiringId, ModeId, PartId};
use super::super::record::{ActivityStep, Record};
use super::super::state::PlayerState;
use super::super::table::CellTable;

/// Something that is to be done, is being done, or has been.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScheduleSlot {
    pub mode: ModeId,
    /// Its part, as the schedule numbers them; none for a mode that takes none.
    pub part: Option<usize>,
    /// Planned start.
    pub from: Tick,
    /// Planned end.
    pub to: Tick,
    /// Time that it can start later without moving anything else.
    pub float: Duration,
    /// First plan for it; none if it was not planned when it started.
    pub promised: Option<(Tick, Tick)>,
    /// Actual start.
    pub began: Option<Tick>,
    /// Actual end.
    pub ended: Option<Tick>,
    pub failed: bool,
    firing: Option<FiringId>,
}

/// Plan against actual, of one activity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlanActualBar {
    pub mode: ModeId,
    /// Its part; none if it takes none, or has not entered.
    pub part: Option<PartId>,
    /// First plan; none if it was never planned.
    pub promised: Option<(Tick, Tick)>,
    /// Last plan.
    pub planned: Option<(Tick, Tick)>,
    /// Actual start and end, as far as they have happened.
    pub actual: Option<(Tick, Option<Tick>)>,
    pub failed: bool,
}

/// Planned starts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Schedule {
    /// Time at which it was made.
    pub made: Tick,
    /// Its result, if all takes its nominal time.
    pub score: Score,
    /// No schedule is less late, and none as late is finished earlier.
    pub proved: bool,
    /// In the order in which they start; those that were in progress come first.
    slots: Vec<ScheduleSlot>,
    /// Their parts; none for those that have not entered.
    parts: Vec<Option<PartId>>,
    /// Of each part its slots that have not started.
    open: Vec<VecDeque<usize>>,
    /// Of each mode that takes no part its slots that have not started, and those of parts that have not entered.
    entering: BTreeMap<ModeId, VecDeque<usize>>,
    running: BTreeMap<FiringId, usize>,
    /// Starts that were not planned.
    strays: Vec<usize>,
}

impl Schedule {
    /// From the activities of a forward simulation.
    pub fn new(state: &PlayerState, now: Tick, acts: &[SimulatedActivity], score: Score, proved: bool) -> Self {
        let table = state.table();
        let mut new = Schedule { made: now, score, proved, ..Schedule::default() };
        let mut known: BTreeMap<PartId, usize> = BTreeMap::new();
        let mut firings = state.firings();
        for act in acts {
            let part = act.part.map(|id| {
                *known.entry(id).or_insert_with(|| {
                    new.parts.push(state.part(id).map(|part| part.id));
                    new.open.push(VecDeque::new());
                    new.parts.len() - 1
                })
            });
            let firing = if act.was_running { firings.next() } else { None };
            let to = act.to.unwrap_or(Tick::NEVER);
            let slot = ScheduleSlot {
                mode: act.mode,
                part,
                from: act.from,
                to,
                float: Duration::ZERO,
                promised: (!act.was_running).then_some((act.from, to)),
                began: firing.map(|firing| firing.began),
                ended: None,
                failed: act.was_running && act.to.is_none(),
                firing: firing.map(|firing| firing.id),
            };
            let at = new.slots.len();
            match (slot.firing, part) {
                (Some(firing), _) => _ = new.running.insert(firing, at),
                (None, Some(part)) if table.part_in(act.mode).is_some() => new.open[part].push_back(at),
                (None, _) => new.entering.entry(act.mode).or_default().push_back(at),
            }
            new.slots.push(slot);
        }
        new.floats(table);
        new
    }

    /// Time that each slot can slip before something that takes what it gives is in its way.
    fn floats(&mut self, table: &CellTable) {
        let mut taken: BTreeMap<CellId, Vec<Tick>> = BTreeMap::new();
        for slot in self.slots.iter().filter(|slot| slot.began.is_none()) {
            table.takes(slot.mode).iter().for_each(|&(cell, _)| taken.entry(cell).or_default().push(slot.from));
        }
        taken.values_mut().for_each(|starts| starts.sort_unstable());
        let end = self.slots.iter().map(|slot| slot.to).filter(|&to| to != Tick::NEVER).max().unwrap_or(self.made);
        for slot in &mut self.slots {
            let next = table.gives(slot.mode).iter().filter_map(|(cell, _)| {
                let starts = taken.get(cell)?;
                starts.get(starts.partition_point(|&from| from < slot.to)).copied()
            });
            slot.float = next.chain([end]).min().unwrap_or(end).since(slot.to);
        }
    }

    /// All slots, by planned start.
    pub fn slots(&self) -> &[ScheduleSlot] {
        &self.slots
    }

    /// Part of a slot, once it has entered.
    pub fn part_of(&self, slot: &ScheduleSlot) -> Option<PartId> {
        self.parts[slot.part?]
    }

    /// Whether nothing of it is left to be started.
    pub fn is_over(&self) -> bool {
        self.open.iter().all(VecDeque::is_empty) && self.entering.values().all(VecDeque::is_empty)
    }

    /// Starts that were not planned.
    pub fn strays(&self) -> impl Iterator<Item = &ScheduleSlot> {
        self.strays.iter().map(|&at| &self.slots[at])
    }

    /// Next start of a part.
    pub fn next_of(&self, part: PartId) -> Option<&ScheduleSlot> {
        let at = self.parts.iter().position(|known| *known == Some(part))?;
        self.open[at].front().map(|&slot| &self.slots[slot])
    }

    /// Next start of each part inside.
    pub(super) fn next_of_parts(&self) -> impl Iterator<Item = (PartId, &ScheduleSlot)> {
        let pairs = self.parts.iter().zip(&self.open);
        pairs.filter_map(|(part, open)| Some(((*part)?, &self.slots[*open.front()?])))
    }

    /// Next entry by each mode, or next start without a part.
    pub(super) fn next_entering(&self) -> impl Iterator<Item = (ModeId, &ScheduleSlot)> {
        self.entering.iter().filter_map(|(&mode, slots)| Some((mode, &self.slots[*slots.front()?])))
    }

    pub(super) fn in_progress(&self) -> impl Iterator<Item = &ScheduleSlot> {
        self.running.values().map(|&at| &self.slots[at])
    }

    /// Takes a record: a planned start, or an end, has happened.
    pub fn note(&mut self, table: &CellTable, record: &Record) {
        match record.fact.activity_step() {
            Some(ActivityStep::Started { firing, mode, part, orders: _ }) => {
                self.started(table, record.at, firing, mode, part)
            }
            Some(ActivityStep::Ended { firing }) => {
                if let Some(at) = self.running.remove(&firing) {
                    self.slots[at].ended = Some(record.at);
                }
            }
            Some(ActivityStep::Raised { firing, cause: _ }) => {
                if let Some(at) = self.running.remove(&firing) {
                    self.slots[at].failed = true;
                }
            }
            Some(ActivityStep::Closed { firing, ruling }) if ruling.part == Whereabouts::To => {
                let slot = self.slots.iter_mut().find(|slot| slot.firing == Some(firing));
                slot.into_iter().for_each(|slot| slot.ended = Some(record.at));
            }
            Some(ActivityStep::Closed { .. } | ActivityStep::Fired { .. }) | None => (),
        }
    }

    fn started(&mut self, table: &CellTable, now: Tick, firing: FiringId, mode: ModeId, part: Option<PartId>) {
        let planned = match part.filter(|_| table.part_in(mode).is_some()) {
            Some(part) => {
                let of = self.parts.iter().position(|known| *known == Some(part));
                let open = of.map(|of| &mut self.open[of]);
                let open = open.filter(|open| open.front().is_some_and(|&at| self.slots[at].mode == mode));
                open.and_then(VecDeque::pop_front)
            }
            None => self.entering.get_mut(&mode).and_then(VecDeque::pop_front),
        };
        let at = planned.unwrap_or_else(|| self.stray(now, mode, part));
        if let (Some(own), Some(part)) = (self.slots[at].part, part) {
            self.parts[own] = Some(part);
        }
        (self.slots[at].began, self.slots[at].firing) = (Some(now), Some(firing));
        self.running.insert(firing, at);
    }

    fn stray(&mut self, now: Tick, mode: ModeId, part: Option<PartId>) -> usize {
        let at = self.slots.len();
        let part = part.map(|part| {
            self.parts.iter().position(|known| *known == Some(part)).unwrap_or_else(|| {
                self.parts.push(Some(part));
                self.open.push(VecDeque::new());
                self.parts.len() - 1
            })
        });
        self.strays.push(at);
        self.slots.push(ScheduleSlot {
            mode,
            part,
            from: now,
            to: Tick::NEVER,
            float: Duration::ZERO,
            promised: None,
            began: None,
            ended: None,
            failed: false,
            firing: None,
        });
        at
    }

    /// Starts that are left, in their order, for a cell as it is: parts that have not entered get the numbers that they
    /// will have.
    pub(super) fn rest(&self, state: &PlayerState) -> VecDeque<PlannedStart> {
        let table = state.table();
        let mut coming = state.last_part;
        let mut numbers = self.parts.clone();
        let mut rest = VecDeque::new();
        for slot in self.slots.iter().filter(|slot| slot.began.is_none()) {
            let takes = table.part_in(slot.mode).is_some();
            if let Some(own) = slot.part.filter(|&own| !takes && numbers[own].is_none()) {
                coming += 1;
                numbers[own] = Some(PartId(coming));
            }
            let part = slot.part.filter(|_| takes).and_then(|own| numbers[own]);
            rest.push_back(PlannedStart { at: slot.from, mode: slot.mode, part });
        }
        rest
    }

    /// Takes over promises, and keeps the times of slots that would move by no more than a tolerance.
    pub(super) fn keep(&mut self, previous: &Schedule, tolerance: Duration) {
        let mut before: BTreeMap<(Option<PartId>, ModeId), VecDeque<&ScheduleSlot>> = BTreeMap::new();
        for slot in &previous.slots {
            before.entry((previous.part_of(slot), slot.mode)).or_default().push_back(slot);
        }
        for at in 0..self.slots.len() {
            let key = (self.part_of(&self.slots[at]), self.slots[at].mode);
            let began = self.slots[at].began;
            let Some(old) = before.get_mut(&key).and_then(|slots| {
                slots.retain(|slot| slot.began == began);
                slots.pop_front()
            }) else {
                continue;
            };
            let slot = &mut self.slots[at];
            slot.promised = old.promised.or(slot.promised.filter(|_| slot.began.is_none()));
            let moved = slot.from.since(old.from).max(old.from.since(slot.from));
            if slot.began.is_some() {
                // When it started is known; when it was to is what a chart compares that with.
                slot.from = old.from;
            } else if moved <= tolerance {
                (slot.from, slot.to, slot.float) = (old.from, old.to, old.float);
            }
        }
    }

    /// Plan against actual, in the order of the plan.
    pub fn bars(&self) -> impl Iterator<Item = PlanActualBar> + '_ {
        self.slots.iter().map(|slot| self.bar(slot))
    }

    /// Plan against actual of all that was over when another schedule was made, which is the next one.
    pub(super) fn over_before(&self, next: &Schedule) -> impl Iterator<Item = PlanActualBar> + '_ {
        let known: BTreeSet<FiringId> = next.slots.iter().filter_map(|slot| slot.firing).collect();
        let is_over = |slot: &&ScheduleSlot| slot.failed || slot.ended.is_some();
        let is_left = move |slot: &&ScheduleSlot| slot.firing.is_none_or(|firing| !known.contains(&firing));
        self.slots.iter().filter(is_over).filter(is_left).map(|slot| self.bar(slot))
    }

    fn bar(&self, slot: &ScheduleSlot) -> PlanActualBar {
        PlanActualBar {
            mode: slot.mode,
            part: self.part_of(slot),
            promised: slot.promised,
            planned: slot.promised.map(|_| (slot.from, slot.to)),
            actual: slot.began.map(|began| (began, slot.ended)),
            failed: slot.failed,
        }
    }
}

impl ScheduleSlot {
    /// Window of its start: from its planned start to the latest that moves nothing else.
    pub fn window(&self) -> Window {
        Window { from: self.from, until: self.from + self.float }
    }
}
