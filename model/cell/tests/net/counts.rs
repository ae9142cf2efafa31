//! Number of states, steps and deadlocks of the two cells, against numbers that a small explorer in Python computed from
//! the same descriptions before this was written, with no part in common with it.
//!
//! That explorer freed the slot of a store when the activity ended, had no limit on what the assembly cell's input and
//! output hold, and put a part, where nothing is reserved, in one step; ours has a start and an end for that. The
//! intermediate states differ there, the deadlocks do not: nothing is in progress in any.

use linewright_cell::net::{Detail, net};
use linewright_nets::coloured::{Colours, explore, unfold};

use linewright_testkit::cells::{ASSEMBLY, C1, cell, edited};

/// States, steps, deadlocks.
fn counts(text: &str, waiting: &[u32]) -> (usize, usize, usize) {
    let net = net(&cell(text), Detail::Expanded, waiting).expect("it is small");
    let graph = explore(net.net(), 1_000_000).expect("it is small");
    (graph.states().len(), graph.steps().len(), graph.deadlocks().count())
}

fn c1(slots: u32, reserve: bool) -> String {
    let (capacity, reserve) = (format!("capacity = {slots}"), format!("reserve = {reserve}"));
    edited(C1, &[("capacity = 6", &capacity), ("reserve = true", &reserve), ("wip_max = 6", "wip_max = 10")])
}

#[test]
fn reserved_c1_has_the_computed_numbers() {
    assert_eq!(counts(&c1(4, true), &[2, 2]), (4_256, 12_546, 0));
    assert_eq!(counts(&c1(4, true), &[3, 2]), (12_604, 42_548, 2));
    assert_eq!(counts(&c1(4, true), &[1, 4]), (4_525, 13_775, 3));
    assert_eq!(counts(&c1(4, true), &[3, 3]), (26_108, 94_592, 20));
    assert_eq!(counts(&c1(4, true), &[4, 4]), (49_905, 187_242, 112));
    assert_eq!(counts(&c1(6, true), &[3, 3]), (31_860, 118_016, 0));
}

#[test]
fn unreserved_c1_has_the_computed_deadlocks() {
    assert_eq!(counts(&c1(4, false), &[2, 2]).2, 78);
}

#[test]
fn the_assembly_cell_has_the_computed_numbers() {
    assert_eq!(counts(ASSEMBLY, &[1, 1, 1]), (288, 744, 0));
    assert_eq!(counts(ASSEMBLY, &[2, 2, 1]), (1_773, 6_516, 0));
    let six = edited(
        ASSEMBLY,
        &[("wip_max = 5", "wip_max = 6"), ("capacity = 5", "capacity = 6"), ("capacity = 5", "capacity = 6")],
    );
    assert_eq!(counts(&six, &[2, 2, 2]), (4_104, 16_956, 0));
}

#[test]
fn the_unreserved_assembly_cell_has_the_computed_deadlocks() {
    let text = edited(ASSEMBLY, &[("reserve = true", "reserve = false"), ("wip_max = 5", "wip_max = 6")]);
    let text = text.replace("capacity = 5", "capacity = 6");
    assert_eq!(counts(&text, &[1, 1, 1]).2, 4);
    assert_eq!(counts(&text, &[2, 2, 1]).2, 9);
    assert_eq!(counts(&text, &[2, 2, 2]).2, 11);
}

/// Counts by that explorer, and the places that it did without: the number of parts in the cell; the contents of the
/// assembly cell's stores; the human's token, which follows from the one work position.
#[test]
fn places_and_transitions_are_the_computed_ones() {
    let size = |text: &str, waiting: &[u32]| {
        let net = net(&cell(text), Detail::Expanded, waiting).expect("it is small");
        let long = unfold(net.net(), Colours::Reachable, 10_000).expect("it is small");
        (long.net().place_count(), long.net().transition_count())
    };
    assert_eq!(size(C1, &[1, 1]), (38 + 1, 34));
    assert_eq!(size(ASSEMBLY, &[1, 1, 1]), (27 + 1 + 2 + 1, 24));
}
