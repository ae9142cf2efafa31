//! Coloured nets: the published nets and figures of seed 000, and random nets against slow, obvious twins.
//!
//! Each claim cites its line. *Printed* stands in the text; *rebuilt* had to be inferred because the drawing is lost; the
//! tests say which is which.

mod cell;
mod cell_resources;
mod conveyor;
mod example;
mod flows;
mod grammar;
mod lifo;
mod problems;
mod random;
mod slow;
mod watchdog;

use linewright_nets::coloured::{ColouredMarking, ColouredNet, Mode};

/// The mode of that name.
fn mode(net: &ColouredNet, name: &str) -> Mode {
    net.mode_named(name).unwrap_or_else(|| panic!("{net}has no mode {name}"))
}

/// Plays the modes of these names, one after the other.
fn play(net: &ColouredNet, marking: &mut ColouredMarking, names: &[&str]) {
    for name in names {
        net.fire(marking, mode(net, name)).unwrap_or_else(|why| panic!("{why}; {}", net.describe(marking)));
    }
}

/// The names of modes.
fn names(net: &ColouredNet, modes: impl IntoIterator<Item = Mode>) -> Vec<String> {
    modes.into_iter().map(|mode| net.mode_name(mode)).collect()
}
