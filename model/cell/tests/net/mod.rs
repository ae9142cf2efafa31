//! The nets of the two shipped cells, against the published ones and against numbers computed elsewhere.

mod counts;
mod details;
mod large;
mod published;
mod twin;

use linewright_testkit::coloured::{mode, names, play};
