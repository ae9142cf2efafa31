//! Spread of a set of times.

use std::time::Duration;

/// Least, most, and percentiles (nearest rank: always one of the times themselves).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spread {
    /// Number of values.
    pub count: usize,
    pub least: Duration,
    /// Half of them do not exceed it.
    pub median: Duration,
    /// Nine in ten do not.
    pub p90: Duration,
    /// 99 in a hundred do not.
    pub p99: Duration,
    pub most: Duration,
    /// Their sum.
    pub total: Duration,
}

impl Spread {
    /// Of these times, in any order; all zero if there are none.
    pub fn of(mut times: Vec<Duration>) -> Self {
        times.sort_unstable();
        let rank = |percent: usize| times[(times.len() * percent).div_ceil(100).max(1) - 1];
        match (times.first(), times.last()) {
            (Some(&least), Some(&most)) => Spread {
                count: times.len(),
                least,
                median: rank(50),
                p90: rank(90),
                p99: rank(99),
                most,
                total: times.iter().sum(),
            },
            _ => Spread::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The usual example of the nearest-rank method: of 15, 20, 35, 40, 50 the 5th, 30th, 40th, 50th and 100th percentile
    /// are 15, 20, 20, 35 and 50.
    #[test]
    fn percentiles_are_the_nearest_rank() {
        let seconds = |all: &[u64]| all.iter().map(|&s| Duration::from_secs(s)).collect::<Vec<_>>();
        let spread = Spread::of(seconds(&[40, 15, 50, 20, 35]));
        assert_eq!(
            (spread.least, spread.median, spread.most),
            (seconds(&[15])[0], seconds(&[35])[0], seconds(&[50])[0])
        );
        assert_eq!((spread.p90, spread.p99, spread.total), (seconds(&[50])[0], seconds(&[50])[0], seconds(&[160])[0]));
        let hundred: Vec<u64> = (1..=100).rev().collect();
        let spread = Spread::of(seconds(&hundred));
        let [median, p90, p99] = [spread.median, spread.p90, spread.p99].map(|time| time.as_secs());
        assert_eq!((median, p90, p99, spread.count), (50, 90, 99, 100));
        assert_eq!(Spread::of(Vec::new()), Spread::default());
        let one = Spread::of(seconds(&[7]));
        assert_eq!((one.least, one.median, one.p99), (one.most, one.most, one.most));
    }
}
