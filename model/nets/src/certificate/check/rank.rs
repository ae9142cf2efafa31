//! The rank of a matrix modulo a prime: never more than its rank.
//!
//! A minor that is not zero modulo a prime is not zero. So independence modulo the prime is independence, and that is
//! the only direction in which the checker uses it.

use std::collections::BTreeMap;

/// The Mersenne prime 2⁶¹ − 1.
const PRIME: u64 = (1 << 61) - 1;

fn times(a: u64, b: u64) -> u64 {
    (u128::from(a) * u128::from(b) % u128::from(PRIME)) as u64
}

/// By Fermat's little theorem.
fn inverse(a: u64) -> u64 {
    let (mut result, mut base, mut exponent) = (1, a, PRIME - 2);
    while exponent > 0 {
        if exponent & 1 == 1 {
            result = times(result, base);
        }
        base = times(base, base);
        exponent >>= 1;
    }
    result
}

/// The rank modulo the prime of a matrix given by rows, each with column and entry.
pub(super) fn rank(rows: impl Iterator<Item = Vec<(u32, i64)>>) -> usize {
    // Per column, a row that begins there with 1.
    let mut pivots: BTreeMap<u32, Vec<(u32, u64)>> = BTreeMap::new();
    for row in rows {
        let mut row: BTreeMap<u32, u64> = row
            .into_iter()
            .map(|(column, value)| (column, i128::from(value).rem_euclid(PRIME.into()) as u64))
            .collect();
        loop {
            row.retain(|_, value| *value != 0);
            let Some((&first, &value)) = row.first_key_value() else { break };
            let Some(pivot) = pivots.get(&first) else {
                let factor = inverse(value);
                pivots.insert(first, row.into_iter().map(|(column, value)| (column, times(value, factor))).collect());
                break;
            };
            for &(column, entry) in pivot {
                let cell = row.entry(column).or_insert(0);
                *cell = (*cell + PRIME - times(value, entry)) % PRIME;
            }
        }
    }
    pivots.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_and_sums_add_no_rank() {
        let rows = [vec![(0, 1), (1, -2)], vec![(0, -3), (1, 6)], vec![(1, 5), (7, 1)], vec![(0, 1), (1, 3), (7, 1)]];
        assert_eq!(rank(rows.into_iter()), 2);
        assert_eq!(times(inverse(12345), 12345), 1);
        assert_eq!(rank([vec![], vec![(3, i64::MIN)]].into_iter()), 1);
    }
}
