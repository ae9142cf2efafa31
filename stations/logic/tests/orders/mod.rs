//! Task-driven stations: replies, actions, ways back, and memory after a restart.
//!
//! The station is the machine of the description `task_driven.toml`: it clamps a part, machines it, releases it.

mod answers;
mod apart;
mod back;
mod bench;
mod doing;
mod memory;
mod people;
mod random;
mod rejoin;
mod results;
mod stop;
