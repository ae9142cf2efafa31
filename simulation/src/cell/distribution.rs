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

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean and standard deviation of many quantiles, evenly spaced: an integral, without chance.
    fn moments(of: Distribution) -> (f64, f64) {
        let count = 1_000_000;
        let (sum, squares) = (0..count).fold((0.0, 0.0), |(sum, squares), at| {
            let value = of.quantile((f64::from(at) + 0.5) / f64::from(count));
            (sum + value, squares + value * value)
        });
        let mean = sum / f64::from(count);
        (mean, (squares / f64::from(count) - mean * mean).sqrt())
    }

    /// Each with the mean and the standard deviation that textbooks give.
    #[test]
    fn distributions_have_the_moments_of_the_literature() {
        let gamma_1_5 = std::f64::consts::PI.sqrt() / 2.0;
        let known = [
            (Distribution::Exponential { mean: 7.0 }, 7.0, 7.0),
            (Distribution::Uniform { low: 2.0, high: 8.0 }, 5.0, 3.0_f64.sqrt()),
            (Distribution::Triangular { low: 1.0, mode: 2.0, high: 6.0 }, 3.0, (14.0_f64 / 12.0).sqrt()),
            (Distribution::TruncatedNormal { mean: 10.0, deviation: 1.0 }, 10.0, 1.0),
            // Cut in the middle it is the half-normal distribution.
            (
                Distribution::TruncatedNormal { mean: 1e-9, deviation: 1.0 },
                (2.0 / std::f64::consts::PI).sqrt(),
                (1.0 - 2.0 / std::f64::consts::PI).sqrt(),
            ),
            (Distribution::Lognormal { mean: 600.0, deviation: 300.0 }, 600.0, 300.0),
            // Rayleigh.
            (Distribution::Weibull { shape: 2.0, scale: 4.0 }, 4.0 * gamma_1_5, 4.0 * (1.0 - gamma_1_5.powi(2)).sqrt()),
            (Distribution::Weibull { shape: 1.0, scale: 3.0 }, 3.0, 3.0),
        ];
        for (of, mean, deviation) in known {
            let found = moments(of);
            assert!(
                (found.0 / mean - 1.0).abs() < 1e-3 && (found.1 / deviation - 1.0).abs() < 2e-3,
                "{of:?} {found:?}"
            );
        }
        assert_eq!(moments(Distribution::Constant(5.0)).0, 5.0);
    }

    #[test]
    fn a_larger_number_makes_a_larger_value_and_none_is_below_zero() {
        let all = [
            Distribution::Exponential { mean: 7.0 },
            Distribution::Uniform { low: 0.0, high: 8.0 },
            Distribution::Triangular { low: 1.0, mode: 1.0, high: 6.0 },
            Distribution::Triangular { low: 1.0, mode: 6.0, high: 6.0 },
            Distribution::TruncatedNormal { mean: 1.0, deviation: 1e6 },
            Distribution::Lognormal { mean: 1e-3, deviation: 1e3 },
            Distribution::Weibull { shape: 0.1, scale: 4.0 },
        ];
        for of in all {
            let values: Vec<f64> = (0..2000).map(|at| of.quantile((f64::from(at) + 0.5) / 2000.0)).collect();
            assert!(values[0] >= 0.0 && values.windows(2).all(|pair| pair[0] <= pair[1]), "{of:?}");
            let extreme = [of.quantile(f64::EPSILON / 4.0), of.quantile(1.0 - f64::EPSILON / 2.0)];
            assert!(extreme.iter().all(|value| value.is_finite() && *value >= 0.0), "{of:?} {extreme:?}");
        }
    }

    #[test]
    fn streams_of_other_names_have_nothing_in_common() {
        let first = |seed, name| Rng::named(seed, name).next();
        assert_eq!(first(1, "breakdown/M1"), first(1, "breakdown/M1"));
        let all = [first(1, "breakdown/M1"), first(1, "breakdown/M2"), first(2, "breakdown/M1"), first(1, "")];
        assert!((0..4).all(|at| !all[..at].contains(&all[at])), "{all:?}");
        // Of two streams that begin at neighbouring names, the numbers do not follow each other (correlation).
        let (mut one, mut other) = (Rng::named(1, "M1"), Rng::named(1, "M2"));
        let products: f64 = (0..10_000).map(|_| (one.unit() - 0.5) * (other.unit() - 0.5)).sum();
        assert!((products / 10_000.0 * 12.0).abs() < 0.04, "{products}");
    }
}
