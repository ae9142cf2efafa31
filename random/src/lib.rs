//! Numbers that look random and follow from a seed: the same on every machine and in every release.
//!
//! For generated or random values, in products and in tests; nothing here is hard to guess.

use std::ops::RangeInclusive;

/// xorshift64* (Vigna, 2016): repeatable, small, and good enough to make things up.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// From a seed; neighbouring seeds do not begin alike.
    pub fn new(seed: u64) -> Self {
        Random(seed.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    #[allow(clippy::should_implement_trait)]
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    /// A number below `bound`; 0 if that is 0.
    pub fn below(&mut self, bound: usize) -> usize {
        // The upper bits are the better ones.
        ((self.next() >> 33) % (bound as u64).max(1)) as usize
    }

    /// A number within bounds, both among them.
    pub fn within(&mut self, bounds: &RangeInclusive<usize>) -> usize {
        bounds.start() + self.below(bounds.end().saturating_sub(*bounds.start()) + 1)
    }

    /// True so many times in a hundred.
    pub fn chance(&mut self, percent: u32) -> bool {
        self.below(100) < percent as usize
    }

    /// True once in so many cases.
    pub fn one_in(&mut self, cases: usize) -> bool {
        self.below(cases) == 0
    }

    /// One of several.
    ///
    /// # Panics
    /// When there are none.
    pub fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.below(from.len())]
    }
}

/// The number of SplitMix64 (Steele and others, 2014) that follows from another one alone.
pub const fn mix(number: u64) -> u64 {
    stir(number.wrapping_add(0x9E37_79B9_7F4A_7C15))
}

/// The finaliser of SplitMix64: every bit of the number stirs every bit of the result. Nothing comes of 0.
pub const fn stir(number: u64) -> u64 {
    let number = (number ^ (number >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let number = (number ^ (number >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    number ^ (number >> 31)
}
