//! Integer vectors with few entries, and the one operation that elimination needs of them.

/// The non-zero entries by index, ascending.
pub(super) type SparseEntries = Vec<(u32, i64)>;

pub(super) fn entry(row: &[(u32, i64)], index: u32) -> i64 {
    row.binary_search_by_key(&index, |&(at, _)| at).map_or(0, |at| row[at].1)
}

/// `factor_a`·a + `factor_b`·b, unless an entry cannot be counted.
pub(super) fn combine(a: &[(u32, i64)], factor_a: i64, b: &[(u32, i64)], factor_b: i64) -> Option<SparseEntries> {
    let mut sum = Vec::with_capacity(a.len() + b.len());
    let (mut i, mut j) = (0, 0);
    while i < a.len() || j < b.len() {
        let at = match (a.get(i), b.get(j)) {
            (Some(x), Some(y)) => x.0.min(y.0),
            (Some(x), None) => x.0,
            (None, Some(y)) => y.0,
            (None, None) => break,
        };
        let mut value = 0_i64;
        if a.get(i).is_some_and(|x| x.0 == at) {
            value = a[i].1.checked_mul(factor_a)?;
            i += 1;
        }
        if b.get(j).is_some_and(|y| y.0 == at) {
            value = value.checked_add(b[j].1.checked_mul(factor_b)?)?;
            j += 1;
        }
        // Without a negation it is as good as not counted.
        if value == i64::MIN {
            return None;
        }
        if value != 0 {
            sum.push((at, value));
        }
    }
    Some(sum)
}

/// The greatest common divisor of all entries; 0 if there are none.
pub(super) fn content(row: &[(u32, i64)]) -> u64 {
    row.iter().fold(0, |divisor, &(_, value)| gcd(divisor, value.unsigned_abs()))
}

/// The greatest common divisor.
pub(super) fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}
