//! The fixture of the grammar for coloured nets, seed 000, Figs. 73 and 75, L3524-3634.
//!
//! Printed: domains, places with `maxtoken`, which places t1 and t2 join, the marking, and both guards. The arc functions
//! (Fig. 74) are lost; those here are the only standard functions between the domains that keep components apart.

use linewright_nets::coloured::decide::{ClauseId, Decisions};
use linewright_nets::coloured::{
    Clause, ColouredBuilder, ColouredError, ColouredNet, Colours, Comparison, Domain, Guard, abs, colour, compare,
    component, explore, id, proj, unfold,
};

use super::{mode, names};

fn written(p2_token: [u32; 2]) -> ColouredBuilder {
    let mut b = ColouredBuilder::new("Fig. 73");
    let [a, _, c] = [("A", 10), ("B", 13), ("C", 30)].map(|(name, size)| b.basic(name, size));
    let p1 = b.place("p1", a);
    let p2 = b.place("p2", [a, c]); // E = A*C
    let p3 = b.place("p3", Domain::Universal);
    let p4 = b.place("p4", Domain::Uncoloured);
    let p5 = b.place("p5", Domain::Universal);
    for (place, most) in [(p1, 2), (p2, 20), (p3, 20), (p4, 13), (p5, 22)] {
        b.max_tokens(place, most);
    }
    // place p1 = (1) + (2); p2 = (4,2); p3 = (1,2,1) + 4*(2,2,2); p4 = discolored (5)
    b.tokens(p1, &[1], 1).tokens(p1, &[2], 1).tokens(p2, &p2_token, 1);
    b.tokens(p3, &[1, 2, 1], 1).tokens(p3, &[2, 2, 2], 4).tokens(p4, &[], 5);
    let (t1, t2) = (b.transition("t1", Domain::Universal), b.transition("t2", Domain::Universal));
    b.input(t1, p3, id()).output(t1, p5, id());
    b.input(t2, p2, proj([1, 3])).input(t2, p3, id()).input(t2, p4, abs());
    b.output(t2, p1, proj([1])).output(t2, p5, id());
    // guard t1 = proj(2)=10 or proj(2)=proj(3)#succ(3)
    let next = compare(component(2), Comparison::Equal, component(3).succ(1));
    b.guard(t1, Guard::any([[colour(2, 10)], [next]]));
    // guard t2 = scheduled and proj(2)=1 or scheduled and proj(2)=2 or proj(2)=3
    let scheduled = |tone| Clause::all([colour(2, tone)]).scheduled();
    b.guard(t2, Guard::any([scheduled(1), scheduled(2), Clause::all([colour(2, 3)])]));
    b
}

fn fixture() -> ColouredNet {
    written([4, 2]).build().unwrap()
}

#[test]
fn the_fixture_is_as_printed() {
    let net = fixture();
    let expected = "\
coloured net Fig. 73: places 5, transitions 2, tokens 13
  colours A = 1..10
  colours B = 1..13
  colours C = 1..30
  place p1 of A = <1> + <2>
  place p2 of A*C = <4,2>
  place p3 of A*B*C = <1,2,1> + 4*<2,2,2>
  place p4 of <•> = 5*<•>
  place p5 of A*B*C = 0
  transition t1 of A*B*C: p3 <1,2,3> → p5 <1,2,3>
    if <2> = 10 or <2> = <3+1>
  transition t2 of A*B*C: p2 <1,3>, p3 <1,2,3>, p4 <•> → p1 <1>, p5 <1,2,3>
    if scheduled and <2> = 1 or scheduled and <2> = 2 or <2> = 3
";
    assert_eq!(net.to_string(), expected);
    assert_eq!((net.max_tokens(net.place_named("p4").unwrap()), net.cell_count()), (Some(13), 10 + 300 + 2 * 3900 + 1));
}

/// Of the tokens on p3, (1,2,1) satisfies proj(2) = proj(3)#succ(3), and (2,2,2) does not. t2 lacks a token on p2.
#[test]
fn the_printed_marking_enables_one_mode() {
    let net = fixture();
    assert_eq!(names(&net, net.enabled(&net.initial_marking())), ["t1<1,2,1>"]);
    let reached = explore(&net, 100).unwrap();
    assert_eq!((reached.states().len(), reached.over_capacity(&net).len()), (2, 0));
    let small = unfold(&net, Colours::Reachable, 100).unwrap();
    assert_eq!((small.net().place_count(), small.net().transition_count()), (2 + 1 + 2 + 1 + 1, 1));
}

/// L3590-3604: of the modes of t2, those of tones 1 and 2 wait for the scheduler, those of tone 3 do not.
#[test]
fn scheduled_clauses_wait_and_the_others_do_not() {
    let net = fixture();
    let t2 = net.transition_named("t2").unwrap();
    let second = Decisions::these([ClauseId { transition: t2, clause: 1 }]);
    let permitted = |name, decisions: &Decisions| net.permits(mode(&net, name), decisions);
    assert_eq!(
        ["t2<4,1,2>", "t2<4,2,2>", "t2<4,3,2>", "t2<4,4,2>"].map(|m| permitted(m, &second)),
        [false, true, true, false]
    );
    assert_eq!(["t2<4,2,2>", "t2<4,3,2>"].map(|m| permitted(m, &Decisions::none())), [false, true]);
    assert!(net.guard_allows(mode(&net, "t2<4,1,2>")) && !net.guard_allows(mode(&net, "t2<4,4,2>")));

    // With a token that t2 can use, it takes from p2, p3 and p4 and fills p1 beyond its two tokens.
    let net = written([2, 2]).build().unwrap();
    let enabled = net.enabled(&net.initial_marking());
    assert_eq!(names(&net, enabled), ["t1<1,2,1>", "t2<2,2,2>"]);
    assert_eq!(names(&net, net.enabled_under(&net.initial_marking(), &Decisions::none())), ["t1<1,2,1>"]);
    let reached = explore(&net, 100).unwrap();
    let over: Vec<_> = reached.over_capacity(&net).iter().map(|(place, most)| format!("{place} {most}")).collect();
    assert_eq!(over, ["place `p1` 3"]);
}

/// All 3900 colours of Ω*: t1 has 10·30 modes with B = 10, and 10·13 with B next after C, of which 10 are both; t2 has
/// 10·3·30.
#[test]
fn the_whole_unfolding_has_the_modes_that_the_guards_leave() {
    let net = fixture();
    let modes = |name| net.modes(net.transition_named(name).unwrap()).count();
    assert_eq!((modes("t1"), modes("t2")), (10 * 30 + 10 * 13 - 10, 10 * 3 * 30));
    let all = unfold(&net, Colours::All, 10_000).unwrap();
    assert_eq!((all.net().place_count(), all.net().transition_count()), (8111, 420 + 900));
    assert!(all.net().place_named("p3<10,13,30>").is_some() && all.net().place_named("p4").is_some());
    assert_eq!(
        unfold(&net, Colours::All, 9430).unwrap_err().to_string(),
        "the unfolding has more than 9430 places and transitions"
    );
    assert!(unfold(&net, Colours::All, 9431).is_ok());
}

/// `maxtoken` holds for the marking that is written down.
#[test]
fn a_place_that_starts_too_full_is_refused() {
    let mut b = written([4, 2]);
    b.tokens(linewright_nets::PlaceId(0), &[1], 1);
    let problems = b.build().unwrap_err();
    assert!(matches!(problems[..], [ColouredError::OverCapacity { tokens: 3, most: 2, .. }]), "{problems:?}");
}
