//! The token game on any net: changes by a move, and what no move changes.

use linewright_nets::{Marking, Net, explore};
use proptest::prelude::*;

/// Plays up to `choices.len()` moves, each picked from what is enabled; calls `check` with before, move and after.
fn play(net: &Net, choices: &[usize], mut check: impl FnMut(&Marking, linewright_nets::TransitionId, &Marking)) {
    let mut marking = net.initial_marking();
    for choice in choices {
        let enabled: Vec<_> = net.enabled(&marking).collect();
        if enabled.is_empty() {
            break;
        }
        let t = enabled[choice % enabled.len()];
        let before = marking.clone();
        net.fire(&mut marking, t).expect("an enabled transition fires");
        check(&before, t, &marking);
    }
}

proptest! {
    #[test]
    fn a_move_adds_its_column_of_the_incidence_matrix(net in crate::common::any_net(), choices in choices()) {
        let c = net.incidence();
        play(&net, &choices, |before, t, after| {
            for p in net.places() {
                assert_eq!(i64::from(after.tokens(p)), i64::from(before.tokens(p)) + c.entry(p, t));
            }
        });
    }

    #[test]
    fn a_refused_move_changes_nothing_and_tells_the_truth(net in crate::common::any_net()) {
        let start = net.initial_marking();
        for t in net.transitions() {
            let mut marking = start.clone();
            match net.fire(&mut marking, t) {
                Ok(()) => prop_assert!(net.is_enabled(&start, t)),
                Err(error) => {
                    prop_assert!(!net.is_enabled(&start, t));
                    prop_assert_eq!(&marking, &start);
                    let needs = net.preset(t).iter().find(|&&(p, _)| p == error.place()).unwrap().1;
                    prop_assert!(start.tokens(error.place()) < needs);
                }
            }
        }
    }

    #[test]
    fn a_place_invariant_keeps_its_sum_in_every_reachable_marking((net, weights) in crate::common::weighed_net()) {
        let signed: Vec<i64> = weights.iter().map(|&weight| weight.into()).collect();
        prop_assert_eq!(net.incidence().place_invariant(&signed), Ok(()));
        let sum = |m: &Marking| -> u32 { m.as_slice().iter().zip(&weights).map(|(n, weight)| n * weight).sum() };
        let initial = sum(&net.initial_marking());
        for marking in explore(&net, 100_000).unwrap().states() {
            prop_assert_eq!(sum(marking), initial);
        }
    }
}

fn choices() -> impl Strategy<Value = Vec<usize>> {
    prop::collection::vec(0_usize..60, 0..30)
}
