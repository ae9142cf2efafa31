//! Plans back to auto.

mod brute_force;
mod operator;
mod random_plays;
mod resume;
mod situations;
