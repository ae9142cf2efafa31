//! Book-keeping over the events of a line: is every cycle of every operation done, and done once?
//!
//! A completed operation is entered under its cycle number; a withdrawn count strikes the last entry out again. What
//! is left must read 1, 2, 3 … without a gap or a double. The ledger believes the stations' events; that the events
//! are true to the mechanisms is the observer's business.

use linewright_line::net::Block;
use linewright_line::{Line, OpId, StationId};
use linewright_station_logic::{HappeningKind, StationHappening};

/// The entries of every operation.
#[derive(Clone, Debug)]
pub struct Ledger {
    /// By station, by operation: the first cycle number that is to be entered.
    first: Vec<Vec<i32>>,
    entries: Vec<Vec<Vec<i32>>>,
    /// Entries struck out, by station: documented redo.
    struck: Vec<u64>,
    errors: Vec<String>,
    /// Stations without memory, until the next founding: their counts are not compared.
    uncounted: Vec<bool>,
}

impl Ledger {
    pub(crate) fn new(line: &Line) -> Self {
        let first = |station: &linewright_line::Station| {
            station.op_ids().map(|op| station.home_count(op, station.initial_round()) + 1).collect()
        };
        Ledger {
            first: line.stations.iter().map(first).collect(),
            entries: line.stations.iter().map(|s| vec![Vec::new(); s.operations.len()]).collect(),
            struck: vec![0; line.stations.len()],
            errors: Vec::new(),
            uncounted: vec![false; line.stations.len()],
        }
    }

    /// A station has lost its memory.
    pub(crate) fn lose(&mut self, station: StationId) {
        self.uncounted[station.index()] = true;
    }

    pub(crate) fn enter(&mut self, line: &Line, station: StationId, event: &StationHappening) {
        if event.what == HappeningKind::Founded {
            // Counts begin anew.
            let fresh = Ledger::new(line);
            self.first[station.index()].clone_from(&fresh.first[station.index()]);
            self.entries[station.index()].iter_mut().for_each(Vec::clear);
            self.uncounted[station.index()] = false;
        }
        if self.uncounted[station.index()] {
            return;
        }
        let entries = &mut self.entries[station.index()];
        match event.what {
            HappeningKind::Completed(op, Block::Normal) => {
                let last = entries[op.index()].last().copied();
                let due = last.map_or(self.first[station.index()][op.index()], |last| last + 1);
                if event.cycle != due {
                    self.errors.push(format!(
                        "{}: {} completed in cycle {}, due was {due}",
                        line.station(station).name,
                        line.operation((station, op)).name,
                        event.cycle
                    ));
                }
                entries[op.index()].push(event.cycle);
            }
            HappeningKind::Withdrawn(ops) => {
                for op in (0..entries.len()).filter(|op| ops & (1 << op) != 0) {
                    self.struck[station.index()] += 1;
                    if entries[op].pop().is_none() {
                        // The count of the home position itself was taken back.
                        self.first[station.index()][op] -= 1;
                    }
                }
            }
            _ => {}
        }
    }

    /// The cycles in which an operation is done and not withdrawn.
    pub fn cycles(&self, station: StationId, op: OpId) -> &[i32] {
        &self.entries[station.index()][op.index()]
    }

    /// The count of an operation: the last cycle in which it is done and not withdrawn.
    pub fn count(&self, station: StationId, op: OpId) -> i32 {
        let last = self.entries[station.index()][op.index()].last().copied();
        last.unwrap_or(self.first[station.index()][op.index()] - 1)
    }

    /// How many counts a station has taken back.
    pub fn struck(&self, station: StationId) -> u64 {
        self.struck[station.index()]
    }

    /// Gaps and doubles found so far.
    pub fn errors(&self) -> &[String] {
        &self.errors
    }
}
