//! Sets of markings as a table of exact keys, for nets whose codes are too many for a bitmap.
//!
//! A key is the digits side by side in as few 64-bit words as they take, no digit across a boundary. Keys are kept in
//! the order of discovery, breadth first, and found again through an open-addressing index that holds, per slot, half
//! of a hash and the number of the key; a match of the hash is confirmed by comparing the keys themselves. The queue of
//! the search is the tail of the keys. Nothing is kept about arcs: they are fired again when they are needed.
//!
//! A digit that no sum bounds starts narrow. When it overflows, all keys are written anew with a wider one.

use super::encoding::MarkingEncoding;
use super::limits::{ExplorationLimit, ExplorationLimits, ExplorationUndecided, MemoryBudget};
use super::rules::{Filter, FiringRule, PlayDirection, rules};
use crate::{Marking, Net};

/// Bits that a digit without a bound starts with, above what its first value takes.
const SPARE_BITS: u32 = 2;
/// Index slots at the start.
const SLOTS_MIN: usize = 64;
/// State numbers have 32 bits, and two values are not numbers.
const STATES_MAX: u64 = u32::MAX as u64 - 2;

/// Where a digit is in a key.
#[derive(Clone, Copy, Debug)]
struct DigitField {
    word: usize,
    shift: u32,
    bits: u32,
}

impl DigitField {
    fn most(self) -> u64 {
        if self.bits == 0 { 0 } else { u64::MAX >> (64 - self.bits) }
    }
}

/// The fields of all digits.
#[derive(Clone, Debug)]
pub(super) struct Packing {
    fields: Vec<DigitField>,
    /// Words per key.
    pub(super) words: usize,
}

impl Packing {
    fn new(bits: &[u32]) -> Self {
        let (mut word, mut shift) = (0, 0);
        let mut fields = Vec::with_capacity(bits.len());
        for &bits in bits {
            if shift + bits > 64 {
                (word, shift) = (word + 1, 0);
            }
            fields.push(DigitField { word, shift, bits });
            shift += bits;
        }
        Packing { fields, words: word + 1 }
    }

    fn pack(&self, digits: &[u32], key: &mut [u64]) {
        key.fill(0);
        for (field, &digit) in self.fields.iter().zip(digits) {
            if field.bits > 0 {
                key[field.word] |= u64::from(digit) << field.shift;
            }
        }
    }

    #[inline]
    fn unpack(&self, key: &[u64], digits: &mut [u32]) {
        for (field, digit) in self.fields.iter().zip(digits) {
            // A field without bits may start past the end of its word.
            *digit = if field.bits == 0 { 0 } else { ((key[field.word] >> field.shift) & field.most()) as u32 };
        }
    }

    /// Change of a key by a change of digits: words, with the addend of each.
    fn delta(&self, change: &[(usize, i64)]) -> Vec<(usize, u64)> {
        let mut words: Vec<(usize, u64)> = Vec::new();
        for &(digit, by) in change {
            let field = self.fields[digit];
            // A transition that moves a digit past its field is never enabled; its delta does not matter.
            let add = (by as u64).checked_shl(field.shift).unwrap_or(0);
            match words.iter_mut().find(|(word, _)| *word == field.word) {
                Some((_, sum)) => *sum = sum.wrapping_add(add),
                None => words.push((field.word, add)),
            }
        }
        words
    }
}

/// One way of playing, over keys.
#[derive(Debug)]
struct KeyPlay {
    rules: Vec<FiringRule>,
    filter: Filter,
    deltas: Vec<Vec<(usize, u64)>>,
}

impl KeyPlay {
    fn new(net: &Net, encoding: &MarkingEncoding, packing: &Packing, direction: PlayDirection) -> Self {
        let mut rules = rules(net, encoding, direction);
        let filter = Filter::take(&mut rules, &encoding.radices, |_| true);
        let deltas = rules.iter().map(|rule| packing.delta(&rule.change)).collect();
        KeyPlay { rules, filter, deltas }
    }

    /// Calls back for every rule that is enabled, with its number.
    #[inline]
    fn enabled(&self, digits: &[u32], set: &mut [u64], mut found: impl FnMut(usize)) {
        set.copy_from_slice(self.filter.all());
        for (digit, &value) in digits.iter().enumerate() {
            if let Some(allowed) = self.filter.of(digit, value) {
                set.iter_mut().zip(allowed).for_each(|(own, allowed)| *own &= allowed);
            }
        }
        for (at, &word) in set.iter().enumerate() {
            let mut rest = word;
            while rest != 0 {
                let rule = at * 64 + rest.trailing_zeros() as usize;
                rest &= rest - 1;
                if self.rules[rule].conditions.iter().all(|condition| condition.holds(digits)) {
                    found(rule);
                }
            }
        }
    }
}

/// Room for one marking's worth of work.
#[derive(Debug)]
pub(super) struct FiringScratch {
    digits: Vec<u32>,
    set: Vec<u64>,
    enabled: Vec<u32>,
    key: Vec<u64>,
}

/// A set of markings that grows, with the rules that make it grow.
#[derive(Debug)]
pub(super) struct MarkingTable<'a> {
    net: &'a Net,
    encoding: &'a MarkingEncoding,
    packing: Packing,
    forth: KeyPlay,
    back: KeyPlay,
    keys: Vec<u64>,
    slots: Vec<u64>,
    count: usize,
    pub(super) budget: MemoryBudget,
    limit_states: u64,
}

/// Result of firing.
enum FiringResult {
    Known(u32),
    New(u32),
    /// A digit is too narrow for this many bits.
    Narrow(usize, u32),
}

impl<'a> MarkingTable<'a> {
    /// The set of the initial marking.
    pub(super) fn new(
        net: &'a Net,
        encoding: &'a MarkingEncoding,
        limits: &ExplorationLimits,
    ) -> Result<Self, ExplorationUndecided> {
        MarkingTable::with_bits(net, encoding, limits, 0)
    }

    /// The table with at least this number of bits per digit.
    pub(super) fn with_bits(
        net: &'a Net,
        encoding: &'a MarkingEncoding,
        limits: &ExplorationLimits,
        least: u32,
    ) -> Result<Self, ExplorationUndecided> {
        let initial = encoding.digits(&net.initial_marking());
        let width = |(radix, &digit): (&Option<u32>, &u32)| match radix {
            Some(radix) => u32::BITS - (radix - 1).leading_zeros(),
            None => (u32::BITS - digit.leading_zeros() + SPARE_BITS).min(u32::BITS),
        };
        let bits: Vec<u32> = encoding.radices.iter().zip(&initial).map(width).map(|bits| bits.max(least)).collect();
        let packing = Packing::new(&bits);
        let mut table = MarkingTable {
            net,
            encoding,
            forth: KeyPlay::new(net, encoding, &packing, PlayDirection::Fire),
            back: KeyPlay::new(net, encoding, &packing, PlayDirection::FireBack),
            packing,
            keys: Vec::new(),
            slots: Vec::new(),
            count: 0,
            budget: MemoryBudget::new(limits.bytes),
            limit_states: limits.states.min(STATES_MAX),
        };
        table.grow_index()?;
        let mut key = vec![0; table.packing.words];
        table.packing.pack(&initial, &mut key);
        table.insert(&key)?;
        Ok(table)
    }

    /// Number of markings; they are numbered in the order of discovery.
    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// Bits that the digits of a key take.
    pub(super) fn bits(&self) -> u32 {
        self.packing.fields.iter().map(|field| field.bits).sum()
    }

    pub(super) fn scratch(&self) -> FiringScratch {
        let digits = vec![0; self.encoding.radices.len()];
        let width = self.forth.filter.width.max(self.back.filter.width);
        FiringScratch { digits, set: vec![0; width], enabled: Vec::new(), key: vec![0; self.packing.words] }
    }

    fn key(&self, state: u32) -> &[u64] {
        &self.keys[state as usize * self.packing.words..][..self.packing.words]
    }

    /// The digits of a marking, left in the scratch.
    pub(super) fn digits<'s>(&self, state: u32, scratch: &'s mut FiringScratch) -> &'s [u32] {
        self.packing.unpack(self.key(state), &mut scratch.digits);
        &scratch.digits
    }

    pub(super) fn marking(&self, state: u32) -> Marking {
        let mut digits = vec![0; self.encoding.radices.len()];
        self.packing.unpack(self.key(state), &mut digits);
        self.encoding.marking(&digits)
    }

    /// Fires everything at a marking, in the order of transitions; calls back with (transition, successor, whether it
    /// is new). Returns the number of firings.
    pub(super) fn expand(
        &mut self,
        state: u32,
        scratch: &mut FiringScratch,
        mut found: impl FnMut(u32, u32, bool),
    ) -> Result<usize, ExplorationUndecided> {
        self.packing.unpack(self.key(state), &mut scratch.digits);
        let mut enabled = std::mem::take(&mut scratch.enabled);
        enabled.clear();
        let width = self.forth.filter.width;
        self.forth.enabled(&scratch.digits, &mut scratch.set[..width], |rule| enabled.push(rule as u32));
        for &rule in &enabled {
            let transition = self.forth.rules[rule as usize].transition.0;
            loop {
                match self.fire(state, rule as usize, scratch)? {
                    FiringResult::Known(to) => found(transition, to, false),
                    FiringResult::New(to) => found(transition, to, true),
                    FiringResult::Narrow(digit, bits) => {
                        self.widen(digit, bits)?;
                        scratch.key.resize(self.packing.words, 0);
                        continue;
                    }
                }
                break;
            }
        }
        let fired = enabled.len();
        scratch.enabled = enabled;
        Ok(fired)
    }

    #[inline]
    fn fire(
        &mut self,
        state: u32,
        rule: usize,
        scratch: &mut FiringScratch,
    ) -> Result<FiringResult, ExplorationUndecided> {
        for &(place, gets) in &self.forth.rules[rule].growing {
            let value = self.encoding.forms[place.index()].value(&scratch.digits) + gets;
            let Ok(value) = u32::try_from(value) else {
                let mut marking = self.marking(state);
                let transition = self.forth.rules[rule].transition;
                let error = self.net.fire(&mut marking, transition).expect_err("a count has left 32 bits");
                return Err(ExplorationUndecided {
                    states: self.count as u64,
                    cause: ExplorationLimit::Overflow(error),
                });
            };
            if let Some(digit) = self.encoding.count_of(place.index())
                && u64::from(value) > self.packing.fields[digit].most()
            {
                return Ok(FiringResult::Narrow(digit, u32::BITS - value.leading_zeros()));
            }
        }
        let start = state as usize * self.packing.words;
        scratch.key.copy_from_slice(&self.keys[start..start + self.packing.words]);
        for &(word, add) in &self.forth.deltas[rule] {
            scratch.key[word] = scratch.key[word].wrapping_add(add);
        }
        match self.find(&scratch.key) {
            Ok(state) => Ok(FiringResult::Known(state)),
            Err(_) => self.insert(&scratch.key).map(FiringResult::New),
        }
    }

    /// Calls back with (transition, successor) for all firings at a marking of a set that is complete.
    pub(super) fn successors(&self, state: u32, scratch: &mut FiringScratch, found: impl FnMut(u32, u32)) {
        self.neighbours(&self.forth, state, scratch, found);
    }

    /// Calls back with (transition, predecessor) for all firings that lead to a marking from one in the set.
    pub(super) fn predecessors(&self, state: u32, scratch: &mut FiringScratch, found: impl FnMut(u32, u32)) {
        self.neighbours(&self.back, state, scratch, found);
    }

    fn neighbours(&self, play: &KeyPlay, state: u32, scratch: &mut FiringScratch, mut found: impl FnMut(u32, u32)) {
        let key = self.key(state);
        self.packing.unpack(key, &mut scratch.digits);
        let FiringScratch { digits, set, key: other, .. } = scratch;
        play.enabled(digits, &mut set[..play.filter.width], |rule| {
            // What is too large for its field is not in the set.
            let fits = play.rules[rule].change.iter().all(|&(digit, by)| {
                u64::try_from(i64::from(digits[digit]) + by).is_ok_and(|v| v <= self.packing.fields[digit].most())
            });
            if !fits {
                return;
            }
            other.copy_from_slice(key);
            for &(word, add) in &play.deltas[rule] {
                other[word] = other[word].wrapping_add(add);
            }
            if let Ok(state) = self.find(other) {
                found(play.rules[rule].transition.0, state);
            }
        });
    }

    /// Where a key is, or the slot where it would be.
    #[inline]
    fn find(&self, key: &[u64]) -> Result<u32, usize> {
        let hash = hash(key);
        let mask = self.slots.len() - 1;
        let mut slot = hash as usize & mask;
        loop {
            let content = self.slots[slot];
            if content == 0 {
                return Err(slot);
            }
            // The upper half of the hash, then the number plus one.
            if content >> 32 == hash >> 32 && self.key(content as u32 - 1) == key {
                return Ok(content as u32 - 1);
            }
            slot = (slot + 1) & mask;
        }
    }

    fn insert(&mut self, key: &[u64]) -> Result<u32, ExplorationUndecided> {
        let states = self.count as u64;
        if states >= self.limit_states {
            return Err(ExplorationUndecided { states, cause: ExplorationLimit::States { limit: self.limit_states } });
        }
        if (self.count + 1) * 4 > self.slots.len() * 3 {
            self.grow_index()?;
        }
        if self.keys.len() + self.packing.words > self.keys.capacity() {
            self.grow_keys()?;
        }
        let state = self.count as u32;
        self.keys.extend_from_slice(key);
        self.count += 1;
        self.put(key, state);
        Ok(state)
    }

    /// Enters a key that is not there yet.
    fn put(&mut self, key: &[u64], state: u32) {
        if let Err(slot) = self.find(key) {
            self.slots[slot] = (hash(key) >> 32) << 32 | u64::from(state + 1);
        }
    }

    fn grow_keys(&mut self) -> Result<(), ExplorationUndecided> {
        let old = self.keys.capacity();
        let more = (self.keys.len() / 2).max(SLOTS_MIN * self.packing.words);
        // While they move there are two of them.
        self.budget.take((self.keys.len() + more) * size_of::<u64>(), self.count as u64)?;
        self.keys.reserve_exact(more);
        self.budget.give_back(old * size_of::<u64>());
        Ok(())
    }

    fn grow_index(&mut self) -> Result<(), ExplorationUndecided> {
        let old = self.slots.len();
        let size = (old * 2).max(SLOTS_MIN);
        self.budget.take(size * size_of::<u64>(), self.count as u64)?;
        let entries = std::mem::replace(&mut self.slots, vec![0; size]);
        for state in 0..self.count as u32 {
            let hash = hash(self.key(state));
            let mut slot = hash as usize & (size - 1);
            while self.slots[slot] != 0 {
                slot = (slot + 1) & (size - 1);
            }
            self.slots[slot] = (hash >> 32) << 32 | u64::from(state + 1);
        }
        drop(entries);
        self.budget.give_back(old * size_of::<u64>());
        Ok(())
    }

    /// Writes all keys anew with a digit of at least so many bits.
    fn widen(&mut self, digit: usize, bits: u32) -> Result<(), ExplorationUndecided> {
        let mut widths: Vec<u32> = self.packing.fields.iter().map(|field| field.bits).collect();
        widths[digit] = bits.max(widths[digit] * 2).min(u32::BITS);
        let packing = Packing::new(&widths);
        let room = self.keys.capacity() / self.packing.words * packing.words;
        self.budget.take(room * size_of::<u64>(), self.count as u64)?;
        let mut keys = Vec::with_capacity(room);
        let mut digits = vec![0; widths.len()];
        let mut key = vec![0; packing.words];
        for state in 0..self.count as u32 {
            self.packing.unpack(self.key(state), &mut digits);
            packing.pack(&digits, &mut key);
            keys.extend_from_slice(&key);
        }
        self.budget.give_back(self.keys.capacity() * size_of::<u64>());
        self.keys = keys;
        self.packing = packing;
        self.forth = KeyPlay::new(self.net, self.encoding, &self.packing, PlayDirection::Fire);
        self.back = KeyPlay::new(self.net, self.encoding, &self.packing, PlayDirection::FireBack);
        self.slots.fill(0);
        for state in 0..self.count as u32 {
            let key = self.key(state).to_vec();
            self.put(&key, state);
        }
        Ok(())
    }
}

/// Spreads a key over 64 bits. Equal hashes are no more than a hint.
#[inline]
fn hash(key: &[u64]) -> u64 {
    const ODD: u64 = 0x9e37_79b9_7f4a_7c15;
    let mut hash = 0_u64;
    for &word in key {
        hash = (hash ^ word).wrapping_mul(ODD);
        hash ^= hash >> 32;
    }
    hash.wrapping_mul(ODD).rotate_left(32)
}
