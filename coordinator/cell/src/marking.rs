//! Places of the tokens, and the parts among them.
//!
//! Every cell has a count. A cell of parts has them beside it, in the order in which they came: a store that is emptied
//! from one end has its next, and a decision between equals can prefer the one that has waited longest. The two agree
//! always; counts are what enables.

use std::collections::BTreeMap;

use super::ids::{CellId, PartId};
use super::plan::{CellKind, PartPick};
use super::table::CellTable;

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellMarking {
    counts: Vec<u64>,
    /// Of each cell, its parts by when they came; empty for cells of plain tokens.
    parts: Vec<BTreeMap<u64, PartId>>,
    /// Number of parts that have come to a cell so far.
    arrivals: u64,
}

impl CellMarking {
    /// The table's initial counts, without any part yet.
    pub(super) fn new(table: &CellTable) -> Self {
        let is_parts = |cell: CellId| matches!(table.kind(cell), CellKind::Parts(_));
        let counts = table.cells().map(|cell| if is_parts(cell) { 0 } else { table.initial()[cell.index()] });
        CellMarking { counts: counts.collect(), parts: vec![BTreeMap::new(); table.cell_count()], arrivals: 0 }
    }

    /// Nothing, after so many arrivals.
    pub(super) fn empty(table: &CellTable, arrivals: u64) -> Self {
        let cells = table.cell_count();
        CellMarking { counts: vec![0; cells], parts: vec![BTreeMap::new(); cells], arrivals }
    }

    /// Sets the number of tokens.
    pub(super) fn set(&mut self, cell: CellId, count: u64) {
        self.counts[cell.index()] = count;
    }

    /// A part that came as that number; whether no other did.
    pub(super) fn lay(&mut self, cell: CellId, arrival: u64, part: PartId) -> bool {
        self.give(cell, 1);
        self.parts[cell.index()].insert(arrival, part).is_none()
    }

    /// Number of parts that have come to a cell so far.
    pub(super) fn arrivals(&self) -> u64 {
        self.arrivals
    }

    /// The counts of all cells, in their order.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    pub fn count(&self, cell: CellId) -> u64 {
        self.counts[cell.index()]
    }

    /// The parts of a cell, the one that came first first.
    pub fn parts(&self, cell: CellId) -> impl DoubleEndedIterator<Item = PartId> + ExactSizeIterator + '_ {
        self.parts[cell.index()].values().copied()
    }

    /// Those of its parts that can be taken, in the same order.
    pub(super) fn takeable(&self, cell: CellId, pick: PartPick) -> impl Iterator<Item = PartId> + '_ {
        let parts = &self.parts[cell.index()];
        let (from, most) = match pick {
            PartPick::Any => (0, usize::MAX),
            PartPick::Oldest => (0, 1),
            PartPick::Newest => (parts.last_key_value().map_or(0, |(&arrival, _)| arrival), 1),
        };
        parts.range(from..).take(most).map(|(_, &part)| part)
    }

    /// Whether a part that is on a cell, since an arrival, can be taken from it.
    pub(super) fn is_takeable(&self, cell: CellId, pick: PartPick, arrival: u64) -> bool {
        let parts = &self.parts[cell.index()];
        match pick {
            PartPick::Any => true,
            PartPick::Oldest => parts.first_key_value().is_some_and(|(&first, _)| first == arrival),
            PartPick::Newest => parts.last_key_value().is_some_and(|(&last, _)| last == arrival),
        }
    }

    /// Takes tokens that are there.
    pub(super) fn take(&mut self, cell: CellId, weight: u32) {
        let count = &mut self.counts[cell.index()];
        *count = count.saturating_sub(u64::from(weight));
    }

    /// Gives tokens. Some 10¹⁰ firings of the greatest weight there is would be needed to leave 64 bits.
    pub(super) fn give(&mut self, cell: CellId, weight: u32) {
        let count = &mut self.counts[cell.index()];
        *count = count.saturating_add(u64::from(weight));
    }

    /// Makes one of the tokens just given this part; its arrival.
    pub(super) fn put(&mut self, cell: CellId, part: PartId) -> u64 {
        self.arrivals += 1;
        self.parts[cell.index()].insert(self.arrivals, part);
        self.arrivals
    }

    /// Which part one of the tokens just given is, when it has not been away: where the first is taken it is the first
    /// again; its arrival.
    pub(super) fn put_back(&mut self, cell: CellId, kind: CellKind, part: PartId) -> u64 {
        let first = self.parts[cell.index()].first_key_value().map(|(&first, _)| first);
        match (kind, first) {
            // A part taken before the first that is there came before it, so there is such a number.
            (CellKind::Parts(PartPick::Oldest), Some(first)) if first > 1 => {
                self.parts[cell.index()].insert(first - 1, part);
                first - 1
            }
            (CellKind::Parts(PartPick::Oldest | PartPick::Any | PartPick::Newest) | CellKind::Tokens, _) => {
                self.put(cell, part)
            }
        }
    }

    /// Removes the part that one of the tokens just taken was.
    pub(super) fn pull(&mut self, cell: CellId, arrival: u64) {
        self.parts[cell.index()].remove(&arrival);
    }
}
