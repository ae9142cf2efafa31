//! A basis of all integer solutions of y · matrix = 0, negative numbers allowed.
//!
//! There are never more solutions in a basis than rows in the matrix, while the minimal non-negative ones can be
//! exponentially many. The rows are only exchanged, negated, and added to each other in whole multiples. Such steps can
//! be undone within the integers, so what they end with is a basis of the whole lattice: every integer solution is a
//! sum of whole multiples of the ones found. In each column the rows are reduced by each other, as in Euclid's
//! algorithm, until one is left; that one is put aside.

use std::collections::BTreeSet;

use super::rays::Matrix;
use super::row::{EliminationRow, SparseVector};
use super::{SemiflowLimit, SemiflowsUndecided};

/// As many solutions as the matrix has rows beyond its rank, each with a first entry that is positive, ordered.
pub(super) fn integer_solutions(matrix: &Matrix) -> Result<Vec<SparseVector>, SemiflowsUndecided> {
    let mut rows: Vec<Option<EliminationRow>> =
        (0..).zip(&matrix.rows).map(|(i, row)| Some(EliminationRow::unit(i, row))).collect();
    let mut in_column: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); matrix.columns];
    for (index, row) in matrix.rows.iter().enumerate() {
        row.iter().for_each(|&(column, _)| _ = in_column[column as usize].insert(index));
    }
    let mut queue: BTreeSet<(usize, u32)> = (0..).zip(&in_column).map(|(at, rows)| (rows.len(), at)).collect();
    let mut eliminated = 0;
    while let Some((_, column)) = queue.pop_first() {
        let overflow =
            |rows| SemiflowsUndecided { eliminated, of: matrix.columns, rows, cause: SemiflowLimit::Overflow };
        while in_column[column as usize].len() > 1 {
            let pivot = *in_column[column as usize]
                .iter()
                .min_by_key(|&&index| rows[index].as_ref().map(|row| (row.at(column).unsigned_abs(), row.own.len())))
                .expect("there are at least two");
            let by = rows[pivot].clone().expect("rows in a column are there");
            for index in in_column[column as usize].clone().into_iter().filter(|&index| index != pivot) {
                let row = rows[index].take().expect("rows in a column are there");
                let factor = -(row.at(column) / by.at(column));
                let reduced = EliminationRow::combine(1, &row, factor, &by).ok_or_else(|| overflow(rows.len()))?;
                replace(index, &row, &reduced, &mut in_column, &mut queue);
                rows[index] = Some(reduced);
            }
        }
        if let Some(last) = in_column[column as usize].pop_first() {
            let row = rows[last].take().expect("rows in a column are there");
            replace(last, &row, &EliminationRow { rest: Vec::new(), own: Vec::new() }, &mut in_column, &mut queue);
        }
        eliminated += 1;
    }
    let mut found: Vec<SparseVector> = rows.into_iter().flatten().map(|row| row.own).collect();
    for solution in &mut found {
        if solution[0].1 < 0 {
            solution.iter_mut().for_each(|(_, value)| *value = -*value);
        }
    }
    found.sort_unstable();
    Ok(found)
}

/// Keeps the table of columns, and the order in which they are taken, in step with a row that changes.
fn replace(
    index: usize,
    old: &EliminationRow,
    new: &EliminationRow,
    in_column: &mut [BTreeSet<usize>],
    queue: &mut BTreeSet<(usize, u32)>,
) {
    let mut change = |column: u32, enters: bool| {
        let rows = &mut in_column[column as usize];
        let before = rows.len();
        let changed = if enters { rows.insert(index) } else { rows.remove(&index) };
        if changed && queue.remove(&(before, column)) {
            queue.insert((rows.len(), column));
        }
    };
    old.rest.iter().filter(|&&(column, _)| new.at(column) == 0).for_each(|&(column, _)| change(column, false));
    new.rest.iter().filter(|&&(column, _)| old.at(column) == 0).for_each(|&(column, _)| change(column, true));
}
