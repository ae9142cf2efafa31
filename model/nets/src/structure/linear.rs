//! The structural properties that are linear inequalities over the incidence matrix C.
//!
//! Each is decided by weights that exist or do not (seed 000 §2.5.4, L1045-1065; Murata 1989, §VIII):
//!
//! | a net is | iff there is | and means |
//! |---|---|---|
//! | conservative | y > 0 with y·C = 0 | a weighted sum of all tokens never changes |
//! | structurally bounded | y > 0 with y·C ≤ 0 | bounded from whatever marking it starts |
//! | consistent | x > 0 with C·x = 0 | some marking returns to itself by firing every transition |
//! | repetitive | x > 0 with C·x ≥ 0 | some marking allows every transition infinitely often |
//!
//! The seed asks of a conservative net that the weights be integers only; here they are positive, as in Murata, because
//! otherwise all zeros would do. [`Net::is_conservative`] is the stricter question with all weights 1. And complete
//! controllability, any marking from any other, needs rank C = |P| (seed 000, L1057): necessary, not sufficient, and
//! impossible where anything is conserved.

use crate::semiflows::rays::{Matrix, minimal_solutions};
use crate::semiflows::{SemiflowLimit, SemiflowLimits, SemiflowsUndecided, by_place, by_transition, rank};
use crate::{Net, PlaceId, TransitionId};

/// Weights of all nodes of a kind, all positive; or the nodes that have weight zero in every solution.
pub type Positive<I> = Result<Vec<u64>, Vec<I>>;

/// The linear properties of a net, each with the weights that prove it or the nodes that stand in the way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinearProperties {
    /// y > 0 with y·C = 0; else the places in no conserved sum.
    pub conservative: Positive<PlaceId>,
    /// y > 0 with y·C ≤ 0; else the places that are unbounded from some marking.
    pub structurally_bounded: Positive<PlaceId>,
    /// x > 0 with C·x = 0; else the transitions in no repetition.
    pub consistent: Positive<TransitionId>,
    /// x > 0 with C·x ≥ 0; else the transitions that fire finitely often from every marking.
    pub repetitive: Positive<TransitionId>,
    /// rank C = |P|, which complete controllability needs.
    pub full_rank: bool,
}

impl Net {
    /// Decides the properties that are linear inequalities, or says which search became too large.
    pub fn linear_properties(&self, limits: &SemiflowLimits) -> Result<LinearProperties, SemiflowsUndecided> {
        let (places, transitions) = (by_place(self), by_transition(self));
        Ok(LinearProperties {
            conservative: positive(&places, places.rows.len(), PlaceId, limits)?,
            structurally_bounded: positive(&with_slack(&places, 1), places.rows.len(), PlaceId, limits)?,
            consistent: positive(&transitions, transitions.rows.len(), TransitionId, limits)?,
            repetitive: positive(&with_slack(&transitions, -1), transitions.rows.len(), TransitionId, limits)?,
            full_rank: rank(self)? == self.place_count(),
        })
    }
}

/// One more row per column, with nothing but `sign` in it: what is left over in that column.
fn with_slack(matrix: &Matrix, sign: i64) -> Matrix {
    let slack = (0..matrix.columns as u32).map(|column| vec![(column, sign)]);
    Matrix { rows: matrix.rows.iter().cloned().chain(slack).collect(), columns: matrix.columns }
}

/// The sum of as many minimal solutions as it takes to have a weight on each of the first `count` rows.
fn positive<I>(
    matrix: &Matrix,
    count: usize,
    id: fn(u32) -> I,
    limits: &SemiflowLimits,
) -> Result<Positive<I>, SemiflowsUndecided> {
    let solutions = minimal_solutions(matrix, limits)?;
    let mut weights = vec![0_u64; count];
    let real = |solution: &[(u32, i64)]| solution.iter().filter(|&&(row, _)| (row as usize) < count).count();
    for solution in &solutions {
        let own = &solution[..real(solution)];
        if own.iter().any(|&(row, _)| weights[row as usize] == 0) {
            for &(row, weight) in own {
                let sum = weights[row as usize].checked_add(weight.unsigned_abs());
                let columns = matrix.columns;
                let overflow = SemiflowsUndecided {
                    eliminated: columns,
                    of: columns,
                    rows: solutions.len(),
                    cause: SemiflowLimit::Overflow,
                };
                weights[row as usize] = sum.ok_or(overflow)?;
            }
        }
    }
    let missing: Vec<I> = (0..).zip(&weights).filter(|&(_, &weight)| weight == 0).map(|(row, _)| id(row)).collect();
    Ok(if missing.is_empty() { Ok(weights) } else { Err(missing) })
}

#[cfg(test)]
mod tests {
    use crate::semiflows::SemiflowLimits;
    use crate::{Net, NetBuilder, PlaceId, TransitionId};

    type Side = [(usize, u32)];

    fn net(places: usize, transitions: &[(&Side, &Side)]) -> Net {
        let mut b = NetBuilder::new("n");
        let places: Vec<_> = (0..places).map(|i| b.place(format!("p{i}"), 0)).collect();
        for (i, (takes, gives)) in transitions.iter().enumerate() {
            let t = b.transition(format!("t{i}"));
            takes.iter().for_each(|&(p, n)| _ = b.input(t, places[p], n));
            gives.iter().for_each(|&(p, n)| _ = b.output(t, places[p], n));
        }
        b.build().unwrap()
    }

    #[test]
    fn four_bolts_against_one_part_are_conservative_and_consistent() {
        let net = net(2, &[(&[(0, 4)], &[(1, 1)]), (&[(1, 1)], &[(0, 4)])]);
        let found = net.linear_properties(&SemiflowLimits::default()).unwrap();
        assert_eq!(found.conservative, Ok(vec![1, 4]));
        assert_eq!(found.consistent, Ok(vec![1, 1]));
        assert!(found.structurally_bounded.is_ok() && found.repetitive.is_ok() && !found.full_rank);
    }

    #[test]
    fn a_drain_is_bounded_without_being_conservative() {
        let net = net(1, &[(&[(0, 1)], &[])]);
        let found = net.linear_properties(&SemiflowLimits::default()).unwrap();
        assert_eq!(found.conservative, Err(vec![PlaceId(0)]));
        assert_eq!(found.structurally_bounded, Ok(vec![1]));
        assert_eq!(found.repetitive, Err(vec![TransitionId(0)]));
        assert!(found.full_rank);
    }

    #[test]
    fn a_spring_repeats_without_being_consistent() {
        let net = net(1, &[(&[], &[(0, 1)])]);
        let found = net.linear_properties(&SemiflowLimits::default()).unwrap();
        assert_eq!(found.repetitive, Ok(vec![1]));
        assert_eq!(found.consistent, Err(vec![TransitionId(0)]));
        assert_eq!(found.structurally_bounded, Err(vec![PlaceId(0)]));
    }
}
