//! True places of the parts of a cell, whatever its coordinator has.
//!
//! A part is where it was until all stations that are to move it or to work on it have really done their orders; then it is
//! where it was to go. Without orders it follows the records. The caller can move parts by hand, as faults and people do.
//! Sensors and the operator look here; the coordinator never does.

use std::collections::{BTreeMap, BTreeSet};

use linewright_coordinator_cell::exception::Whereabouts;
use linewright_coordinator_cell::{
    ActivityStep, CellTable, FiringId, ModeId, OrderKey, PartId, Record, ResourceId, TaskOutcome, TaskReply,
};

/// True places of the parts.
#[derive(Clone, Debug, Default)]
pub struct PartTruth {
    /// Of each part that is in the cell.
    at: BTreeMap<PartId, ResourceId>,
    /// Work really done on each part, in order, also of those that have left.
    pub done: BTreeMap<PartId, Vec<ModeId>>,
    moves: BTreeMap<FiringId, PartMove>,
    firing_of: BTreeMap<OrderKey, FiringId>,
}

/// Pending work on a part.
#[derive(Clone, Debug)]
struct PartMove {
    mode: ModeId,
    part: Option<PartId>,
    /// The orders that have not been done.
    open: BTreeSet<OrderKey>,
    is_done: bool,
}

/// Result of an inspection of a failed activity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InspectionResult {
    pub part: Whereabouts,
    /// All stations have done their orders.
    pub is_done: bool,
}

impl PartTruth {
    /// Place of a part; none if it is not in the cell.
    pub fn at(&self, part: PartId) -> Option<ResourceId> {
        self.at.get(&part).copied()
    }

    /// The parts that are in the cell.
    pub fn parts(&self) -> impl ExactSizeIterator<Item = PartId> + '_ {
        self.at.keys().copied()
    }

    /// Whether a resource has any part.
    pub fn has(&self, resource: ResourceId) -> bool {
        self.at.values().any(|&at| at == resource)
    }

    /// Moves a part by hand, or takes it away.
    pub fn put(&mut self, part: PartId, at: Option<ResourceId>) {
        match at {
            Some(at) => _ = self.at.insert(part, at),
            None => _ = self.at.remove(&part),
        }
    }

    /// Completes by hand an activity that was left undone.
    pub fn finish(&mut self, table: &CellTable, firing: FiringId) {
        self.go_on(table, firing);
    }

    /// Brings the part of an activity back to where it was.
    pub fn bring_back(&mut self, table: &CellTable, firing: FiringId) {
        if let Some((Some(part), mode)) = self.moves.get(&firing).map(|of| (of.part, of.mode)) {
            self.put(part, table.handling().mode(mode).from);
        }
    }

    /// Removes the part of an activity.
    pub fn take_away(&mut self, firing: FiringId) {
        self.moves.get(&firing).and_then(|of| of.part).into_iter().for_each(|part| self.put(part, None));
    }

    /// Inspects an activity.
    pub fn found(&self, table: &CellTable, firing: FiringId) -> Option<InspectionResult> {
        let of = self.moves.get(&firing)?;
        let handled = table.handling().mode(of.mode);
        let at = of.part.and_then(|part| self.at(part));
        // What is worked on stays where it is.
        let part = if at == handled.from && handled.from == handled.to {
            if of.is_done { Whereabouts::To } else { Whereabouts::From }
        } else if at == handled.to {
            Whereabouts::To
        } else if at == handled.from {
            Whereabouts::From
        } else if at.is_some() && at == handled.carrier {
            Whereabouts::Carrier
        } else {
            Whereabouts::Gone
        };
        Some(InspectionResult { part, is_done: of.is_done })
    }

    /// A record was written.
    pub(super) fn note(&mut self, table: &CellTable, record: &Record) {
        match record.fact.activity_step() {
            Some(ActivityStep::Started { firing, mode, part, orders }) => {
                orders.iter().for_each(|&key| _ = self.firing_of.insert(key, firing));
                let open = orders.iter().copied().collect();
                self.moves.insert(firing, PartMove { mode, part, open, is_done: false });
            }
            // By the clock alone.
            Some(ActivityStep::Ended { firing }) => self.go_on(table, firing),
            Some(ActivityStep::Fired { mode, part }) => self.go(table, mode, part),
            Some(ActivityStep::Raised { .. } | ActivityStep::Closed { .. }) | None => (),
        }
    }

    /// A station has ended an order.
    pub(super) fn ended(&mut self, table: &CellTable, key: OrderKey, reply: TaskReply) {
        let is_done = match reply {
            TaskReply::Ended(TaskOutcome::Done) => true,
            TaskReply::Ended(TaskOutcome::Failed(_)) | TaskReply::Running | TaskReply::Refused(_) => false,
        };
        let Some(&firing) = self.firing_of.get(&key).filter(|_| is_done) else { return };
        let Some(of) = self.moves.get_mut(&firing) else { return };
        if of.open.remove(&key) && of.open.is_empty() {
            self.go_on(table, firing);
        }
    }

    fn go_on(&mut self, table: &CellTable, firing: FiringId) {
        let Some(of) = self.moves.get_mut(&firing).filter(|of| !of.is_done) else { return };
        of.is_done = true;
        let (mode, part) = (of.mode, of.part);
        self.go(table, mode, part);
    }

    fn go(&mut self, table: &CellTable, mode: ModeId, part: Option<PartId>) {
        let Some(part) = part else { return };
        self.done.entry(part).or_default().push(mode);
        // A mode without resources moves a part within the resource that has it.
        let to = table.handling().mode(mode).to;
        if to.is_some() || table.part_out(mode).is_none() {
            self.put(part, to);
        }
    }
}
