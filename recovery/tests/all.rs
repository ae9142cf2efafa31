//! Plans back to auto.

mod alarms;
mod brute_force;
mod cells;
mod commands;
mod ends;
mod holding;
mod led_back;
mod operator;
mod random_plays;
mod reasons;
mod resume;
mod situations;
mod tables;
