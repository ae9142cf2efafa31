//! A station's net, from the connection algorithm to its conditions: structure, exclusiveness, and every condition
//! held to the seed's figures.

mod exclusive;
mod figures;
mod generate;
mod sheet;
mod structure;
mod words;
