//! Refusals: all reported at once, in words with advice.

use linewright_nets::coloured::{
    BasicId, ColouredBuilder, Comparison, Domain, Function, Guard, Operand, abs, colour, compare, component, id, proj,
    ring, succ,
};
use linewright_nets::{PlaceId, TransitionId};

fn messages(b: ColouredBuilder) -> Vec<String> {
    b.build().unwrap_err().iter().map(ToString::to_string).collect()
}

#[test]
fn every_problem_is_reported_at_once() {
    let mut b = ColouredBuilder::new("bad");
    let a = b.basic("A", 2);
    let none = b.basic("N", 0);
    let d = b.named_basic("A", ["x", "x", "a,b", ""]);
    let p = b.place("p", a);
    let q = b.place("q", [a, d]);
    b.place("p", BasicId(9));
    b.place("empty", none);
    b.place("p<1>", Domain::Uncoloured);
    let t = b.transition("t", [a, d]);
    b.transition("t", BasicId(7));
    b.input(t, p, id()).output(t, q, proj([3])).input(t, q, id() - id()).output(t, p, proj([1]) + id());
    b.input(t, PlaceId(40), abs()).output(TransitionId(41), p, abs());
    b.guard(t, Guard::all([colour(3, 1), colour(1, 3)])).guard(TransitionId(8), Guard::all([]));
    b.tokens(p, &[3], 1).tokens(p, &[1, 1], 1).tokens(PlaceId(50), &[], 1).tokens(q, &[2, 5], 2);
    assert_eq!(
        messages(b),
        [
            "two colour domains are named `A`",
            "colour domain `N` has no tone; a domain is not empty",
            "colour domain `A` has two tones named `x`",
            "colour domain `A` has a tone named `a,b`; the name of a tone is not empty and has none of `<>,`",
            "colour domain `A` has a tone named ``; the name of a tone is not empty and has none of `<>,`",
            "two places are named `p`",
            "two transitions are named `t`",
            "place `p<1>` has a name that ends in `>`, which is how unfolded colours are named; choose another",
            "place `p` is of colour domain #9, but the net has 3 basic domains",
            "transition `t` is of colour domain #7, but the net has 3 basic domains",
            "the arc place `p` → transition `t` has the function `id`, which gives colours of A*A; the place is of A",
            "the arc place `q` → transition `t` has the function `id + -id` with a total weight of 0 in one term; \
             1 to 4294967295 are possible",
            "the arc place `#40` → transition `t` names place #40, but the net has 5 places",
            "the arc transition `t` → place `p` has the function `proj(1) + id`: the sum adds colours of A and of A*A",
            "the arc transition `t` → place `q` has the function `proj(3)`: \
             `proj(3)` names component 3, but what it is applied to is of A*A",
            "the arc transition `#41` → place `p` names transition #41, but the net has 2 transitions",
            "the guard of transition `t` names component 3; the transition is of A*A",
            "the guard of transition `t` names colour 3 of component 1, which has 1 to 2",
            "a guard names transition #8, but the net has 2 transitions",
            "a token <3> is put on place `p`: component 1 has the tones 1 to 2",
            "a token <1,1> is put on place `p`, which is of A",
            "a token <> names place #50, but the net has 5 places",
            "a token <2,5> is put on place `q`: component 2 has the tones 1 to 4",
        ]
        .map(|message| message.replace("token <> names", "token <•> names"))
    );
}

#[test]
fn weights_and_tokens_are_counted() {
    let build = |function: Function| {
        let mut b = ColouredBuilder::new("weights");
        let a = b.basic("A", 3);
        let (p, t) = (b.place("p", a), b.transition("t", a));
        b.input(t, p, function);
        b
    };
    assert!(build((1 << 32) * id()).build().is_err());
    assert!(build(((1 << 32) - 1) * id()).build().is_ok());
    assert!(build(((1 << 32) - 1) * id() + succ(1, 1)).build().is_err());
    assert!(build(id() - succ(1, 1)).build().is_err());
    assert!(build(2 * id() - id()).build().is_ok());
    assert!(build(ring(1) - id() - succ(1, 2)).build().is_ok(), "succ(1) is left");
    let mut b = build(id());
    b.tokens(PlaceId(0), &[2], u32::MAX).tokens(PlaceId(0), &[2], 1);
    assert_eq!(messages(b), ["place `p` starts with more tokens of one colour than can be counted"]);
}

#[test]
fn sizes_are_bounded() {
    let mut b = ColouredBuilder::new("wide");
    let a = b.basic("A", 1 << 12);
    let p = b.place("p", [a, a]);
    b.place("q", [a, a, a]);
    b.place("r", vec![a; 65]);
    let t = b.transition("t", [a, a, a]);
    b.input(t, p, proj([1, 3]));
    assert_eq!(
        messages(b),
        [
            "place `q` has more colours than can be numbered",
            "place `r` has a domain with 65 components; at most 64 are possible",
            "transition `t` has more than 16777216 modes; let it use fewer components",
        ]
    );
    let mut b = ColouredBuilder::new("many");
    let a = b.basic("A", 1 << 31);
    (0..2).for_each(|i| _ = b.place(format!("p{i}"), a));
    assert_eq!(
        messages(b),
        ["the places of the net together have more colours than can be numbered, from place `p1` on"]
    );
    assert_eq!(messages(ColouredBuilder::new("none")), ["the net has neither a place nor a transition"]);
}

#[test]
fn guards_are_single_and_not_empty() {
    let mut b = ColouredBuilder::new("guards");
    let a = b.basic("A", 3);
    let t = b.transition("t", a);
    b.guard(t, Guard::all([])).guard(t, Guard::any::<linewright_nets::coloured::Clause>([]));
    assert_eq!(
        messages(b),
        [
            "the guard of transition `t` has no clause, so the transition could never fire",
            "transition `t` has two guards; write one, with the clauses of both",
        ]
    );
}

/// A domain of very many basic domains is fine as long as a transition uses few of them.
#[test]
fn the_universal_domain_is_restricted_to_what_is_used() {
    let mut b = ColouredBuilder::new("universal");
    let basics: Vec<_> = (0..100).map(|i| b.basic(format!("B{i}"), 100)).collect();
    let (p, q) = (b.place("p", [basics[70], basics[3]]), b.place("q", basics[70]));
    let t = b.transition("t", Domain::Universal);
    b.tokens(p, &[7, 9], 1);
    b.input(t, p, proj([71, 4])).output(t, q, proj([71]).of(succ(71, 95)));
    b.guard(t, Guard::all([compare(component(100), Comparison::Less, Operand::Number(3))]));
    let net = b.build().unwrap();
    assert_eq!(net.transition_domain(t), [basics[3], basics[70], basics[99]]);
    let enabled: Vec<_> = net.enabled(&net.initial_marking()).iter().map(|&mode| net.mode_name(mode)).collect();
    assert_eq!(enabled, ["t<9,7,1>", "t<9,7,2>"]);
    let mut marking = net.initial_marking();
    net.fire(&mut marking, net.mode_named("t<9,7,2>").unwrap()).unwrap();
    assert_eq!(net.describe(&marking), "q<2>");
    let refused = net.fire(&mut marking, net.mode(t, &[9, 7, 3]).unwrap()).unwrap_err();
    assert_eq!(refused.to_string(), "t<9,7,3> cannot fire: its guard excludes this colour");
    assert_eq!((net.mode(t, &[9, 7]), net.mode(t, &[9, 7, 101]), net.mode_named("t<9,x,3>")), (None, None, None));
}
