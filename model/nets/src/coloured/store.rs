//! Many markings, each once, in one block of memory.
//!
//! Two markings are the same if their entries are, compared one by one; the hash only says where to look. A marking
//! costs eight bytes per cell that has tokens, and some thirty of bookkeeping.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

const NONE: u32 = u32::MAX;

/// A set of markings, numbered in the order in which they came.
#[derive(Clone, Debug)]
pub(super) struct MarkingStore {
    entries: Vec<(u32, u32)>,
    /// Where each marking ends in `entries`.
    ends: Vec<usize>,
    /// The last marking that came with a hash; the ones before it follow in `previous`.
    last_with: HashMap<u64, u32>,
    previous: Vec<u32>,
}

/// What a marking costs beside its entries: an end, a link, and its share of a table that is at most half empty.
const OVERHEAD: usize = size_of::<usize>() + size_of::<u32>() + 2 * size_of::<(u64, u32)>();

impl MarkingStore {
    pub(super) fn new() -> MarkingStore {
        MarkingStore { entries: Vec::new(), ends: Vec::new(), last_with: HashMap::new(), previous: Vec::new() }
    }

    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    pub(super) fn get(&self, number: u32) -> &[(u32, u32)] {
        let number = number as usize;
        let start = if number == 0 { 0 } else { self.ends[number - 1] };
        &self.entries[start..self.ends[number]]
    }

    /// The memory in use, about.
    pub(super) fn bytes(&self) -> usize {
        self.entries.len() * size_of::<(u32, u32)>() + self.len() * OVERHEAD
    }

    pub(super) fn find(&self, marking: &[(u32, u32)]) -> Option<u32> {
        let mut at = self.last_with.get(&hash(marking)).copied().unwrap_or(NONE);
        while at != NONE && self.get(at) != marking {
            at = self.previous[at as usize];
        }
        (at != NONE).then_some(at)
    }

    /// Adds a marking that is not there yet. The caller keeps the number of markings below 32 bits.
    pub(super) fn add(&mut self, marking: &[(u32, u32)]) -> u32 {
        let number = self.len() as u32;
        self.entries.extend_from_slice(marking);
        self.ends.push(self.entries.len());
        self.previous.push(self.last_with.insert(hash(marking), number).unwrap_or(NONE));
        number
    }
}

fn hash(marking: &[(u32, u32)]) -> u64 {
    let mut hasher = DefaultHasher::new();
    marking.hash(&mut hasher);
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markings_are_found_again_and_the_empty_one_is_one() {
        let mut store = MarkingStore::new();
        let markings: [&[(u32, u32)]; 4] = [&[], &[(0, 1)], &[(0, 2)], &[(0, 1), (3, 1)]];
        for (marking, number) in markings.iter().zip(0..) {
            assert_eq!(store.find(marking), None);
            assert_eq!(store.add(marking), number);
        }
        for (marking, number) in markings.iter().zip(0..) {
            assert_eq!((store.find(marking), store.get(number)), (Some(number), *marking));
        }
        assert_eq!(store.find(&[(3, 1)]), None);
    }

    #[test]
    fn equal_hashes_are_told_apart() {
        let mut store = MarkingStore::new();
        let (one, two) = ([(1, 1)], [(2, 1)]);
        store.add(&one);
        // As if both had the hash of the second.
        store.last_with.insert(hash(&two), 0);
        assert_eq!(store.find(&two), None);
        store.add(&two);
        assert_eq!((store.find(&two), store.previous[1]), (Some(1), 0));
    }
}
