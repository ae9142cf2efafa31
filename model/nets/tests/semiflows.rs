//! Semiflows against the vectors that a slow search finds, and on nets whose semiflows are known.

use crate::common::light_net;
use crate::explicit_ring::ring;
use linewright_nets::semiflows::{
    Semiflow, SemiflowLimit, SemiflowLimits, place_flow_basis, place_semiflows, rank, transition_flow_basis,
    transition_semiflows,
};
use linewright_nets::{Net, NetBuilder, PlaceId, explore};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The same nets on every run.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(1971), ..ProptestConfig::default() }
}

/// Every vector of `length` numbers from 0 to `most`, except zero.
fn vectors(length: usize, most: u64) -> impl Iterator<Item = Vec<u64>> {
    let base = most + 1;
    (1..base.pow(length as u32)).map(move |code| (0..length).map(|i| code / base.pow(i as u32) % base).collect())
}

fn support(vector: &[u64]) -> u64 {
    (0..).zip(vector).filter(|&(_, &value)| value > 0).map(|(i, _)| 1 << i).sum()
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// The change that each line of the matrix sees, `matrix[i][j]` being line i, column j of C or its transpose.
fn is_flow(vector: &[u64], matrix: &[Vec<i64>]) -> bool {
    let columns = matrix.first().map_or(0, Vec::len);
    (0..columns).all(|j| matrix.iter().zip(vector).map(|(row, &y)| row[j] * y as i64).sum::<i64>() == 0)
}

fn incidence(net: &Net) -> Vec<Vec<i64>> {
    let c = net.incidence();
    net.places().map(|p| net.transitions().map(|t| c.entry(p, t)).collect()).collect()
}

fn transposed(net: &Net) -> Vec<Vec<i64>> {
    let c = net.incidence();
    net.transitions().map(|t| net.places().map(|p| c.entry(p, t)).collect()).collect()
}

/// Whether `found` is all minimal semiflows, as far as vectors with small entries show.
fn compare(found: &[Vec<u64>], matrix: &[Vec<i64>], most: u64) {
    for flow in found {
        assert!(is_flow(flow, matrix), "{flow:?}");
        assert_eq!(flow.iter().copied().fold(0, gcd), 1, "{flow:?}");
        let inside = |other: &&Vec<u64>| support(other) & !support(flow) == 0;
        assert_eq!(found.iter().filter(inside).count(), 1, "{flow:?} is not minimal");
    }
    for flow in vectors(matrix.len(), most).filter(|vector| is_flow(vector, matrix)) {
        let below: Vec<_> = found.iter().filter(|other| support(other) & !support(&flow) == 0).collect();
        assert!(!below.is_empty(), "{flow:?} is above none of {found:?}");
        let same = below.iter().find(|other| support(other) == support(&flow));
        let divisor = flow.iter().copied().fold(0, gcd);
        let primitive: Vec<u64> = flow.iter().map(|value| value / divisor).collect();
        assert!(same.is_none_or(|other| **other == primitive), "{flow:?} and {same:?}");
    }
}

fn dense<I: Copy>(flows: &[Semiflow<I>], length: usize, index: impl Fn(I) -> usize) -> Vec<Vec<u64>> {
    let dense = |flow: &Semiflow<I>| {
        let mut vector = vec![0; length];
        flow.weights.iter().for_each(|&(node, weight)| vector[index(node)] = weight);
        vector
    };
    flows.iter().map(dense).collect()
}

proptest! {
    #![proptest_config(cases(1500))]

    #[test]
    fn they_are_the_minimal_vectors_of_a_slow_search(net in prop_oneof![2 => light_net(5), 1 => crate::common::any_net()]) {
        let limits = SemiflowLimits::default();
        let places = place_semiflows(&net, &limits).unwrap();
        compare(&dense(places.all(), net.place_count(), PlaceId::index), &incidence(&net), 4);
        let transitions = transition_semiflows(&net, &limits).unwrap();
        let dense = dense(transitions.all(), net.transition_count(), |t| t.index());
        compare(&dense, &transposed(&net), 4);
        prop_assert!(places.all().is_sorted() && transitions.all().is_sorted());
    }

    #[test]
    fn a_basis_spans_every_small_integer_solution(net in light_net(5)) {
        let matrix = incidence(&net);
        let basis = place_flow_basis(&net).unwrap();
        prop_assert_eq!(basis.len() + rank(&net).unwrap(), net.place_count());
        prop_assert_eq!(transition_flow_basis(&net).unwrap().len() + rank(&net).unwrap(), net.transition_count());
        let c = net.incidence();
        let mut dense: Vec<Vec<i64>> = Vec::new();
        for flow in &basis {
            let mut weights = vec![0; net.place_count()];
            flow.entries.iter().for_each(|&(place, entry)| weights[place.index()] = entry);
            prop_assert_eq!(c.place_invariant(&weights), Ok(()));
            dense.push(weights);
        }
        // Each solution with entries from -1 to 1 leaves nothing after whole multiples of the basis are taken away.
        let echelon = echelon(dense);
        for vector in vectors(net.place_count(), 2) {
            let vector: Vec<i64> = vector.iter().map(|&value| value as i64 - 1).collect();
            let solves = (0..net.transition_count()).all(|t| matrix.iter().zip(&vector).map(|(row, y)| row[t] * y).sum::<i64>() == 0);
            if solves {
                prop_assert!(is_whole_combination(&echelon, vector.clone()), "{vector:?} of {echelon:?}");
            }
        }
    }

    #[test]
    fn bounds_and_exclusions_hold_in_every_reachable_marking((net, _) in crate::common::weighed_net()) {
        let flows = place_semiflows(&net, &SemiflowLimits::default()).unwrap();
        let initial = net.initial_marking();
        prop_assert_eq!(flows.uncovered(&net).count(), 0);
        let explored = explore(&net, 100_000).unwrap();
        for p in net.places() {
            let (bound, by) = flows.bound(p, &initial).unwrap();
            prop_assert!(u128::from(explored.bound_of(p)) <= bound);
            prop_assert!(by.weight(p) > 0);
            for q in net.places() {
                let together = explored.states().iter().any(|m| m.tokens(p) > 0 && m.tokens(q) > 0);
                prop_assert!(!together || flows.excludes(p, q, &initial).is_none());
            }
        }
    }
}

/// Rows of the same lattice in echelon form, by Euclid's algorithm, column by column.
fn echelon(mut rows: Vec<Vec<i64>>) -> Vec<Vec<i64>> {
    let mut done = Vec::new();
    for column in 0..rows.first().map_or(0, Vec::len) {
        while rows.iter().filter(|row| row[column] != 0).count() > 1 {
            rows.sort_by_key(|row| if row[column] == 0 { i64::MAX } else { row[column].abs() });
            let pivot = rows[0].clone();
            for row in &mut rows[1..] {
                let factor = row[column] / pivot[column];
                row.iter_mut().zip(&pivot).for_each(|(value, by)| *value -= factor * by);
            }
        }
        if let Some(at) = rows.iter().position(|row| row[column] != 0) {
            done.push(rows.remove(at));
        }
    }
    done
}

fn is_whole_combination(echelon: &[Vec<i64>], mut vector: Vec<i64>) -> bool {
    for row in echelon {
        let column = row.iter().position(|&value| value != 0).unwrap();
        if vector[column] % row[column] != 0 {
            return false;
        }
        let factor = vector[column] / row[column];
        vector.iter_mut().zip(row).for_each(|(value, by)| *value -= factor * by);
    }
    vector.iter().all(|&value| value == 0)
}

#[test]
fn a_ring_of_a_hundred_stations_has_its_elementary_circuits() {
    let net = ring(100, false);
    assert_eq!((net.place_count(), net.transition_count()), (1400, 1200));
    let flows = place_semiflows(&net, &SemiflowLimits::default()).unwrap();
    // Per station its own cycle; per buffer full against empty; and once round the line with the parts and against.
    assert_eq!(flows.all().len(), 100 + 100 + 2);
    let initial = net.initial_marking();
    for flow in flows.all() {
        assert!(flow.weights.iter().all(|&(_, weight)| weight == 1));
        assert_eq!(net.incidence().place_invariant(&dense_weights(&net, flow)), Ok(()));
    }
    assert!(net.places().all(|p| flows.bound(p, &initial).unwrap().0 == 1));
    let [own, other] = ["o_7_0", "c_7_3"].map(|name| net.place_named(name).unwrap());
    assert!(flows.excludes(own, other, &initial).is_some());

    let round = transition_semiflows(&net, &SemiflowLimits::default()).unwrap();
    assert_eq!(round.all().len(), 1);
    assert!(round.all()[0].weights.iter().map(|&(_, count)| count).eq([1; 1200]));
    assert_eq!(rank(&net).unwrap(), 1199);
}

fn dense_weights(net: &Net, flow: &Semiflow<PlaceId>) -> Vec<i64> {
    net.places().map(|place| flow.weight(place) as i64).collect()
}

/// `n` choices in a row, each between two places: 2ⁿ minimal transition semiflows.
fn choices(n: usize) -> Net {
    let mut b = NetBuilder::new("choices");
    let places: Vec<_> = (0..n).map(|i| b.place(format!("p{i}"), u32::from(i == 0))).collect();
    for i in 0..n {
        for way in ["left", "right"] {
            let t = b.transition(format!("{way} {i}"));
            b.input(t, places[i], 1).output(t, places[(i + 1) % n], 1);
        }
    }
    b.build().unwrap()
}

#[test]
fn too_many_are_undecided_and_the_basis_is_not() {
    assert_eq!(transition_semiflows(&choices(10), &SemiflowLimits::default()).unwrap().all().len(), 1024);
    let net = choices(40);
    let limits = SemiflowLimits { rows: 5_000, ..SemiflowLimits::default() };
    let error = transition_semiflows(&net, &limits).unwrap_err();
    assert_eq!(error.cause, SemiflowLimit::Rows);
    assert!(error.to_string().starts_with("undecided after "), "{error}");
    let limits = SemiflowLimits { bytes: 100_000, ..SemiflowLimits::default() };
    assert_eq!(transition_semiflows(&net, &limits).unwrap_err().cause, SemiflowLimit::Bytes);
    let limits = SemiflowLimits { looks: 10_000, ..SemiflowLimits::default() };
    assert_eq!(transition_semiflows(&net, &limits).unwrap_err().cause, SemiflowLimit::Combinations);
    let limits = SemiflowLimits { combinations: 1_000, ..SemiflowLimits::default() };
    assert_eq!(transition_semiflows(&net, &limits).unwrap_err().cause, SemiflowLimit::Combinations);
    assert_eq!(transition_flow_basis(&net).unwrap().len(), 41);
}

#[test]
fn weights_beyond_63_bits_are_undecided() {
    let mut b = NetBuilder::new("powers");
    let places: Vec<_> = (0..4).map(|i| b.place(format!("p{i}"), 0)).collect();
    for pair in places.windows(2) {
        let t = b.transition(format!("t{}", pair[0].0));
        b.input(t, pair[0], u32::MAX).output(t, pair[1], u32::MAX - 1);
    }
    let net = b.build().unwrap();
    let error = place_semiflows(&net, &SemiflowLimits::default()).unwrap_err();
    assert_eq!(error.cause, SemiflowLimit::Overflow);
    assert!(error.to_string().ends_with("a weight needs more than 63 bits"), "{error}");
    assert_eq!(place_flow_basis(&net).unwrap_err().cause, SemiflowLimit::Overflow);
}
