//! Random delays and operators that follow from a seed, the same on every machine.

use linewright_random::mix;

/// SplitMix64: small, fast, and good enough to choose delays and fingers.
#[derive(Clone, Debug)]
pub struct Rng(u64);

impl Rng {
    /// Numbers that follow from `seed`.
    pub fn new(seed: u64) -> Self {
        // Neighbouring seeds must not give neighbouring first numbers.
        let mut rng = Rng(seed ^ 0x5851_F42D_4C95_7F2D);
        rng.next();
        rng
    }

    /// The stream of `seed` with this name. Streams of other names, and how much is drawn from them, change nothing in it.
    pub fn named(seed: u64, name: &str) -> Self {
        // FNV-1a (Fowler, Noll, Vo), then stirred: names that differ in one letter have nothing in common.
        let hash = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3);
        Rng::new(mix(seed) ^ mix(name.bytes().fold(0xCBF2_9CE4_8422_2325, hash)))
    }

    /// A number above 0 and below 1, of 2^53 that are equally likely.
    pub fn unit(&mut self) -> f64 {
        ((self.next() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    #[allow(clippy::should_implement_trait)]
    pub fn next(&mut self) -> u64 {
        let drawn = mix(self.0);
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        drawn
    }

    /// A number below `bound`, which is above zero.
    pub fn below(&mut self, bound: u64) -> u64 {
        self.next() % bound
    }

    /// A number in `low..=high`.
    pub fn within(&mut self, low: u64, high: u64) -> u64 {
        low + self.below(high - low + 1)
    }

    /// True in `per_mille` of a thousand cases.
    pub fn chance(&mut self, per_mille: u64) -> bool {
        self.below(1000) < per_mille
    }

    /// One of them.
    pub fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.below(of.len() as u64) as usize]
    }
}
