//! Numbers by chance, repeatably: the same seed gives the same numbers on every machine and in every release.

use std::ops::RangeInclusive;

/// xorshift64*: repeatable, small, and good enough to make things up.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// From a seed; neighbouring seeds do not begin alike.
    pub fn new(seed: u64) -> Self {
        Random(seed.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// A number below `bound`; 0 if that is 0.
    pub fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let bits = self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33;
        (bits % (bound as u64).max(1)) as usize
    }

    /// A number within bounds, both among them.
    pub fn within(&mut self, bounds: &RangeInclusive<usize>) -> usize {
        bounds.start() + self.below(bounds.end().saturating_sub(*bounds.start()) + 1)
    }

    /// True so many times in a hundred.
    pub fn chance(&mut self, percent: u32) -> bool {
        self.below(100) < percent as usize
    }

    /// One of several.
    ///
    /// # Panics
    /// When there are none.
    pub fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.below(from.len())]
    }
}
