//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod buttons;
mod common;
mod cycle_time;
mod gateway;
mod inactive;
mod isolated;
mod mode_table;
mod resume;
mod resume_button;
mod single;
mod task_driven;
mod texts;
mod watchfulness;
