//! The nets of the two shipped cells, against the published ones and against numbers computed elsewhere.

mod counts;
mod details;
mod large;
mod published;
/// The published cell as one net, written from the source's pages; its own tests say which arcs are printed.
#[path = "../../../nets/tests/coloured/cell.rs"]
#[allow(dead_code)]
mod source;
mod twin;

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
