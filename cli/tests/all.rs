//! The tests of this crate as one program: programs of their own would each be linked with all that they share.
//!
//! Only `real_bus` is another, because it is run whole where there is a real CAN interface.

mod analyse;
mod can;
mod check;
mod check_cell;
mod check_parts;
mod deploy;
mod describe;
mod fuzzed;
mod interface;
mod processes;
mod report;
mod schema;
mod sessions;
mod simulate;
mod support;
mod synthesise;
