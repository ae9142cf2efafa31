//! The states that a search keeps, what follows each, and from where each was first reached.

use super::search::SearchLimits;
use super::table::{StateKey, StateTable};

/// States and what follows them, by number.
#[derive(Debug)]
pub(crate) struct StateStore<const N: usize> {
    table: StateTable<N>,
    /// For each state, the one it was first reached from.
    came_from: Vec<u32>,
    /// States of which it is known what follows them.
    looked_at: u32,
    /// Whether what follows is kept. It takes most of the memory, and only what is asked of all states together needs it.
    keeps_arcs: bool,
    /// The numbers of the states that follow each, one state after the other.
    arcs: Vec<u32>,
    /// Index after the last one of each state.
    arcs_until: Vec<u64>,
    scratch: Vec<(u64, u64)>,
}

/// Successors that are looked up together.
#[derive(Debug)]
pub(crate) struct Batch<const N: usize> {
    pub keys: Vec<StateKey<N>>,
    /// For each state, where its successors end.
    pub ends: Vec<usize>,
    /// Memory that the other thread takes.
    pub bytes: usize,
}

/// Result of entering a batch.
#[derive(Debug)]
pub(crate) struct InsertResult<const N: usize> {
    /// The states that are new, in the order of their numbers.
    pub new: Vec<StateKey<N>>,
    /// They take as much memory as they may, or numbers run out.
    pub full: bool,
}

impl<const N: usize> Batch<N> {
    /// The keys added since `begin` are the successors of one state. Each needs to be there once.
    pub fn close(&mut self, begin: usize) {
        self.keys[begin..].sort_unstable();
        let mut until = begin;
        for at in begin..self.keys.len() {
            if at == begin || self.keys[at] != self.keys[until - 1] {
                self.keys[until] = self.keys[at];
                until += 1;
            }
        }
        self.keys.truncate(until);
        self.ends.push(until);
    }
}

impl<const N: usize> StateStore<N> {
    pub fn new(keeps_arcs: bool) -> Self {
        StateStore {
            table: StateTable::new(),
            came_from: Vec::new(),
            looked_at: 0,
            keeps_arcs,
            arcs: Vec::new(),
            arcs_until: Vec::new(),
            scratch: Vec::new(),
        }
    }

    /// Enters the successors of the states that come next in order. The start alone is no successor.
    pub fn enter(&mut self, batch: &Batch<N>, limits: SearchLimits) -> InsertResult<N> {
        let (first_new, first_arc) = (self.table.len() as u32, self.arcs.len());
        self.table.enter_all(&batch.keys, &mut self.scratch, &mut self.arcs);
        if batch.ends.is_empty() {
            self.came_from.push(0);
            self.arcs.clear();
        }
        let (mut newest, mut begin) = (first_new, 0);
        for &end in &batch.ends {
            for &number in &self.arcs[first_arc + begin..first_arc + end] {
                if number == newest {
                    self.came_from.push(self.looked_at);
                    newest += 1;
                }
            }
            begin = end;
            self.looked_at += 1;
            if self.keeps_arcs {
                self.arcs_until.push((first_arc + end) as u64);
            }
        }
        if !self.keeps_arcs {
            self.arcs.clear();
        }
        let new = (first_new..self.table.len() as u32).map(|number| *self.table.key(number)).collect();
        let full = self.table.is_full() || self.bytes() + batch.bytes > limits.bytes;
        InsertResult { new, full }
    }

    pub fn len(&self) -> usize {
        self.table.len()
    }

    pub fn key(&self, number: u32) -> &StateKey<N> {
        self.table.key(number)
    }

    /// The state from which one was first reached; the start is its own.
    pub fn came_from(&self, number: u32) -> u32 {
        self.came_from[number as usize]
    }

    /// The numbers of the states that follow one that has been looked at, where they are kept.
    pub fn followers(&self, number: u32) -> &[u32] {
        let number = number as usize;
        let begin = if number == 0 { 0 } else { self.arcs_until[number - 1] };
        &self.arcs[begin as usize..self.arcs_until[number] as usize]
    }

    pub fn bytes(&self) -> usize {
        let numbers = (self.came_from.capacity() + self.arcs.capacity()) * size_of::<u32>();
        self.table.bytes() + numbers + self.arcs_until.capacity() * size_of::<u64>()
    }
}
