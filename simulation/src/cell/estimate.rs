//! Estimate of a figure from several replications: its mean, and a confidence interval.
//!
//! Replications are independent of each other, so the interval is the usual one of Student's t with n − 1 degrees of freedom
//! (Law, *Simulation Modeling and Analysis*, §4.5 and §9.4). One replication gives no interval.

use distrs::StudentsT;

/// A figure over several replications.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    pub mean: f64,
    /// Half width of the confidence interval around `mean`; none of one replication.
    pub half_width: Option<f64>,
    /// Number of replications.
    pub n: usize,
}

impl Estimate {
    /// Of one value of each replication, with a confidence between 0 and 1; none of no value.
    pub fn of(values: impl Iterator<Item = f64> + Clone, confidence: f64) -> Option<Self> {
        let n = values.clone().count();
        if n == 0 {
            return None;
        }
        let mean = values.clone().sum::<f64>() / n as f64;
        let half_width = (n > 1).then(|| {
            let freedom = (n - 1) as f64;
            let variance = values.map(|value| (value - mean).powi(2)).sum::<f64>() / freedom;
            StudentsT::ppf(f64::midpoint(1.0, confidence), freedom) * (variance / n as f64).sqrt()
        });
        Some(Estimate { mean, half_width, n })
    }

    /// Whether the interval is at most this part of the mean to either side. What is counted is the relative error of the
    /// true mean, so the part is taken of the smaller end (Law, §9.4.1).
    pub fn is_within(&self, precision: f64) -> bool {
        let allowed = self.mean.abs() * precision / (1.0 + precision);
        self.half_width.is_some_and(|half_width| half_width <= allowed)
    }

    /// Whether a value is in the interval.
    pub fn has(&self, value: f64) -> bool {
        self.half_width.is_some_and(|half_width| (value - self.mean).abs() <= half_width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        for (freedom, known) in [(1.0, 12.706), (2.0, 4.303), (4.0, 2.776), (9.0, 2.262), (29.0, 2.045), (99.0, 1.984)]
        {
            let found: f64 = StudentsT::ppf(0.975, freedom);
            assert!((found - known).abs() < 1e-3, "{freedom} {found}");
        }
    }

    #[test]
    fn one_replication_gives_no_interval_and_none_gives_nothing() {
        assert_eq!(Estimate::of([3.0].into_iter(), 0.95), Some(Estimate { mean: 3.0, half_width: None, n: 1 }));
        assert_eq!(Estimate::of(std::iter::empty(), 0.95), None);
        let same = Estimate::of([3.0; 4].into_iter(), 0.95).expect("there are values");
        assert_eq!(same.half_width, Some(0.0));
    }
}
