//! All states met so far, numbered in the order they were met, each in as many bits as hold it.
//!
//! An open-addressing table of numbers finds a state again; the states themselves lie in one vector, which is also the
//! queue of a breadth-first search. Each slot holds a piece of the hash beside the number, so that comparing states,
//! which is exact, is almost only done with the equal one.

/// A packed state.
pub(crate) type StateKey<const N: usize> = [u64; N];

/// States, numbered from 0.
#[derive(Debug)]
pub(crate) struct StateTable<const N: usize> {
    keys: Vec<StateKey<N>>,
    /// A piece of the hash above, the number plus one below; 0 is free. A power of two of them.
    slots: Vec<u64>,
}

const NUMBER: u64 = u32::MAX as u64;

/// With so many states a table is full. Numbers have 32 bits; what is still to be entered then has room.
const STATES_MAX: usize = 1 << 31;

impl<const N: usize> StateTable<N> {
    pub fn new() -> Self {
        StateTable { keys: Vec::new(), slots: vec![0; 1 << 16] }
    }

    pub fn len(&self) -> usize {
        self.keys.len()
    }

    /// Whether no more may be entered.
    pub fn is_full(&self) -> bool {
        self.len() > STATES_MAX
    }

    pub fn key(&self, number: u32) -> &StateKey<N> {
        &self.keys[number as usize]
    }

    /// Enters many at once: appends for each its number to `numbers`. New ones get the next numbers, in order.
    ///
    /// Looking a state up costs two accesses to memory that no cache holds. All are begun before the first is waited
    /// for; one after the other they would take several times as long.
    pub fn enter_all(&mut self, keys: &[StateKey<N>], scratch: &mut Vec<(u64, u64)>, numbers: &mut Vec<u32>) {
        while (self.keys.len() + keys.len()) * 3 >= self.slots.len() * 2 {
            self.grow();
        }
        scratch.clear();
        scratch.extend(keys.iter().map(|key| {
            let hash = hash(key);
            (hash, self.slots[self.home_of(hash)])
        }));
        for (key, &(hash, slot)) in keys.iter().zip(scratch.iter()) {
            let known = slot != 0 && self.holds(slot, hash, key);
            numbers.push(if known { number_in(slot) } else { self.enter_hashed(key, hash) });
        }
    }

    fn enter_hashed(&mut self, key: &StateKey<N>, hash: u64) -> u32 {
        let mut at = self.home_of(hash);
        loop {
            let slot = self.slots[at];
            if slot == 0 {
                let number = self.keys.len() as u32;
                self.keys.push(*key);
                self.slots[at] = entry(hash, number);
                return number;
            }
            if self.holds(slot, hash, key) {
                return number_in(slot);
            }
            at = (at + 1) & (self.slots.len() - 1);
        }
    }

    fn holds(&self, slot: u64, hash: u64, key: &StateKey<N>) -> bool {
        slot & !NUMBER == hash & !NUMBER && self.keys[number_in(slot) as usize] == *key
    }

    fn home_of(&self, hash: u64) -> usize {
        // The lower half of the hash; the upper one is compared.
        hash as usize & (self.slots.len() - 1)
    }

    fn grow(&mut self) {
        let mut slots = vec![0; self.slots.len() * 2];
        let mask = slots.len() - 1;
        for (number, key) in self.keys.iter().enumerate() {
            let hash = hash(key);
            let mut at = hash as usize & mask;
            while slots[at] != 0 {
                at = (at + 1) & mask;
            }
            slots[at] = entry(hash, number as u32);
        }
        self.slots = slots;
    }

    pub fn bytes(&self) -> usize {
        self.keys.capacity() * size_of::<StateKey<N>>() + self.slots.len() * size_of::<u64>()
    }
}

fn entry(hash: u64, number: u32) -> u64 {
    hash & !NUMBER | (u64::from(number) + 1)
}

fn number_in(slot: u64) -> u32 {
    ((slot & NUMBER) - 1) as u32
}

fn hash<const N: usize>(key: &StateKey<N>) -> u64 {
    let mut hash = 0x9E37_79B9_7F4A_7C15_u64;
    for &word in key {
        let product = u128::from(hash ^ word) * 0xD6E8_FEB8_6659_FD93_u128;
        hash = (product >> 64) as u64 ^ product as u64;
    }
    hash
}
