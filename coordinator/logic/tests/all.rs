//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod common;
mod cycle_time;
mod isolated;
mod mode_table;
mod resume;
mod single;
mod task_driven;
mod texts;
mod watchfulness;
