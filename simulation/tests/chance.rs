//! Distributions, estimates and streams of chance against the literature.

use linewright_simulation::Rng;
use linewright_simulation::cell::{Distribution, Estimate};

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
        assert!((found.0 / mean - 1.0).abs() < 1e-3 && (found.1 / deviation - 1.0).abs() < 2e-3, "{of:?} {found:?}");
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

/// Ten observations 1.20, 1.50, 1.68, 1.89, 0.95, 1.49, 1.58, 1.55, 0.50, 1.09 give 1.34 ± 0.24 at 90 % (Law, example
/// 4.26).
#[test]
fn an_interval_is_that_of_the_textbook() {
    let values = [1.20, 1.50, 1.68, 1.89, 0.95, 1.49, 1.58, 1.55, 0.50, 1.09];
    let found = Estimate::of(values.into_iter(), 0.9).expect("there are values");
    assert!((found.mean - 1.343).abs() < 1e-9 && found.n == 10, "{found:?}");
    assert!(found.half_width.is_some_and(|half| (half - 0.24).abs() < 5e-3), "{found:?}");
    assert!(found.is_within(0.3) && !found.is_within(0.2));
    assert!(found.has(1.5) && !found.has(1.6));
}

/// Quantiles of Student's t as in printed tables.
#[test]
fn quantiles_of_t_are_those_of_the_table() {
    for (freedom, known) in [(1, 12.706), (2, 4.303), (4, 2.776), (9, 2.262), (29, 2.045), (99, 1.984)] {
        let values = (0..=freedom).map(f64::from);
        let found = Estimate::of(values, 0.95).and_then(|estimate| estimate.half_width).expect("there are several");
        // Of n numbers in a row the variance is n (n + 1) / 12, and that of their mean an n-th of it.
        let quantile = found / (f64::from(freedom + 2) / 12.0).sqrt();
        assert!((quantile - known).abs() < 1e-3, "{freedom} {quantile}");
    }
}

#[test]
fn one_replication_gives_no_interval_and_none_gives_nothing() {
    assert_eq!(Estimate::of([3.0].into_iter(), 0.95), Some(Estimate { mean: 3.0, half_width: None, n: 1 }));
    assert_eq!(Estimate::of(std::iter::empty(), 0.95), None);
    let same = Estimate::of([3.0; 4].into_iter(), 0.95).expect("there are values");
    assert_eq!(same.half_width, Some(0.0));
}
