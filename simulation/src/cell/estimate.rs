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
