//! Ill-formed systems and compositions are refused with all errors, by name.

use linewright_nets::tnces::{
    ComposeError, Composite, EventMode, Interval, Policy, Semantics, TncesBuilder, TncesError, TncesModule,
    TncesPlayer, parts,
};
use linewright_nets::{NetBuilder, PlaceId, TransitionId};

#[test]
fn every_problem_of_the_tables_is_reported_at_once() {
    let mut b = NetBuilder::new("bad");
    let [p, q] = ["p", "q"].map(|name| b.place(name, 1));
    let [a, c, d, e] = ["a", "c", "d", "e"].map(|name| b.transition(name));
    b.input(a, p, 1).input(d, p, 1);
    let mut b = TncesBuilder::new(b.build().unwrap());
    b.condition(a, PlaceId(9), 1).condition(TransitionId(7), p, 1).condition(c, q, 0);
    b.condition(d, q, 1).condition(d, q, 2);
    b.interval(a, p, Interval::between(5, 2)).interval(a, q, Interval::at_least(1));
    b.interval(d, p, Interval::at_least(u32::MAX));
    b.event(a, c).event(c, d).event(d, c).event(a, e).event(a, e).event_of(vec![], a);
    b.external(e);
    let problems: Vec<String> = b.build().unwrap_err().iter().map(ToString::to_string).collect();
    assert_eq!(
        problems,
        [
            "a condition arc names place #9, but the net has 2 places",
            "a condition arc names transition #7, but the net has 4 transitions",
            "the condition arc place `q` → transition `c` has weight 0",
            "the condition arc place `q` → transition `d` is declared 2 times",
            "the interval [5, 2] on place `p` → transition `a` ends before it begins",
            "the interval [1, ∞) is on place `q` → transition `a`, which is no arc of the net",
            "the interval [4294967295, ∞) on place `p` → transition `d` goes beyond 1073741824; \
             choose a coarser unit of time",
            "transition `a` waits for one event of none; name its sources",
            "the event arc transition `a` → transition `e` is declared 2 times",
            "transition `e` is external, but event arcs force it; leave one of the two out",
            "the event arcs form a cycle: transition `c` → transition `d`",
        ]
    );
}

#[test]
fn a_transition_that_calls_itself_is_a_cycle() {
    let mut b = NetBuilder::new("self");
    let t = b.transition("t");
    let mut b = TncesBuilder::new(b.build().unwrap());
    b.event(t, t);
    assert_eq!(b.build().unwrap_err()[0].to_string(), "the event arcs form a cycle: transition `t`");
}

#[test]
fn more_choices_than_can_be_listed_are_refused() {
    let mut b = NetBuilder::new("crowd");
    let p = b.place("p", 1);
    let go = b.transition("go");
    let crowd: Vec<_> = (0..13).map(|i| b.transition(format!("t{i}"))).collect();
    crowd.iter().for_each(|&t| _ = b.input(t, p, 1));
    let mut b = TncesBuilder::new(b.build().unwrap());
    crowd.iter().for_each(|&t| _ = b.event(go, t));
    let problems = b.build().unwrap_err();
    assert!(matches!(&problems[..], [TncesError::TooManyChoices { contested: 13, .. }]), "{problems:?}");
}

#[test]
fn every_problem_of_a_composition_is_reported_at_once() {
    let mut line = Composite::new("line");
    line.condition_in("door").event_out("done");
    let (sensor, copy) = (line.add(parts::output("sensor", false)), line.add(parts::input("copy", false)));
    let update = line.add(parts::update("update", 100));
    line.add(parts::switch("sensor", true));
    line.condition((sensor, "on"), (copy, "x")).condition((sensor, "off"), (copy, "x"));
    line.event((sensor, "changed"), (update, "event")).event((sensor, "changed"), (update, "event"));
    line.event((update, "finished"), (copy, "update"));
    line.event((linewright_nets::tnces::ComponentId(8), "changed"), (sensor, "set"));
    let problems: Vec<String> =
        line.flatten(Semantics::default()).unwrap_err().iter().map(ToString::to_string).collect();
    assert_eq!(
        problems,
        [
            "condition input `line.door` is not connected",
            "two parts of `line` are named `sensor`",
            "`update` has no event output `finished`",
            "a connection in `line` names part #8, but it has 4 parts",
            "condition input `copy.x` has 2 sources: `sensor.on`, `sensor.off`",
            "event input `update.event` has 2 sources: `sensor.changed`, `sensor.changed`",
            "event input `sensor.set` is not connected",
            "event input `sensor.reset` is not connected",
            "condition input `copy.not_x` is not connected",
            "event input `copy.update` is not connected",
            "event output `line.done` is not connected",
            "condition input `line.door` is an input, but no arc starts at it",
        ]
    );
}

#[test]
fn modules_are_checked_too() {
    let mut m = TncesModule::new("m");
    let p = m.place("p", 1);
    let t = m.transition("t");
    m.output(t, PlaceId(5), 1).condition_in("unused");
    m.event_out("e", [TransitionId(3)]).event_out("e", [t]);
    let mut line = Composite::new("line");
    let m = line.add(m);
    let other = line.add(parts::switch("switch", false));
    line.condition((other, "on"), (m, "unused"));
    let problems: Vec<String> =
        line.flatten(Semantics::default()).unwrap_err().iter().map(ToString::to_string).collect();
    assert_eq!(
        problems,
        [
            "`m` has two event outputs named `e`",
            "condition input `m.unused` is an input, but no arc starts at it",
            "module `m` has 1 places, but one of its arcs or ports names #5",
            "module `m` has 1 transitions, but one of its arcs or ports names #3",
        ]
    );
    assert_eq!(p, PlaceId(0));

    let mut through = Composite::new("through");
    through.event_in("a").event_out("b").event("a", "b");
    let problems = through.flatten(Semantics::default()).unwrap_err();
    assert!(problems.iter().any(|p| matches!(p, ComposeError::PassThrough { .. })), "{problems:?}");
}

#[test]
fn an_event_cycle_through_ports_is_found() {
    let mut line = Composite::new("line");
    let (a, b) = (line.add(parts::output("a", false)), line.add(parts::output("b", false)));
    for (from, to) in [(a, b), (b, a)] {
        line.event((from, "was_set"), (to, "set")).event((from, "was_reset"), (to, "reset"));
    }
    let problems = line.flatten(Semantics::default()).unwrap_err();
    assert_eq!(problems[0].to_string(), "the event arcs form a cycle: transition `a.set` → transition `b.set`");
}

/// Parts within parts: what goes through a composite's ports is what a direct connection would be.
#[test]
fn a_hierarchy_flattens_to_the_same_steps() {
    let mut inner = Composite::new("inner");
    inner.event_in("tick").condition_in("x").condition_in("not_x").condition_out("seen").event_out("news");
    let copy = inner.add(parts::input("copy", false));
    inner.event("tick", (copy, "update")).condition("x", (copy, "x")).condition("not_x", (copy, "not_x"));
    inner.condition((copy, "on"), "seen").event((copy, "changed"), "news");

    let mut lamp = TncesModule::new("lamp");
    let [dark, lit] = [("dark", 1), ("lit", 0)].map(|(name, n)| lamp.place(name, n));
    let on = lamp.change("on", dark, lit, Interval::ANY);
    let (news, seen) = (lamp.event_in("news"), lamp.condition_in("was_seen"));
    lamp.on(news, on).only_if(seen, on);

    let mut line = Composite::new("line");
    let switch = line.add(parts::switch("switch", false));
    let clock = line.add(parts::event_source("clock"));
    let (inner, lamp) = (line.add(inner), line.add(lamp));
    line.condition((switch, "on"), (inner, "x")).condition((switch, "off"), (inner, "not_x"));
    line.event((clock, "event"), (inner, "tick")).event((inner, "news"), (lamp, "news"));
    line.condition((inner, "seen"), (lamp, "was_seen"));
    let system = line.flatten(Semantics::default()).unwrap();

    let id = |name: &str| system.net().transition_named(name).unwrap();
    let (turn_on, tick, turn_off) = (id("switch.set"), id("clock.occurs"), id("switch.reset"));
    let (set, reset, light) = (id("inner.copy.set"), id("inner.copy.reset"), id("lamp.on"));
    let mut player = TncesPlayer::new(&system, Policy::Soonest);
    let mut fire = |t| player.fire(t).unwrap().step.into_vec();
    assert_eq!(fire(tick), [tick]);
    assert_eq!(fire(turn_on), [turn_on]);
    // The lamp is called in the same step, but the condition is that of the marking before it.
    assert_eq!(fire(tick), [tick, set]);
    assert_eq!(fire(turn_off), [turn_off]);
    assert_eq!(fire(tick), [tick, reset, light]);
    assert_eq!(system.net().describe(player.marking()), "switch.off, inner.copy.off, lamp.lit");
}

/// In mode *all* an event input counts once, whatever drives it.
#[test]
fn all_and_any_over_ports() {
    for (mode, expected) in [(EventMode::Any, [true, true]), (EventMode::All, [false, true])] {
        let mut m = TncesModule::new("m");
        let p = m.place("p", 9);
        let t = m.transition("t");
        m.input(t, p, 1, Interval::ANY).event_mode(t, mode);
        let (one, two) = (m.event_in("one"), m.event_in("two"));
        m.on(one, t).on(two, t);
        let mut relay = TncesModule::new("relay");
        let (near, far) = (relay.transition("near"), relay.transition("far"));
        relay.external(near).event(near, far).event_out("either", [near, far]).event_out("far", [far]);
        let mut line = Composite::new("line");
        let (m, relay, source) = (line.add(m), line.add(relay), line.add(parts::event_source("source")));
        line.event((relay, "either"), (m, "one"))
            .event((source, "event"), (m, "one"))
            .event((relay, "far"), (m, "two"));
        let system = line.flatten(Semantics::default()).unwrap();
        let id = |name: &str| system.net().transition_named(name).unwrap();
        let mut player = TncesPlayer::new(&system, Policy::Soonest);
        let called = ["source.occurs", "relay.near"].map(|t| player.fire(id(t)).unwrap().step.contains(&id("m.t")));
        assert_eq!(called, expected);
    }
}
