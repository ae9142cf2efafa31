//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod cell;
mod common;
mod described;
mod exceptions;
mod isolated;
mod mode_table;
mod on_order;
mod planning;
mod recovery;
mod watchfulness;
