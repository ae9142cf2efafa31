//! Modes that have their tokens, kept up to date firing by firing.
//!
//! A mode that cannot fire *watches* one cell of which it lacks tokens, as clauses watch literals in solvers for
//! satisfiability. Two invariants hold between calls: a mode that is enabled lacks nothing, and one that is not watches a
//! cell it lacks. So
//! - when tokens are **taken** from a cell, only the enabled modes that need this cell can be affected. They are listed at
//!   the cell; whichever is no longer covered is disabled and watches it.
//! - when tokens are **given** to a cell, only the modes that watch it can be affected. Each looks at its inputs in order,
//!   and is enabled or goes to watch another cell it lacks.
//!
//! # What a firing costs
//! The cells it touches, and for each of them the enabled modes that need it and the modes that watch it, times the inputs
//! of a mode. Modes that cannot fire for another reason are not looked at. Inputs are ordered so that what few modes
//! compete for comes first, so a robot that comes back wakes the modes whose part *and* whose target are there (any other
//! watches one of these two) and those that last lacked nothing but the robot: the size of the conflict, not of the
//! robot's reach, and independent of how many resources the cell has. Entering and leaving a list takes constant time.
//!
//! Parts do not matter here, their number does: identity enables nothing.

use super::ids::{CellId, ModeId};
use super::table::CellTable;

/// What a mode waits for, if anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum EnablingStatus {
    /// Enabled; its position in the list of those.
    Enabled(usize),
    /// It lacks tokens of this cell, and is on its list of watchers.
    Watches(CellId),
    /// It is not to be enabled whatever is there, and is on no list.
    Blocked,
}

/// The set of enabled modes. It does not hold the counts; every change of a count is reported to it, one cell at a
/// time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Enabling {
    status: Vec<EnablingStatus>,
    /// The enabled modes, those that are decided about and those that happen by themselves, in no order.
    decided: Vec<ModeId>,
    immediate: Vec<ModeId>,
    /// For each cell the input arcs of enabled modes that come from it.
    needed: Vec<Vec<usize>>,
    /// For each input arc of an enabled mode, where it is in that list.
    place_in_needed: Vec<usize>,
    watchers: Vec<Vec<ModeId>>,
    looks: u64,
}

impl Enabling {
    /// Of the given counts.
    pub fn new(table: &CellTable, counts: &[u64]) -> Self {
        let mut new = Enabling {
            status: vec![EnablingStatus::Enabled(0); table.mode_count()],
            decided: Vec::new(),
            immediate: Vec::new(),
            needed: vec![Vec::new(); table.cell_count()],
            place_in_needed: vec![0; table.arc_count()],
            watchers: vec![Vec::new(); table.cell_count()],
            looks: 0,
        };
        table.modes().for_each(|mode| new.settle(table, counts, mode));
        new
    }

    /// Whether a mode has its tokens.
    pub fn is_enabled(&self, mode: ModeId) -> bool {
        matches!(self.status[mode.index()], EnablingStatus::Enabled(_))
    }

    /// A cell of which a mode lacks tokens; none if it is enabled, or blocked.
    pub fn lacks(&self, mode: ModeId) -> Option<CellId> {
        match self.status[mode.index()] {
            EnablingStatus::Enabled(_) | EnablingStatus::Blocked => None,
            EnablingStatus::Watches(cell) => Some(cell),
        }
    }

    /// Keeps a mode from being enabled whatever is there, or does not any more.
    pub(super) fn block(&mut self, table: &CellTable, counts: &[u64], mode: ModeId, blocks: bool) {
        match (self.status[mode.index()], blocks) {
            (EnablingStatus::Blocked, true) | (EnablingStatus::Enabled(_) | EnablingStatus::Watches(_), false) => {
                return;
            }
            (EnablingStatus::Blocked, false) => return self.settle(table, counts, mode),
            (EnablingStatus::Enabled(_), true) => self.disable(table, mode),
            (EnablingStatus::Watches(cell), true) => self.watchers[cell.index()].retain(|&watcher| watcher != mode),
        }
        self.status[mode.index()] = EnablingStatus::Blocked;
    }

    /// The enabled modes that the dispatcher decides about, in no particular order.
    pub fn decided(&self) -> &[ModeId] {
        &self.decided
    }

    /// The enabled modes that happen by themselves, in no particular order.
    pub fn immediate(&self) -> &[ModeId] {
        &self.immediate
    }

    /// Number of input arcs looked at since the beginning: the cost.
    pub fn looks(&self) -> u64 {
        self.looks
    }

    /// Tokens of `cell` were taken; `counts` are those after that.
    pub(super) fn taken(&mut self, table: &CellTable, counts: &[u64], cell: CellId) {
        let has = counts[cell.index()];
        let mut at = 0;
        while let Some(&arc) = self.needed[cell.index()].get(at) {
            self.looks += 1;
            let (mode, (_, weight)) = table.arc(arc);
            if u64::from(weight) <= has {
                at += 1;
            } else {
                // This takes the arc off the list, and puts the last one in its place.
                self.disable(table, mode);
                self.watch(mode, cell);
            }
        }
    }

    /// Tokens were given to `cell`; `counts` are those after that.
    pub(super) fn given(&mut self, table: &CellTable, counts: &[u64], cell: CellId) {
        let mut list = std::mem::take(&mut self.watchers[cell.index()]);
        // Modes that go on watching this cell are put back on its list, which is empty now.
        list.drain(..).for_each(|mode| self.settle(table, counts, mode));
        let watchers = &mut self.watchers[cell.index()];
        if watchers.is_empty() {
            // For its memory's sake.
            *watchers = list;
        }
    }

    /// Enables a mode that is on no list, or has it watch the first cell it lacks.
    fn settle(&mut self, table: &CellTable, counts: &[u64], mode: ModeId) {
        for &(cell, weight) in table.takes(mode) {
            self.looks += 1;
            if counts[cell.index()] < u64::from(weight) {
                self.watch(mode, cell);
                return;
            }
        }
        for arc in table.arcs(mode) {
            let needed = &mut self.needed[table.arc(arc).1.0.index()];
            self.place_in_needed[arc] = needed.len();
            needed.push(arc);
        }
        let list = self.list(table, mode);
        let at = list.len();
        list.push(mode);
        self.status[mode.index()] = EnablingStatus::Enabled(at);
    }

    fn watch(&mut self, mode: ModeId, cell: CellId) {
        self.watchers[cell.index()].push(mode);
        self.status[mode.index()] = EnablingStatus::Watches(cell);
    }

    /// Takes an enabled mode off all lists.
    fn disable(&mut self, table: &CellTable, mode: ModeId) {
        for arc in table.arcs(mode) {
            let at = self.place_in_needed[arc];
            let needed = &mut self.needed[table.arc(arc).1.0.index()];
            needed.swap_remove(at);
            if let Some(&moved) = needed.get(at) {
                self.place_in_needed[moved] = at;
            }
        }
        if let EnablingStatus::Enabled(at) = self.status[mode.index()] {
            let list = self.list(table, mode);
            list.swap_remove(at);
            if let Some(&moved) = list.get(at) {
                self.status[moved.index()] = EnablingStatus::Enabled(at);
            }
        }
    }

    fn list(&mut self, table: &CellTable, mode: ModeId) -> &mut Vec<ModeId> {
        if table.is_immediate(mode) { &mut self.immediate } else { &mut self.decided }
    }
}
