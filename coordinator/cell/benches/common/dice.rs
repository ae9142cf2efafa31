//! Random numbers that are the same for the same seed, whatever library is there: measured cells are made of them.

/// A linear congruence.
pub struct Dice(pub u64);

impl Dice {
    /// One of so many numbers, from 0.
    pub fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % bound
    }
}
