//! Production orders, looking ahead and schedules, on the shipped cells and on cells by chance, against oracles that share
//! nothing with them.

mod ahead;
mod beside;
mod oracle;
mod orders;
mod replan;
mod schedule;
mod shop;
mod tracking;
