//! The dispatcher with rules: tables worked out by hand, fairness, every answer judged from the net, and its words.

mod conflict;
mod fairness;
mod judge;
pub mod rules;
mod solo;
mod words;
