//! Coloured nets: the published nets and figures of seed 000, and random nets against slow, obvious twins.
//!
//! Each claim cites its line. *Printed* stands in the text; *rebuilt* had to be inferred because the drawing is lost; the
//! tests mark which is which.

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

use linewright_testkit::coloured::{mode, names, play};
