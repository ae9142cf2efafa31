//! Sparse rows of integers, with their combination.
//!
//! A row starts as one line of a matrix together with a unit vector. Every combination is applied to both parts, so that
//! at any time `rest = own · matrix`. Once `rest` is empty, `own` is a solution of own · matrix = 0. Numbers are kept in
//! 64 bits and combined in 128; what does not fit afterwards is reported, never cut off.

/// Entries that are not zero, ordered by index.
pub(super) type SparseVector = Vec<(u32, i64)>;

/// A row under elimination.
#[derive(Clone, Debug)]
pub(super) struct EliminationRow {
    /// Rest of the matrix part.
    pub rest: SparseVector,
    /// The combination of the original rows that this one is.
    pub own: SparseVector,
}

impl EliminationRow {
    /// Row number `index` of the matrix.
    pub fn unit(index: usize, rest: &[(u32, i64)]) -> EliminationRow {
        EliminationRow { rest: rest.to_vec(), own: vec![(index as u32, 1)] }
    }

    /// The entry in a column.
    pub fn at(&self, column: u32) -> i64 {
        self.rest.binary_search_by_key(&column, |&(column, _)| column).map_or(0, |at| self.rest[at].1)
    }

    /// `x`·`a` + `y`·`b`, divided by the greatest common divisor of the combination; none if a number outgrows 64 bits.
    pub fn combine(x: i64, a: &EliminationRow, y: i64, b: &EliminationRow) -> Option<EliminationRow> {
        let own = sum(x, &a.own, y, &b.own)?;
        let rest = sum(x, &a.rest, y, &b.rest)?;
        // `rest` is linear in `own`, so what divides `own` divides `rest`.
        let divisor = own.iter().fold(0_u128, |divisor, &(_, value)| gcd(divisor, value.unsigned_abs())).max(1);
        let divisor = i128::try_from(divisor).ok()?;
        Some(EliminationRow { rest: narrow(rest, divisor)?, own: narrow(own, divisor)? })
    }

    /// Roughly the memory the row takes.
    pub fn bytes(&self) -> usize {
        size_of::<EliminationRow>() + (self.rest.len() + self.own.len()) * size_of::<(u32, i64)>()
    }
}

/// The greatest common divisor; that of zero and n is n.
pub(super) fn gcd(mut a: u128, mut b: u128) -> u128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

fn sum(x: i64, a: &[(u32, i64)], y: i64, b: &[(u32, i64)]) -> Option<Vec<(u32, i128)>> {
    let product = |factor: i64, value: i64| i128::from(factor) * i128::from(value);
    let mut found = Vec::with_capacity(a.len() + b.len());
    let (mut i, mut j) = (0, 0);
    while i < a.len() || j < b.len() {
        let left = a.get(i).map_or(u32::MAX, |entry| entry.0);
        let right = b.get(j).map_or(u32::MAX, |entry| entry.0);
        let at = left.min(right);
        let mut value = 0_i128;
        if left == at {
            value = product(x, a[i].1);
            i += 1;
        }
        if right == at {
            value = value.checked_add(product(y, b[j].1))?;
            j += 1;
        }
        if value != 0 {
            found.push((at, value));
        }
    }
    Some(found)
}

fn narrow(values: Vec<(u32, i128)>, divisor: i128) -> Option<SparseVector> {
    // The least number of 64 bits is left out, so that every number can be negated.
    let fits = |value: i128| i64::try_from(value / divisor).ok().filter(|&value| value != i64::MIN);
    values.into_iter().map(|(at, value)| Some((at, fits(value)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_combination_is_primitive_and_keeps_both_parts_in_step() {
        let a = EliminationRow { rest: vec![(0, 4), (2, 2)], own: vec![(0, 2)] };
        let b = EliminationRow { rest: vec![(0, -4), (1, 6)], own: vec![(1, 2)] };
        let both = EliminationRow::combine(1, &a, 1, &b).unwrap();
        assert_eq!((both.rest, both.own), (vec![(1, 3), (2, 1)], vec![(0, 1), (1, 1)]));
    }

    #[test]
    fn what_outgrows_64_bits_is_reported() {
        let a = EliminationRow { rest: vec![(0, 1)], own: vec![(0, i64::MAX), (2, 1)] };
        let b = EliminationRow { rest: vec![(0, -1)], own: vec![(1, 1)] };
        assert!(EliminationRow::combine(1, &a, 1, &b).is_some());
        assert!(EliminationRow::combine(2, &a, 1, &b).is_none());
        let c = EliminationRow { rest: vec![], own: vec![(0, -i64::MAX), (2, -1)] };
        let sum = EliminationRow::combine(i64::MAX, &a, i64::MAX - 1, &c).unwrap();
        assert_eq!(sum.own, [(0, i64::MAX), (2, 1)]);
    }
}
