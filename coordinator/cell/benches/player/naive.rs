//! The peer: a player that searches all modes for the enabled ones after each firing.
//!
//! It does far less than the real one: tokens are counted and no parts are distinguished, nothing is sent or written down,
//! and it starts the first enabled mode.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Arc;

use linewright_coordinator_cell::{CellTable, ModeId};
use linewright_line::Tick;

use crate::floor::{time, traced};

/// Counts, and what is in progress.
pub struct Naive {
    table: Arc<CellTable>,
    counts: Vec<u64>,
    in_progress: Vec<u32>,
    /// In the order in which they have started, where they end at the same time.
    running: BinaryHeap<Reverse<(Tick, u64, ModeId)>>,
    now: Tick,
    pub firings: u64,
    pub trace: u64,
}

impl Naive {
    pub fn new(table: &Arc<CellTable>) -> Self {
        Naive {
            table: table.clone(),
            counts: table.initial().to_vec(),
            in_progress: vec![0; table.mode_count()],
            running: BinaryHeap::new(),
            now: Tick::ZERO,
            firings: 0,
            trace: 0,
        }
    }

    /// Plays until so many more have started.
    pub fn play(&mut self, firings: u64) {
        let until = self.firings + firings;
        while self.firings < until {
            self.end();
            match self.enabled().first() {
                Some(&mode) => self.start(mode),
                None => self.now = self.running.peek().expect("a cell that never gets stuck").0.0,
            }
        }
    }

    fn enabled(&self) -> Vec<ModeId> {
        let covered =
            |mode| self.table.takes(mode).iter().all(|&(cell, weight)| self.counts[cell.index()] >= u64::from(weight));
        let has_server = |mode: ModeId| self.in_progress[mode.index()] < self.table.activity(mode).servers;
        self.table.modes().filter(|&mode| covered(mode) && has_server(mode)).collect()
    }

    fn start(&mut self, mode: ModeId) {
        self.table.takes(mode).iter().for_each(|&(cell, weight)| self.counts[cell.index()] -= u64::from(weight));
        self.in_progress[mode.index()] += 1;
        self.firings += 1;
        self.running.push(Reverse((self.now + time(&self.table, mode), self.firings, mode)));
        self.trace = traced(self.trace, self.now, mode);
    }

    fn end(&mut self) {
        while let Some(&Reverse((_, _, mode))) = self.running.peek().filter(|Reverse((at, ..))| *at <= self.now) {
            self.running.pop();
            self.table.gives(mode).iter().for_each(|&(cell, weight)| self.counts[cell.index()] += u64::from(weight));
            self.in_progress[mode.index()] -= 1;
        }
    }
}
