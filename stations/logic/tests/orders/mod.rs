//! Stations on order: what they answer, what they do, how they come back, and what they still know after a restart.
//!
//! The station is the machine of the description `on_order.toml`: it clamps a part, machines it, releases it.

mod answers;
mod apart;
mod back;
mod bench;
mod doing;
mod memory;
mod people;
mod random;
mod stop;
