//! A complete set of reachable markings as a graph whose nodes are numbers, whatever it is stored in.
//!
//! Arcs are not stored: they are found by firing again. What needs the graph as a graph (components, paths, writing it
//! to a file) goes through here.

use std::sync::atomic::Ordering::Relaxed;

use super::bitmap::{BitmapLayout, Cursor, Kernel};
use super::encoding::MarkingEncoding;
use super::sweep::Bitmap;
use super::table::{FiringScratch, MarkingTable};
use crate::Marking;

/// The markings, numbered from zero.
pub(super) trait Space {
    /// Number of markings.
    fn len(&self) -> usize;
    /// Of a number.
    fn marking(&self, state: u32) -> Marking;
    /// Calls back with (transition, successor), in the order of transitions.
    fn successors(&mut self, state: u32, found: &mut dyn FnMut(u32, u32));
}

/// Of a table.
pub(super) struct TableSpace<'t, 'n> {
    pub(super) table: &'t MarkingTable<'n>,
    pub(super) scratch: FiringScratch,
}

impl Space for TableSpace<'_, '_> {
    fn len(&self) -> usize {
        self.table.len()
    }

    fn marking(&self, state: u32) -> Marking {
        self.table.marking(state)
    }

    fn successors(&mut self, state: u32, found: &mut dyn FnMut(u32, u32)) {
        self.table.successors(state, &mut self.scratch, found);
    }
}

/// Of a bitmap: a state's number is how many have a smaller code.
pub(super) struct BitmapSpace<'a> {
    encoding: &'a MarkingEncoding,
    layout: &'a BitmapLayout,
    kernel: &'a Kernel,
    cursor: Cursor<'a>,
    set: &'a Bitmap,
    /// Per word, the states before it; and at the end, all.
    before: Vec<u32>,
}

impl<'a> BitmapSpace<'a> {
    /// Bytes that the numbering takes for so many words.
    pub(super) fn bytes(words: usize) -> usize {
        (words + 1) * size_of::<u32>()
    }

    /// `kernel` plays forwards. There are fewer states than 32 bits can count.
    pub(super) fn new(
        encoding: &'a MarkingEncoding,
        layout: &'a BitmapLayout,
        kernel: &'a Kernel,
        set: &'a Bitmap,
    ) -> Self {
        let mut before = Vec::with_capacity(set.len() + 1);
        let mut count = 0;
        for word in set {
            before.push(count);
            count += word.load(Relaxed).count_ones();
        }
        before.push(count);
        BitmapSpace { encoding, layout, kernel, cursor: kernel.cursor(), set, before }
    }

    /// The number of a marking in the set.
    pub(super) fn number(&self, word: usize, bit: u32) -> u32 {
        self.before[word] + (self.set[word].load(Relaxed) & ((1 << bit) - 1)).count_ones()
    }

    /// Where a state is.
    pub(super) fn place_of(&self, state: u32) -> (usize, u32) {
        let word = self.before.partition_point(|&before| before <= state) - 1;
        let mut bits = self.set[word].load(Relaxed);
        for _ in self.before[word]..state {
            bits &= bits - 1;
        }
        (word, bits.trailing_zeros())
    }
}

impl Space for BitmapSpace<'_> {
    fn len(&self) -> usize {
        self.before.last().map_or(0, |&count| count as usize)
    }

    fn marking(&self, state: u32) -> Marking {
        let (word, bit) = self.place_of(state);
        self.layout.marking(word, bit, self.encoding)
    }

    fn successors(&mut self, state: u32, found: &mut dyn FnMut(u32, u32)) {
        let (word, bit) = self.place_of(state);
        self.cursor.go(word);
        for at in 0..self.cursor.candidates().len() {
            let mut rest = self.cursor.candidates()[at];
            while rest != 0 {
                let rule = &self.kernel.rules[at * 64 + rest.trailing_zeros() as usize];
                rest &= rest - 1;
                let mut enabled = (1 << bit) & rule.low;
                rule.mixed.iter().for_each(|condition| enabled &= condition.mask(&self.cursor.digits));
                if enabled != 0 {
                    let target = word.wrapping_add_signed(rule.jump);
                    found(rule.transition, self.number(target, rule.moved(enabled).trailing_zeros()));
                }
            }
        }
    }
}
