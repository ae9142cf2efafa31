//! The nets of the two shipped cells, against the published ones and against numbers computed elsewhere.

mod counts;
mod details;
mod large;
#[path = "../../../nets/tests/coloured/named.rs"]
mod named;
mod published;
/// The published cell as one net, written from the source's pages; its own tests mark which arcs are printed.
#[path = "../../../nets/tests/coloured/cell.rs"]
#[allow(dead_code)]
mod source;
mod twin;

use named::{mode, names, play};
