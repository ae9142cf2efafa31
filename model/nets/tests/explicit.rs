//! Whole rings of stations, with the numbers that the obvious exploration and other programs find.

use crate::explicit_ring::ring;
use linewright_nets::explicit::{ExplorationLimits, Storage, decide};
use linewright_nets::explore;

#[test]
fn the_ring_has_the_states_that_exploration_finds() {
    for (stations, states) in [(2, 168), (3, 3_444), (4, 46_256)] {
        let net = ring(stations, false);
        assert_eq!((net.place_count(), net.transition_count()), (14 * stations, 12 * stations));
        let explored = explore(&net, 100_000).unwrap();
        assert_eq!(explored.states().len(), states);
        let facts = decide(&net, &ExplorationLimits::default()).unwrap();
        assert_eq!((facts.states, facts.arcs), (states as u64, explored.steps().len() as u64));
        assert_eq!((facts.deadlocks, facts.bound()), (0, 1));
        assert!(facts.is_live() && facts.is_reversible() && facts.is_safe());
        assert!(matches!(facts.storage, Storage::Bitmap { .. }));
    }
}

#[test]
fn five_stations_are_a_million_states_on_any_number_of_threads() {
    let net = ring(5, false);
    let facts = decide(&net, &ExplorationLimits::default()).unwrap();
    // As counted by Spin 6.5.2 and two checkers of Petri nets.
    assert_eq!((facts.states, facts.arcs), (1_084_860, 4_979_100));
    assert!(facts.is_live() && facts.is_reversible() && facts.is_safe());
    assert_eq!(decide(&net, &ExplorationLimits { threads: 2, ..ExplorationLimits::default() }).unwrap(), facts);
}

#[test]
fn a_ring_without_a_part_stops() {
    for stations in 2..=4 {
        let net = ring(stations, true);
        let explored = explore(&net, 100_000).unwrap();
        let facts = decide(&net, &ExplorationLimits::default()).unwrap();
        assert_eq!(facts.states, explored.states().len() as u64);
        assert_eq!(facts.deadlocks, 1);
        let deadlock = facts.deadlock.as_ref().expect("there is one");
        assert_eq!(deadlock.path.len(), explored.path_to(explored.deadlocks().next().unwrap()).len());
        assert!(!facts.is_reversible() && facts.terminal_components == 1);
        assert!(net.transitions().all(|t| !facts.is_transition_live(t)));
    }
}
