//! Distributions of times, by the names of the literature (Law, *Simulation Modeling and Analysis*, chapter 6).
//!
//! Sampled by inversion: one number of a stream makes one value, and a larger number a larger value. So two variants of a
//! cell that draw from equal streams meet the same chance (common random numbers), which libraries that reject and draw
//! again do not keep up. The quantiles that have no closed form are those of `distrs`.

use std::time::Duration;

use distrs::Normal;

use crate::rng::Rng;

/// The longest time that is drawn, in seconds: some thirty years. Beyond that nothing is simulated.
pub(super) const LONGEST_S: f64 = 1e9;

/// A distribution of numbers that are not below zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distribution {
    /// Always the same.
    Constant(f64),
    Exponential {
        mean: f64,
    },
    Uniform {
        low: f64,
        high: f64,
    },
    Triangular {
        low: f64,
        mode: f64,
        high: f64,
    },
    /// The normal distribution without what is below zero. Mean and standard deviation are those before it is cut.
    TruncatedNormal {
        mean: f64,
        deviation: f64,
    },
    /// Mean and standard deviation are its own, not those of the logarithm.
    Lognormal {
        mean: f64,
        deviation: f64,
    },
    Weibull {
        shape: f64,
        scale: f64,
    },
}

impl Distribution {
    /// The value that is not exceeded with probability `p`, above 0 and below 1.
    pub fn quantile(&self, p: f64) -> f64 {
        let value = match *self {
            Distribution::Constant(value) => value,
            Distribution::Exponential { mean } => -mean * (-p).ln_1p(),
            Distribution::Uniform { low, high } => low + p * (high - low),
            Distribution::Triangular { low, mode, high } => {
                let (width, rise) = (high - low, mode - low);
                if p * width < rise {
                    low + (p * width * rise).sqrt()
                } else {
                    high - ((1.0 - p) * width * (high - mode)).sqrt()
                }
            }
            Distribution::TruncatedNormal { mean, deviation } => {
                let below = Normal::cdf(0.0, mean, deviation);
                Normal::ppf(below + p * (1.0 - below), mean, deviation)
            }
            Distribution::Lognormal { mean, deviation } => {
                let variance = (deviation / mean).powi(2).ln_1p();
                Normal::ppf(p, mean.ln() - variance / 2.0, variance.sqrt()).exp()
            }
            Distribution::Weibull { shape, scale } => scale * (-(-p).ln_1p()).powf(1.0 / shape),
        };
        if value.is_finite() { value.max(0.0) } else { LONGEST_S }
    }

    /// The next value of a stream.
    pub fn draw(&self, rng: &mut Rng) -> f64 {
        self.quantile(rng.unit())
    }

    /// The next time of a stream, of a distribution of seconds; to the microsecond, and not so long that time ends.
    pub fn draw_seconds(&self, rng: &mut Rng) -> Duration {
        let micros = (self.draw(rng).min(LONGEST_S) * 1e6).round();
        Duration::from_micros(micros as u64)
    }
}
