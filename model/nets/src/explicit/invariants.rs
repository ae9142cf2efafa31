//! Sums of tokens that never change, as far as they are cheap to find.
//!
//! The encoding of markings is built on them: a sum that is always one makes several places one digit, a positive sum
//! bounds its places, and any sum makes the count of one place follow from the others. All of them are sound by
//! themselves, so the search for them may give up at any point: the encoding becomes wider, never wrong.
//!
//! Positive sums are found by Farkas' algorithm as Martínez and Silva describe it (1982), with a cap on the number of
//! rows. Sums that hold one token have a run of their own, in which every row that already holds two is dropped: this
//! keeps the circuits of a line of stations few, whereas their combinations are as many as their subsets.

use super::sparse::{SparseEntries, combine, content, entry, gcd};
use crate::Net;

/// Rows that the search for positive sums keeps at a time.
const ROWS_MAX: usize = 1500;
/// Comparisons of rows that one search may spend; about a tenth of a second.
const EFFORT_MAX: usize = 4_000_000;
/// Nets with more places or transitions are encoded without any sums: elimination is cubic.
const NODES_MAX: usize = 4000;
/// Larger weights do not make useful sums.
const WEIGHT_MAX: i64 = 1 << 20;

/// Σ y(p)·M(p), with its value in all reachable markings.
#[derive(Clone, Debug)]
pub(super) struct Invariant {
    /// y, by place.
    pub(super) weights: SparseEntries,
    pub(super) sum: i64,
}

/// Per place, the change by every transition.
fn changes(net: &Net) -> Vec<SparseEntries> {
    let mut rows = vec![SparseEntries::new(); net.place_count()];
    let incidence = net.incidence();
    for t in net.transitions() {
        for &(place, change) in incidence.column(t) {
            rows[place.index()].push((t.0, change));
        }
    }
    rows
}

fn with_sum(net: &Net, weights: SparseEntries) -> Option<Invariant> {
    let initial = net.initial_marking();
    let mut sum = 0_i64;
    for &(place, weight) in &weights {
        sum = sum.checked_add(weight.checked_mul(i64::from(initial.as_slice()[place as usize]))?)?;
    }
    Some(Invariant { weights, sum })
}

/// Positive sums to be searched for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WantedSums {
    /// Weights of 1 that sum up to one token: exactly one of the places is marked, with one token.
    OneToken,
    /// All.
    Any,
}

/// Some positive sums: all minimal ones of that kind unless they are too many.
pub(super) fn positive(net: &Net, wanted: WantedSums) -> Vec<Invariant> {
    if net.place_count().max(net.transition_count()) > NODES_MAX {
        return Vec::new();
    }
    let initial = net.initial_marking();
    let tokens = |place: u32| u64::from(initial.as_slice()[place as usize]);
    let fits = |y: &SparseEntries| match wanted {
        WantedSums::OneToken => {
            y.iter().all(|&(_, w)| w == 1) && y.iter().map(|&(place, _)| tokens(place)).sum::<u64>() <= 1
        }
        WantedSums::Any => y.iter().all(|&(_, w)| w <= WEIGHT_MAX),
    };
    let mut rows: Vec<WeightRow> = changes(net)
        .into_iter()
        .zip(0..)
        .map(|(change, place)| WeightRow { change, weights: vec![(place, 1)] })
        .filter(|row| fits(&row.weights))
        .collect();
    let mut effort = 0;
    let mut open: Vec<u32> = (0..net.transition_count() as u32).collect();
    while let Some(t) = cheapest(&mut open, &rows) {
        let (with, mut kept): (Vec<WeightRow>, Vec<WeightRow>) =
            rows.into_iter().partition(|row| entry(&row.change, t) != 0);
        let (gains, losses): (Vec<WeightRow>, Vec<WeightRow>) =
            with.into_iter().partition(|row| entry(&row.change, t) > 0);
        for gain in &gains {
            for loss in &losses {
                if kept.len() >= ROWS_MAX || effort >= EFFORT_MAX {
                    break;
                }
                effort += 1 + kept.len();
                let sum = gain.cancel(loss, t);
                // A sum whose places include those of another is redundant.
                kept.extend(sum.filter(|sum| fits(&sum.weights) && !kept.iter().any(|row| row.within(sum))));
            }
        }
        rows = kept;
    }
    let found = rows.into_iter().filter_map(|row| with_sum(net, row.weights));
    found.filter(|found| wanted == WantedSums::Any || found.sum == 1).collect()
}

/// Takes out the transition whose elimination makes the fewest rows.
fn cheapest(open: &mut Vec<u32>, rows: &[WeightRow]) -> Option<u32> {
    let size = open.iter().max().map_or(0, |&t| t as usize + 1);
    let mut signs = vec![(0_usize, 0_usize); size];
    for &(t, change) in rows.iter().flat_map(|row| &row.change) {
        let at = &mut signs[t as usize];
        *(if change > 0 { &mut at.0 } else { &mut at.1 }) += 1;
    }
    let cost = |t: u32| signs[t as usize].0 * signs[t as usize].1;
    let best = (0..open.len()).min_by_key(|&at| (cost(open[at]), open[at]))?;
    Some(open.swap_remove(best))
}

/// A weighting, and the rest of its product with the incidence matrix.
struct WeightRow {
    change: SparseEntries,
    weights: SparseEntries,
}

impl WeightRow {
    /// The sum of both that does not change when `t` fires.
    fn cancel(&self, other: &WeightRow, t: u32) -> Option<WeightRow> {
        let (a, b) = (entry(&self.change, t), entry(&other.change, t));
        let divisor = gcd(a.unsigned_abs(), b.unsigned_abs()) as i64;
        let (a, b) = (b.checked_abs()? / divisor, a.checked_abs()? / divisor);
        let mut row = WeightRow {
            change: combine(&self.change, a, &other.change, b)?,
            weights: combine(&self.weights, a, &other.weights, b)?,
        };
        let divisor = gcd(content(&row.change), content(&row.weights)) as i64;
        if divisor > 1 {
            row.change.iter_mut().chain(&mut row.weights).for_each(|(_, value)| *value /= divisor);
        }
        Some(row)
    }

    fn within(&self, other: &WeightRow) -> bool {
        self.weights.len() <= other.weights.len()
            && self.weights.iter().all(|&(place, _)| entry(&other.weights, place) != 0)
    }
}

/// Sums of any sign, each of which makes one of `wanted` follow from places that are not: (that place, the sum, in which
/// none of the other followers occurs). Earlier places are preferred.
pub(super) fn followers(net: &Net, wanted: &[u32]) -> Vec<(u32, Invariant)> {
    if wanted.is_empty() || net.place_count().max(net.transition_count()) > NODES_MAX {
        return Vec::new();
    }
    let Some(mut basis) = null_space(net) else { return Vec::new() };
    let mut reduced: Vec<(u32, SparseEntries)> = Vec::new();
    for &place in wanted {
        let Some(at) = basis.iter().position(|row| entry(row, place) != 0) else { continue };
        let pivot = basis.swap_remove(at);
        let clear =
            |row: &SparseEntries| if entry(row, place) == 0 { Some(row.clone()) } else { without(row, &pivot, place) };
        let Some(cleared) = basis.iter().map(clear).collect::<Option<Vec<_>>>() else { break };
        let Some(others) = reduced.iter().map(|(p, row)| Some((*p, clear(row)?))).collect::<Option<Vec<_>>>() else {
            break;
        };
        basis = cleared;
        reduced = others;
        reduced.push((place, pivot));
    }
    reduced.into_iter().filter_map(|(place, row)| Some((place, with_sum(net, row)?))).collect()
}

/// A row from which a pivot row has removed a place.
fn without(row: &SparseEntries, pivot: &SparseEntries, place: u32) -> Option<SparseEntries> {
    let (a, b) = (entry(row, place), entry(pivot, place));
    let divisor = gcd(a.unsigned_abs(), b.unsigned_abs()) as i64;
    let mut sum = combine(row, b / divisor, pivot, (a / divisor).checked_neg()?)?;
    let divisor = content(&sum) as i64;
    sum.iter_mut().for_each(|(_, value)| *value /= divisor);
    Some(sum)
}

/// A basis of the weightings y with y·C = 0, unless a number on the way cannot be counted.
fn null_space(net: &Net) -> Option<Vec<SparseEntries>> {
    let start = changes(net).into_iter().zip(0..);
    let mut rows: Vec<WeightRow> =
        start.map(|(change, place)| WeightRow { change, weights: vec![(place, 1)] }).collect();
    for t in 0..net.transition_count() as u32 {
        let with = (0..rows.len()).filter(|&at| entry(&rows[at].change, t) != 0);
        let Some(pivot) = with.min_by_key(|&at| rows[at].change.len() + rows[at].weights.len()) else { continue };
        let pivot = rows.swap_remove(pivot);
        let b = entry(&pivot.change, t);
        for row in &mut rows {
            let a = entry(&row.change, t);
            if a == 0 {
                continue;
            }
            let divisor = gcd(a.unsigned_abs(), b.unsigned_abs()) as i64;
            let (own, others) = (b / divisor, (a / divisor).checked_neg()?);
            row.change = combine(&row.change, own, &pivot.change, others)?;
            row.weights = combine(&row.weights, own, &pivot.weights, others)?;
            let divisor = gcd(content(&row.change), content(&row.weights)) as i64;
            row.change.iter_mut().chain(&mut row.weights).for_each(|(_, value)| *value /= divisor);
        }
    }
    Some(rows.into_iter().map(|row| row.weights).collect())
}
