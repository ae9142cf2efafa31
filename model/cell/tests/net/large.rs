//! Large cells: the net grows with what is moved where, not with the product of resources and stages.

use std::fmt::Write;

use linewright_cell::net::{Detail, net};
use linewright_nets::coloured::{Colours, unfold};

use linewright_testkit::cells::cell;

/// Groups of two machines and a robot around a store, and one part type for each group that is worked on twice.
fn large(groups: usize) -> String {
    let mut text = format!("name = \"large\"\n[cell]\nwip_max = {groups}\n");
    for g in 0..groups {
        write!(
            text,
            "[[resource]]\nname = \"S{g}\"\nprototype = \"random-access-store\"\ncapacity = 4\n\
             [[resource]]\nname = \"R{g}\"\nprototype = \"robot\"\n\
             [[sync]]\nname = \"enter {g}\"\nactions = [\"outside.in\", \"S{g}.store\"]\n\
             [[sync]]\nname = \"leave {g}\"\nactions = [\"S{g}.retrieve\", \"outside.out\"]\n"
        )
        .expect("writing to a string");
        for m in ["A", "B"] {
            write!(
                text,
                "[[resource]]\nname = \"{m}{g}\"\nprototype = \"machine\"\n\
                 [[sync]]\nname = \"load {m}{g}\"\ntime_s = 1\nactions = [\"S{g}.retrieve\", \"R{g}.pick-and-place\", \"{m}{g}.load\"]\n\
                 [[sync]]\nname = \"unload {m}{g}\"\ntime_s = 1\nactions = [\"{m}{g}.unload\", \"R{g}.pick-and-place\", \"S{g}.store\"]\n"
            )
            .expect("writing to a string");
        }
        write!(
            text,
            "[[part]]\nname = \"p{g}\"\nstep = [{{ name = \"a\", on = [{{ resource = \"A{g}\", time_s = 1 }}] }}, \
             {{ name = \"b\", on = [{{ resource = \"B{g}\", time_s = 1 }}] }}]\n"
        )
        .expect("writing to a string");
    }
    text
}

/// 400 resources: a part type enters every store, but only its own group can finish it, so it is let into no other.
#[test]
fn the_net_grows_with_what_is_moved_where() {
    for groups in [10, 100] {
        let cell = cell(&large(groups));
        for (detail, modes) in [(Detail::Coordination, 8), (Detail::Expanded, 8 + 6)] {
            let net = net(&cell, detail, vec![1; groups].as_slice()).expect("it is bounded");
            let long = unfold(net.net(), Colours::Reachable, 1_000_000).expect("it is bounded");
            assert_eq!(long.net().transition_count(), modes * groups);
        }
    }
}
