//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod auto_cycles;
mod cells;
mod chance;
mod common;
mod driven_table;
mod faults;
mod observer;
mod on_buses;
mod one_by_one;
mod plan;
mod scenario;
mod table;
