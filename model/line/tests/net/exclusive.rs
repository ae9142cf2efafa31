//! Check of `overlaps`: conditions are evaluated over every assignment of their variables, and compared.
//!
//! An assignment is one that the controller could see: an edge comes with its level, the panel gives one command at a
//! time, a station is on one recovery path at most and "on any path" holds if it is on one.

use std::collections::BTreeSet;

use linewright_line::net::{Block, Conjunction, ControlMode, Literal, StationNet, Var};
use linewright_line::{ButtonId, Line, OpId, StationId};
use proptest::prelude::*;

use super::generate::station_alone;
use linewright_testkit::built::transfer_line;

fn is_possible(on: &BTreeSet<Var>) -> bool {
    let has = |var| on.contains(&var);
    let paths = on.iter().filter(|v| matches!(v, Var::OnPath(_))).count();
    let edges_have_levels = on.iter().all(|&var| match var {
        Var::AdvancePressed => has(Var::Advance),
        Var::RetractPressed => has(Var::Retract),
        Var::Pressed(button) => has(Var::Held(button)),
        _ => true,
    });
    edges_have_levels && !(has(Var::Advance) && has(Var::Retract)) && paths <= 1 && (paths == 0 || has(Var::OnAnyPath))
}

fn holds(term: &Conjunction, on: &BTreeSet<Var>) -> bool {
    term.iter().all(|literal| on.contains(&literal.var) == literal.on)
}

/// Every possible assignment of the variables of these terms, levels of edges included.
fn assignments<'a>(terms: impl Iterator<Item = &'a Conjunction>) -> impl Iterator<Item = BTreeSet<Var>> {
    let mut vars: BTreeSet<Var> = terms.flatten().map(|literal| literal.var).collect();
    for var in vars.clone() {
        match var {
            Var::AdvancePressed => vars.extend([Var::Advance]),
            Var::RetractPressed => vars.extend([Var::Retract]),
            Var::Pressed(button) => vars.extend([Var::Held(button)]),
            Var::OnPath(_) => vars.extend([Var::OnAnyPath]),
            _ => {}
        }
    }
    let vars: Vec<Var> = vars.into_iter().collect();
    assert!(vars.len() <= 16, "small enough to try everything: {vars:?}");
    (0u32..1 << vars.len())
        .map(move |bits| vars.iter().enumerate().filter(|&(n, _)| bits & (1 << n) != 0).map(|(_, &v)| v).collect())
        .filter(is_possible)
}

/// No assignment enables two transitions of one place.
fn nothing_happens_twice(line: &Line, station: StationId) {
    let net = StationNet::of(line, station);
    for &place in net.places() {
        let outgoing: Vec<_> = net.transitions().iter().filter(|t| t.from.contains(&place)).collect();
        for mode in ControlMode::ALL {
            for on in assignments(outgoing.iter().flat_map(|t| t.terms(mode))) {
                let enabled = outgoing.iter().filter(|t| t.terms(mode).iter().any(|term| holds(term, &on)));
                let kinds: Vec<_> = enabled.map(|t| t.kind).collect();
                assert!(kinds.len() <= 1, "in {mode}, with {on:?}, {place} may go {kinds:?}");
            }
        }
    }
}

#[test]
fn in_the_transfer_line_no_assignment_enables_two_transitions_of_a_place() {
    let line = transfer_line();
    line.station_ids().for_each(|station| nothing_happens_twice(&line, station));
}

/// All variables that relate to another, and one that does not.
const RELATED: [Var; 11] = [
    Var::Advance,
    Var::AdvancePressed,
    Var::Retract,
    Var::RetractPressed,
    Var::Held(ButtonId(0)),
    Var::Held(ButtonId(1)),
    Var::Pressed(ButtonId(0)),
    Var::OnAnyPath,
    Var::OnPath(OpId(1)),
    Var::OnPath(OpId(2)),
    Var::Fault(OpId(0), Block::Normal),
];

#[test]
fn two_literals_exclude_each_other_exactly_if_no_assignment_has_both() {
    let literals: Vec<Literal> = RELATED.iter().flat_map(|&var| [true, false].map(|on| Literal { var, on })).collect();
    for &a in &literals {
        for &b in &literals {
            let both = vec![a, b];
            let satisfiable = assignments([&both].into_iter()).any(|on| holds(&both, &on));
            assert_eq!(a.excludes(b), !satisfiable, "{a:?} {b:?}");
            assert_eq!(a.excludes(b), b.excludes(a), "exclusion goes both ways");
        }
    }
}

fn term() -> impl Strategy<Value = Conjunction> {
    prop::collection::vec((0..RELATED.len(), any::<bool>()).prop_map(|(n, on)| Literal { var: RELATED[n], on }), 0..5)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn in_a_random_station_no_assignment_enables_two_transitions_of_a_place(line in station_alone()) {
        nothing_happens_twice(&line, StationId(0));
    }

    /// The test `overlaps` uses, on any two terms that can hold by themselves: it errs in neither direction.
    #[test]
    fn terms_exclude_each_other_exactly_if_two_of_their_literals_do(a in term(), b in term()) {
        let alone = |term: &Conjunction| assignments([term].into_iter()).any(|on| holds(term, &on));
        prop_assume!(alone(&a) && alone(&b));
        let found = a.iter().any(|la| b.iter().any(|lb| la.excludes(*lb)));
        let together = assignments([&a, &b].into_iter()).any(|on| holds(&a, &on) && holds(&b, &on));
        prop_assert_eq!(found, !together);
    }
}
