//! All minimal non-negative solutions of y · matrix = 0, by elimination of one column after another.
//!
//! This is the algorithm of Farkas and of Fourier and Motzkin, in the form of the double description method. After any
//! number of columns the rows are exactly the vectors of minimal support that solve these columns: the extreme rays of
//! a pointed cone. For the next column every row with a positive entry meets every row with a negative one. Their sum is
//! a new extreme ray iff the two are adjacent, and they are adjacent iff the union of their supports contains the
//! support of no third row (Fukuda and Prodon, *Double description method revisited*, 1996, Proposition 7). Without that
//! test the rows would grow doubly exponentially, and most of them would be of no use.
//!
//! The order of the columns decides how large the rows in between become: fewest new rows first. Columns without one of
//! the signs delete rows, columns with one row of each sign contract a chain; both come first by that rule, which is
//! why large sparse nets shrink before anything multiplies.

use std::collections::BTreeSet;

use super::row::{EliminationRow, SparseVector, gcd};
use super::{SemiflowLimit, SemiflowLimits, SemiflowsUndecided};

/// A matrix by rows.
pub(crate) struct Matrix {
    pub rows: Vec<SparseVector>,
    pub columns: usize,
}

/// The vectors of minimal support among all y ≥ 0, y ≠ 0 with y · matrix = 0, each divided by its common divisor,
/// ordered.
pub(crate) fn minimal_solutions(
    matrix: &Matrix,
    limits: &SemiflowLimits,
) -> Result<Vec<SparseVector>, SemiflowsUndecided> {
    let mut rays = Rays::new(matrix, *limits);
    rays.check_size()?;
    while let Some((_, column)) = rays.queue.pop_first() {
        rays.eliminate(column)?;
        rays.eliminated += 1;
    }
    let mut found: Vec<SparseVector> = rays.rows.into_iter().flatten().map(|ray| ray.row.own).collect();
    found.sort_unstable();
    Ok(found)
}

struct Ray {
    row: EliminationRow,
    /// A bit for each element of the support, by a hash: what has a bit that another lacks is no subset of it.
    signature: u64,
}

struct Rays {
    limits: SemiflowLimits,
    rows: Vec<Option<Ray>>,
    /// Per column, the rows that had an entry in it when they were made; those gone since are skipped.
    in_column: Vec<Vec<usize>>,
    /// Per element, the rows whose support begins with it.
    begins_with: Vec<Vec<usize>>,
    /// Per column, how many rows are positive and negative in it.
    signs: Vec<[i64; 2]>,
    /// The columns still to do, by how many rows their elimination adds at most.
    queue: BTreeSet<(i64, u32)>,
    todo: Vec<bool>,
    alive: usize,
    bytes: usize,
    combinations: u64,
    looks: u64,
    eliminated: usize,
    /// Scratch: the elements of the union that is being tested are those with the current stamp.
    stamps: Vec<u32>,
    stamp: u32,
}

fn bit(element: u32) -> u64 {
    // The multiplier of Fibonacci hashing spreads neighbours.
    1 << (element.wrapping_mul(0x9E37_79B9) >> 26)
}

fn growth([positive, negative]: [i64; 2]) -> i64 {
    positive * negative - positive - negative
}

impl Rays {
    fn new(matrix: &Matrix, limits: SemiflowLimits) -> Rays {
        let mut rays = Rays {
            limits,
            rows: Vec::new(),
            in_column: vec![Vec::new(); matrix.columns],
            begins_with: vec![Vec::new(); matrix.rows.len()],
            signs: vec![[0, 0]; matrix.columns],
            queue: (0..matrix.columns as u32).map(|column| (0, column)).collect(),
            todo: vec![true; matrix.columns],
            alive: 0,
            bytes: 0,
            combinations: 0,
            looks: 0,
            eliminated: 0,
            stamps: vec![0; matrix.rows.len()],
            stamp: 0,
        };
        for (index, row) in matrix.rows.iter().enumerate() {
            rays.insert(EliminationRow::unit(index, row));
        }
        rays
    }

    fn undecided(&self, cause: SemiflowLimit) -> SemiflowsUndecided {
        SemiflowsUndecided { eliminated: self.eliminated, of: self.todo.len(), rows: self.alive, cause }
    }

    fn check_size(&self) -> Result<(), SemiflowsUndecided> {
        if self.alive > self.limits.rows {
            return Err(self.undecided(SemiflowLimit::Rows));
        }
        if self.bytes > self.limits.bytes {
            return Err(self.undecided(SemiflowLimit::Bytes));
        }
        Ok(())
    }

    fn count(&mut self, row: &EliminationRow, change: i64) {
        for &(column, value) in &row.rest {
            let at = column as usize;
            let before = growth(self.signs[at]);
            self.signs[at][usize::from(value < 0)] += change;
            let after = growth(self.signs[at]);
            if self.todo[at] && before != after {
                self.queue.remove(&(before, column));
                self.queue.insert((after, column));
            }
        }
    }

    fn insert(&mut self, row: EliminationRow) {
        let index = self.rows.len();
        self.count(&row, 1);
        for &(column, _) in &row.rest {
            self.in_column[column as usize].push(index);
        }
        self.begins_with[row.own[0].0 as usize].push(index);
        self.alive += 1;
        self.bytes += row.bytes();
        let signature = row.own.iter().fold(0, |bits, &(element, _)| bits | bit(element));
        self.rows.push(Some(Ray { row, signature }));
    }

    fn remove(&mut self, index: usize) {
        if let Some(ray) = self.rows[index].take() {
            self.count(&ray.row, -1);
            self.alive -= 1;
            self.bytes -= ray.row.bytes();
            self.begins_with[ray.row.own[0].0 as usize].retain(|&other| other != index);
        }
    }

    /// Replaces all rows that are not zero in the column by their sums that are.
    fn eliminate(&mut self, column: u32) -> Result<(), SemiflowsUndecided> {
        self.todo[column as usize] = false;
        let (mut positive, mut negative) = (Vec::new(), Vec::new());
        for index in std::mem::take(&mut self.in_column[column as usize]) {
            if let Some(ray) = &self.rows[index] {
                if ray.row.at(column) > 0 { positive.push(index) } else { negative.push(index) }
            }
        }
        let mut sums = Vec::new();
        let mut bytes = self.bytes;
        for &a in &positive {
            for &b in &negative {
                self.combinations += 1;
                let is_adjacent = self.adjacent(a, b);
                if self.combinations > self.limits.combinations || self.looks > self.limits.looks {
                    return Err(self.undecided(SemiflowLimit::Combinations));
                }
                if !is_adjacent {
                    continue;
                }
                let sum = self.cancel(a, b, column).ok_or_else(|| self.undecided(SemiflowLimit::Overflow))?;
                bytes += sum.bytes();
                sums.push(sum);
                if self.alive + sums.len() > self.limits.rows {
                    return Err(self.undecided(SemiflowLimit::Rows));
                }
                if bytes > self.limits.bytes {
                    return Err(self.undecided(SemiflowLimit::Bytes));
                }
            }
        }
        positive.into_iter().chain(negative).for_each(|index| self.remove(index));
        sums.into_iter().for_each(|row| self.insert(row));
        self.check_size()
    }

    fn ray(&self, index: usize) -> &Ray {
        self.rows[index].as_ref().expect("the row is there until its column is eliminated")
    }

    /// Whether no third row is in the union of the two supports.
    fn adjacent(&mut self, a: usize, b: usize) -> bool {
        let union: Vec<u32> = {
            let (a, b) = (&self.ray(a).row.own, &self.ray(b).row.own);
            let mut union: Vec<u32> = a.iter().chain(b).map(|&(element, _)| element).collect();
            union.sort_unstable();
            union.dedup();
            union
        };
        // A solution of k columns that has minimal support has at most k + 1 elements, and this is column k + 1.
        if union.len() > self.eliminated + 2 {
            return false;
        }
        if self.stamp == u32::MAX {
            self.stamps.fill(0);
            self.stamp = 0;
        }
        self.stamp += 1;
        union.iter().for_each(|&element| self.stamps[element as usize] = self.stamp);
        let signature = self.ray(a).signature | self.ray(b).signature;
        let inside = |index: usize| {
            let other = self.ray(index);
            other.signature & !signature == 0
                && other.row.own.len() <= union.len()
                && other.row.own.iter().all(|&(element, _)| self.stamps[element as usize] == self.stamp)
        };
        let mut looks = union.len() as u64;
        let mut others = union.iter().flat_map(|&element| &self.begins_with[element as usize]).copied();
        let found = others.any(|other| {
            looks += 1;
            other != a && other != b && inside(other)
        });
        self.looks += looks;
        !found
    }

    /// The positive sum of two rows that is zero in the column.
    fn cancel(&self, a: usize, b: usize, column: u32) -> Option<EliminationRow> {
        let (a, b) = (&self.ray(a).row, &self.ray(b).row);
        let (x, y) = (b.at(column).unsigned_abs(), a.at(column).unsigned_abs());
        let divisor = gcd(x.into(), y.into()) as u64;
        // Both come from `i64` values other than the least one.
        EliminationRow::combine((x / divisor) as i64, a, (y / divisor) as i64, b)
    }
}
