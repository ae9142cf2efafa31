//! The nets of the shipped cells with what fails: by structure; and, for few parts, state by state.

use std::time::Duration;

use linewright_cell::Cell;
use linewright_cell::net::Supply;
use linewright_coordinator_cell::compile::{OrderTiming, RecoveryNet, compile_cell, recovery_net};
use linewright_nets::NetBuilder;
use linewright_nets::explicit::{ExplorationLimits, decide, find};
use linewright_proof::cell::Verdict;
use linewright_proof::cell::recovery::{BACK, BOUNDED, KEPT, check_recovery, judge};

use super::described as shipped;

const PACE: OrderTiming = OrderTiming { repeat_interval: Duration::from_secs(1), grace: Duration::from_secs(1) };

fn net(cell: &Cell, supply: Supply<'_>) -> RecoveryNet {
    let made = compile_cell(cell, None, supply, PACE).unwrap_or_else(|why| panic!("{why}"));
    recovery_net("recovery", &made.table).expect("it has one")
}

#[test]
fn in_the_shipped_cells_what_fails_leads_back_and_loses_nothing() {
    for name in ["workcell-c1", "assembly-cell"] {
        let (cell, line) = shipped(name, "");
        let found = check_recovery(&cell, Some(&line));
        let names: Vec<&str> = found.iter().map(|property| property.name).collect();
        assert_eq!(names, [BACK, KEPT, BOUNDED]);
        found.iter().for_each(|property| println!("{name}: {}: {}", property.name, property.reason));
        assert!(found.iter().all(|property| property.verdict == Verdict::Holds), "{name}: {found:?}");
    }
}

/// The same net with one transition's arcs changed.
fn changed(of: &RecoveryNet, name: &str, change: impl Fn(&str) -> i32) -> RecoveryNet {
    let (long, mut b) = (&of.net, NetBuilder::new("changed"));
    let initial = long.initial_marking();
    long.places().for_each(|place| _ = b.place(long.place_name(place), initial.tokens(place)));
    for t in long.transitions() {
        let own = b.transition(long.transition_name(t));
        long.preset(t).iter().for_each(|&(place, n)| _ = b.input(own, place, n));
        long.postset(t).iter().for_each(|&(place, n)| _ = b.output(own, place, n));
        for place in long.places().filter(|_| long.transition_name(t) == name) {
            match change(long.place_name(place)) {
                0 => (),
                more if more > 0 => _ = b.output(own, place, more as u32),
                less => _ = b.input(own, place, less.unsigned_abs()),
            }
        }
    }
    RecoveryNet { net: b.build().expect("it is one"), errors: of.errors.clone() }
}

#[test]
fn a_recovery_that_waits_or_that_gives_too_much_is_found() {
    let (cell, _) = shipped("workcell-c1", "");
    let net = net(&cell, Supply::Open);
    let verdicts = |net: &RecoveryNet| judge(net).iter().map(|property| property.verdict).collect::<Vec<_>>();
    assert_eq!(verdicts(&net), [Verdict::Holds; 3]);
    let place = net.net.places().map(|place| net.net.place_name(place)).find(|name| name.starts_with("M2."));
    let place = place.expect("M2 has places").to_owned();
    // As if another machine had to be as it is at the beginning.
    let waits = changed(&net, "load M1<A.new>.to.forward", |name| -i32::from(name == place));
    assert_eq!(verdicts(&waits)[0], Verdict::Fails, "it waits for {place}");
    let twice = changed(&net, "load M1<A.new>.to.forward", |name| i32::from(name == place));
    assert_eq!(verdicts(&twice)[1..], [Verdict::Fails, Verdict::Fails], "{place} is there twice");
}

/// Two parts of each type come and fail as they like: from every state the cell becomes empty again, and no state holds more
/// parts than are let in. Parts that are given up come anew.
#[test]
fn from_every_state_with_what_fails_the_cell_becomes_as_it_was() {
    let (mut cell, _) = shipped("workcell-c1", "");
    cell.limits.wip_max = 2;
    let net = net(&cell, Supply::Open).net;
    let facts = decide(&net, &ExplorationLimits::default()).expect("it is small");
    println!("{} states", facts.states);
    assert_eq!(facts.no_return, None, "from every state the beginning is reached again");
    let error = net.place_named("load M1<A.new>.failed").expect("there");
    assert!(
        find(&net, &ExplorationLimits::default(), |view| view.tokens(error) > 0).expect("small").is_some(),
        "it does fail"
    );
}
