//! Coloured nets by the names of their modes.

use linewright_nets::coloured::{ColouredMarking, ColouredNet, NetMode};

pub fn mode(net: &ColouredNet, name: &str) -> NetMode {
    net.mode_named(name).unwrap_or_else(|| panic!("{net}has no mode {name}"))
}

/// Plays the modes of these names, one after the other.
pub fn play(net: &ColouredNet, marking: &mut ColouredMarking, names: &[&str]) {
    for name in names {
        net.fire(marking, mode(net, name)).unwrap_or_else(|why| panic!("{why}; {}", net.describe(marking)));
    }
}

pub fn names(net: &ColouredNet, modes: impl IntoIterator<Item = NetMode>) -> Vec<String> {
    modes.into_iter().map(|mode| net.mode_name(mode)).collect()
}
