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
