//! Structural verdicts against exploration, and the checker against certificates that were tampered with.

mod samples;

use std::collections::BTreeMap;

use crate::explicit_ring::ring;
use linewright_nets::certificate::{
    Certificate, CertificateAnswer, CertificateRule, Evidence, NetProperty, StructuralVerdict, TokenBound, Unknown,
    check, decide_by_structure,
};
use linewright_nets::coverability::{self, coverability};
use linewright_nets::{Net, NetBuilder, explore};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use samples::{connected_marked_graph, free_choice_net, marked_graph, samples};

const ENOUGH: usize = 700;

type Truth = BTreeMap<NetProperty, bool>;
type Judged = (Net, StructuralVerdict, Truth);

/// Facts found by playing everything out, as far as it comes to an end.
fn truth(net: &Net) -> Truth {
    let mut truth = BTreeMap::new();
    if let Ok(explored) = explore(net, ENOUGH) {
        truth.insert(NetProperty::DeadlockFree, explored.deadlocks().next().is_none());
        truth.insert(NetProperty::Live, explored.is_live());
        truth.insert(NetProperty::Bounded, true);
        truth.insert(NetProperty::Safe, explored.is_safe());
        truth.insert(NetProperty::Reversible, explored.is_reversible().is_ok());
    } else if let Ok(found) =
        coverability(net, &coverability::CoverabilityLimits { labels: ENOUGH, ..Default::default() })
    {
        truth.insert(NetProperty::Bounded, found.is_bounded().is_ok());
        truth.insert(NetProperty::Safe, net.places().all(|p| found.bound_of(p).is_some_and(|bound| bound <= 1)));
    }
    truth
}

/// The verdict, after comparing it with the truth and letting the checker look at every certificate.
fn confirmed(net: &Net) -> (StructuralVerdict, Truth) {
    let verdict = decide_by_structure(net);
    let truth = truth(net);
    for property in NetProperty::ALL {
        let answer = verdict.answer(property);
        if let (Some(claimed), Some(&holds)) = (answer.holds(), truth.get(&property)) {
            assert_eq!(claimed, holds, "{property}\n{net}{verdict}");
        }
        if let Some(certificate) = answer.certificate() {
            assert_eq!((certificate.property, Some(certificate.holds)), (property, answer.holds()));
            assert_eq!(check(net, certificate), Ok(()), "{net}{certificate}");
            assert_eq!(Certificate::parse(&certificate.to_string()).as_ref(), Ok(certificate));
        }
    }
    (verdict, truth)
}

/// The bounds, against those of the coverability graph.
fn confirm_bounds(net: &Net, verdict: &StructuralVerdict) {
    let Ok(found) = coverability(net, &coverability::CoverabilityLimits { labels: ENOUGH, ..Default::default() })
    else {
        return;
    };
    for place in net.places() {
        let bound = found.bound_of(place).map(u128::from);
        match verdict.bounds[place.index()] {
            TokenBound::Exactly(most) => assert_eq!(bound, Some(most), "{net}{verdict}"),
            TokenBound::AtMost(most) => assert!(bound.is_some_and(|bound| bound <= most), "{net}"),
            TokenBound::Unbounded => assert_eq!(bound, None, "{net}"),
            TokenBound::Unknown => {}
        }
    }
}

fn kinds(verdicts: &[Judged]) -> BTreeMap<String, usize> {
    let mut kinds = BTreeMap::new();
    for certificate in verdicts.iter().flat_map(|(_, verdict, _)| verdict.certificates()) {
        let text = certificate.to_string();
        let kind = text.lines().take(2).collect::<Vec<_>>().join(", ");
        *kinds.entry(kind).or_insert(0) += 1;
    }
    kinds
}

fn judged(nets: Vec<Net>) -> Vec<Judged> {
    let judge = |net: Net| {
        let (verdict, truth) = confirmed(&net);
        confirm_bounds(&net, &verdict);
        (net, verdict, truth)
    };
    nets.into_iter().map(judge).collect()
}

fn expect_kinds(verdicts: &[Judged], expected: &[(&str, usize)]) {
    let kinds = kinds(verdicts);
    for &(kind, at_least) in expected {
        let found = kinds.get(kind).copied().unwrap_or(0);
        assert!(found >= at_least, "`{kind}` {found} times\n{kinds:#?}");
    }
}

#[test]
fn marked_graphs_are_decided_completely() {
    let nets = [samples(marked_graph(), 1500), samples(connected_marked_graph(), 800)].concat();
    let verdicts = judged(nets);
    for (net, verdict, _) in &verdicts {
        assert!(
            NetProperty::ALL.into_iter().all(|property| verdict.answer(property).holds().is_some()),
            "{net}{verdict}"
        );
        assert!(verdict.bounds.iter().all(|bound| matches!(bound, TokenBound::Exactly(_) | TokenBound::Unbounded)));
    }
    expect_kinds(
        &verdicts,
        &[
            ("claim: live yes, evidence: order", 300),
            ("claim: live no, evidence: dead", 300),
            ("claim: deadlock-free yes, evidence: order", 300),
            ("claim: deadlock-free no, evidence: deadlock", 300),
            ("claim: bounded yes, evidence: sums", 300),
            ("claim: bounded no, evidence: pump", 100),
            ("claim: safe yes, evidence: sums", 100),
            ("claim: safe no, evidence: overfull", 300),
            ("claim: reversible yes, evidence: order", 300),
            ("claim: reversible no, evidence: no-return", 100),
        ],
    );
}

#[test]
fn state_machines_are_decided_completely() {
    let verdicts = judged(
        [samples(crate::common::any_state_machine(), 2000), samples(crate::common::connected_state_machine(), 300)]
            .concat(),
    );
    for (net, verdict, _) in &verdicts {
        assert!(
            NetProperty::ALL.into_iter().all(|property| verdict.answer(property).holds().is_some()),
            "{net}{verdict}"
        );
        assert!(verdict.bounds.iter().all(|bound| matches!(bound, TokenBound::Exactly(_))));
    }
    expect_kinds(
        &verdicts,
        &[
            ("claim: live yes, evidence: components", 30),
            ("claim: live no, evidence: dead", 300),
            ("claim: deadlock-free yes, evidence: trap", 300),
            ("claim: deadlock-free no, evidence: deadlock", 300),
            ("claim: safe yes, evidence: sums", 300),
            ("claim: safe no, evidence: overfull", 300),
            ("claim: reversible yes, evidence: components", 300),
            ("claim: reversible no, evidence: no-return", 300),
        ],
    );
}

#[test]
fn free_choice_nets_are_decided_when_live_and_bounded() {
    let verdicts = judged(samples(free_choice_net(), 1500));
    for (net, verdict, truth) in &verdicts {
        if truth.get(&NetProperty::Live) == Some(&true) && net.is_strongly_connected().is_ok() {
            assert_eq!(verdict.live.holds(), Some(true), "{net}{verdict}");
            assert_eq!(verdict.reversible.holds(), truth.get(&NetProperty::Reversible).copied(), "{net}{verdict}");
            assert_eq!(verdict.safe.holds(), truth.get(&NetProperty::Safe).copied(), "{net}{verdict}");
        }
        // What is not live and has few markings is shown not to be.
        if truth.get(&NetProperty::Live) == Some(&false) {
            assert_eq!(verdict.live.holds(), Some(false), "{net}{verdict}");
        }
    }
    expect_kinds(
        &verdicts,
        &[
            ("claim: live yes, evidence: well-formed", 100),
            ("claim: live no, evidence: dead", 100),
            ("claim: reversible yes, evidence: well-formed", 100),
            ("claim: reversible no, evidence: unmarked-trap", 3),
            ("claim: safe yes, evidence: sums", 30),
            ("claim: safe no, evidence: overfull", 100),
        ],
    );
}

#[test]
fn other_nets_get_no_wrong_answer() {
    let verdicts = judged(samples(crate::common::any_net(), 1200));
    expect_kinds(&verdicts, &[("claim: live no, evidence: dead", 100), ("claim: bounded yes, evidence: sums", 50)]);
    let nets = samples(crate::common::weighed_net(), 500).into_iter().map(|(net, _)| net).collect();
    expect_kinds(&judged(nets), &[("claim: bounded yes, evidence: sums", 400)]);
}

/// One word of a certificate changed, left out or repeated, or a number in it moved a little.
fn tampered(text: &str, (line, word, how): (usize, usize, usize)) -> String {
    let mut lines: Vec<Vec<String>> =
        text.lines().map(|line| line.split_whitespace().map(str::to_owned).collect()).collect();
    let at = line % lines.len();
    let words = &mut lines[at];
    let chosen = 1 + word % words.len().saturating_sub(1).max(1);
    if at == 0 && how % 2 == 0 {
        words[2] = if words[2] == "yes" { "no" } else { "yes" }.to_owned();
    } else if at == 0 {
        words[1] = NetProperty::ALL[word % NetProperty::ALL.len()].to_string();
    } else if chosen < words.len() {
        match how % 4 {
            0 => _ = words.remove(chosen),
            1 => words.push(words[chosen].clone()),
            2 => words.swap(chosen, 1),
            _ => {
                let head = words[chosen].trim_end_matches(|c: char| c.is_ascii_digit()).len();
                let number: i64 = words[chosen][head..].parse().unwrap_or(0);
                let moved = [number + 1, (number - 1).max(0), 0, number + 2][how / 4 % 4];
                words[chosen] = format!("{}{moved}", &words[chosen][..head]);
            }
        }
    } else {
        let copy = lines[at].clone();
        lines.insert(at, copy);
    }
    lines.iter().map(|words| words.join(" ") + "\n").collect()
}

/// The same net with other tokens.
fn remarked(net: &Net, tokens: &[u32]) -> Net {
    let moves: Vec<crate::common::Moves> = net
        .transitions()
        .map(|t| {
            let side = |arcs: &[(linewright_nets::PlaceId, u32)]| arcs.iter().map(|&(p, n)| (p.index(), n)).collect();
            (side(net.preset(t)), side(net.postset(t)))
        })
        .collect();
    crate::common::net(&tokens[..net.place_count()], &moves)
}

#[test]
fn tampered_certificates_prove_nothing_false() {
    let nets = [
        samples(marked_graph(), 250),
        samples(connected_marked_graph(), 150),
        samples(crate::common::any_state_machine(), 250),
        samples(free_choice_net(), 250),
        samples(crate::common::any_net(), 100),
    ]
    .concat();
    let mut runner = TestRunner::deterministic();
    let choice = (0_usize..50, 0_usize..50, 0_usize..64);
    let marks = prop::collection::vec(0_u32..=2, 20);
    let (mut tried, mut refused, mut still_true) = (0, 0, 0);
    for net in nets {
        let verdict = decide_by_structure(&net);
        let truth = truth(&net);
        let other = remarked(&net, &marks.new_tree(&mut runner).unwrap().current());
        let other_truth = self::truth(&other);
        for certificate in verdict.certificates() {
            let text = certificate.to_string();
            for _ in 0..15 {
                let changed = tampered(&text, choice.new_tree(&mut runner).unwrap().current());
                let Ok(changed) = Certificate::parse(&changed) else { continue };
                if changed == *certificate {
                    continue;
                }
                tried += 1;
                if check(&net, &changed).is_ok() {
                    still_true += 1;
                    let holds = truth.get(&changed.property).copied().unwrap_or(changed.holds);
                    assert_eq!(holds, changed.holds, "{net}{changed}");
                } else {
                    refused += 1;
                }
            }
            if check(&other, certificate).is_ok() {
                let holds = other_truth.get(&certificate.property).copied().unwrap_or(certificate.holds);
                assert_eq!(holds, certificate.holds, "{other}{certificate}");
            }
        }
    }
    assert!(tried > 12_000 && refused > tried / 2 && still_true > 0, "{tried} {refused} {still_true}");
}

#[test]
fn a_certificate_with_a_detail_missing_is_refused() {
    let net = ring(4, false);
    let verdict = decide_by_structure(&net);
    let rejected = |certificate: &Certificate| check(&net, certificate).unwrap_err().rule;

    let mut live = verdict.live.certificate().unwrap().clone();
    let Evidence::Order(order) = &mut live.evidence else { panic!("{live}") };
    order.transitions.reverse();
    assert_eq!(rejected(&live), CertificateRule::Rising);
    let Evidence::Order(order) = &mut live.evidence else { panic!("{live}") };
    order.transitions.reverse();
    order.transitions.pop();
    assert!(matches!(rejected(&live), CertificateRule::AllTransitions | CertificateRule::Closed));

    let safe = verdict.safe.certificate().unwrap();
    for (i, _) in net.places().enumerate() {
        let mut safe = safe.clone();
        let Evidence::Sums(sums) = &mut safe.evidence else { panic!("{safe}") };
        sums.bounds[i].1 = 0;
        assert_eq!(rejected(&safe), CertificateRule::Bound);
    }
    let mut safe = safe.clone();
    let Evidence::Sums(sums) = &mut safe.evidence else { panic!("{safe}") };
    sums.sums[0].pop();
    assert!(matches!(rejected(&safe), CertificateRule::Monotone | CertificateRule::Bound));

    // The certificate of the ring with parts proves nothing about the ring without.
    let dead = ring(4, true);
    assert_eq!(check(&dead, verdict.live.certificate().unwrap()).unwrap_err().rule, CertificateRule::Rising);
}

#[test]
fn a_ring_of_a_hundred_stations_is_decided() {
    let net = ring(100, false);
    let verdict = decide_by_structure(&net);
    assert!(NetProperty::ALL.into_iter().all(|property| verdict.answer(property).holds() == Some(true)), "{verdict}");
    assert!(verdict.bounds.iter().all(|&bound| bound == TokenBound::Exactly(1)));
    for certificate in verdict.certificates() {
        assert_eq!(check(&net, certificate), Ok(()));
        assert_eq!(Certificate::parse(&certificate.to_string()).as_ref(), Ok(certificate));
    }
    let net = ring(100, true);
    let verdict = decide_by_structure(&net);
    assert_eq!((verdict.live.holds(), verdict.deadlock_free.holds()), (Some(false), Some(false)));
    verdict.certificates().for_each(|certificate| assert_eq!(check(&net, certificate), Ok(())));
}

#[test]
fn a_small_ring_is_what_exploration_finds() {
    for empty in [false, true] {
        let (verdict, truth) = confirmed(&ring(2, empty));
        assert_eq!(truth.len(), NetProperty::ALL.len());
        assert_eq!(verdict.live.holds(), Some(!empty));
        assert_eq!(verdict.to_string().lines().count(), 6);
    }
}

#[test]
fn why_nothing_is_claimed_is_said() {
    // A live free-choice net that is not bounded: a customer chooses, and one of the choices leaves something behind.
    let mut b = NetBuilder::new("shop");
    let [ready, left] = [("ready", 1), ("left", 0)].map(|(name, n)| b.place(name, n));
    let [buy, ask, tidy] = ["buy", "ask", "tidy"].map(|name| b.transition(name));
    b.input(buy, ready, 1).output(buy, ready, 1).output(buy, left, 1);
    b.input(ask, ready, 1).output(ask, ready, 1);
    b.input(tidy, left, 1);
    let net = b.build().unwrap();
    let (verdict, _) = confirmed(&net);
    assert_eq!(verdict.live, CertificateAnswer::Unknown(Unknown::Uncertified));
    assert_eq!(verdict.bounded, CertificateAnswer::Unknown(Unknown::Uncovered));
    assert!(verdict.to_string().contains("bounded: unknown: a place is in no conserved sum"), "{verdict}");
}
