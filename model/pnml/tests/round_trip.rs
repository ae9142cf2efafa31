//! A written net is read back equal, whatever the names are; and a ring of stations written by a program.

use linewright_nets::{Net, NetBuilder, explore};
use linewright_pnml::write;
use proptest::collection::{btree_set, hash_set, vec};
use proptest::prelude::*;

use crate::common::{ring, sound};

/// Names that are as they may be: with blanks, markup, line ends and letters of any kind, but not empty, and without the
/// characters that XML has no way to write.
fn name() -> impl Strategy<Value = String> {
    let allowed = |c: &char| (*c >= ' ' || matches!(c, '\t' | '\n' | '\r')) && !matches!(c, '\u{FFFE}' | '\u{FFFF}');
    let tricky = prop::sample::select(vec![
        " ", "\t", "\n", "\r\n", "\r", "&", "&amp;", "<", ">", "]]>", "<!--", "\"", "'", "p0", "t0", "é", "\u{85}",
        "\u{2028}", "\u{A0}",
    ]);
    prop_oneof![
        4 => vec(prop_oneof![tricky.prop_map(str::to_owned), "[a-z0-9_ ]{1,5}"], 1..4).prop_map(|parts| parts.concat()),
        1 => vec(any::<char>().prop_filter("XML", allowed), 1..6).prop_map(|chars| chars.into_iter().collect()),
    ]
}

/// An arc as (transition, place, whether into the transition).
fn net() -> impl Strategy<Value = Net> {
    let weight = || prop_oneof![3 => Just(1), 1 => 1..=5_u32, 1 => Just(u32::MAX)];
    (name(), hash_set(name(), 0..6), hash_set(name(), 0..6))
        .prop_filter("a net has a node", |(_, places, transitions)| places.len() + transitions.len() > 0)
        .prop_flat_map(move |(name, places, transitions)| {
            let (p, t) = (places.len().max(1), transitions.len().max(1));
            let tokens = vec(prop_oneof![2 => Just(0), 1 => 0..=9_u32, 1 => Just(u32::MAX)], places.len());
            let most = if places.is_empty() || transitions.is_empty() { 0 } else { 12 };
            let arcs = btree_set((0..t, 0..p, any::<bool>()), 0..=most);
            (Just(name), Just(places), tokens, Just(transitions), arcs, vec(weight(), 12))
        })
        .prop_map(|(name, places, tokens, transitions, arcs, weights)| {
            let mut b = NetBuilder::new(name);
            let places: Vec<_> = places.into_iter().zip(tokens).map(|(name, n)| b.place(name, n)).collect();
            let transitions: Vec<_> = transitions.into_iter().map(|name| b.transition(name)).collect();
            for ((t, p, is_input), weight) in arcs.into_iter().zip(weights) {
                match is_input {
                    true => b.input(transitions[t], places[p], weight),
                    false => b.output(transitions[t], places[p], weight),
                };
            }
            b.build().expect("generated nets are sound")
        })
}

/// The text of a net is complete: names, marking, and every arc with its weight.
fn assert_same(a: &Net, b: &Net) {
    assert_eq!(a.to_string(), b.to_string());
    assert_eq!(a.initial_marking(), b.initial_marking());
    for t in a.transitions() {
        assert_eq!((a.preset(t), a.postset(t)), (b.preset(t), b.postset(t)));
    }
    for p in a.places() {
        assert_eq!(a.place_named(a.place_name(p)), b.place_named(b.place_name(p)));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_is_read_as_it_was(net in net()) {
        let text = write(&net);
        let again = sound(&text);
        assert_same(&net, &again);
        prop_assert_eq!(write(&again), text);
    }
}

#[test]
fn a_written_net_looks_like_the_standard_says() {
    let mut b = NetBuilder::new("A & B");
    let (bolts, part) = (b.place("bolts", 4), b.place("part < 1", 0));
    let screw = b.transition("screw\nin ");
    b.input(screw, bolts, 4).output(screw, part, 1);
    let expected = r#"<?xml version="1.0" encoding="UTF-8"?>
<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml">
  <net id="net" type="http://www.pnml.org/version-2009/grammar/ptnet">
    <name><text>A &amp; B</text></name>
    <page id="page">
      <place id="p0"><name><text>bolts</text></name><initialMarking><text>4</text></initialMarking></place>
      <place id="p1"><name><text>part &lt; 1</text></name></place>
      <transition id="t0"><name><text>screw&#10;in&#32;</text></name></transition>
      <arc id="a0" source="p0" target="t0"><inscription><text>4</text></inscription></arc>
      <arc id="a1" source="t0" target="p1"/>
    </page>
  </net>
</pnml>
"#;
    assert_eq!(write(&b.build().unwrap()), expected);
}

#[test]
fn what_xml_cannot_write_is_replaced_and_an_empty_name_becomes_the_id() {
    let mut b = NetBuilder::new("");
    b.place("ring\u{7}", 0);
    b.place("", 0);
    b.transition("p1");
    let net = sound(&write(&b.build().unwrap()));
    let names: Vec<_> = net.places().map(|p| net.place_name(p)).collect();
    assert_eq!((net.name(), names, net.transitions().len()), ("net", vec!["ring\u{FFFD}", "p1"], 1));
}

#[test]
fn a_ring_of_three_stations_has_its_states() {
    let net = sound(&ring(3));
    assert_eq!((net.name(), net.place_count(), net.transition_count()), ("ring", 42, 36));
    let reached = explore(&net, 10_000).expect("it is small");
    assert_eq!(reached.deadlocks().count(), 0);
    assert!(reached.is_live() && reached.is_safe() && reached.is_reversible().is_ok());
    assert_eq!(reached.states().len(), RING_3_STATES);
    assert_same(&net, &sound(&write(&net)));
}

/// Counted by an independent program, on bit masks.
const RING_3_STATES: usize = 3444;
