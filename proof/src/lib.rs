//! Decides whether a line is right: by structure, and by exploring its real controllers, composed; and whether a flexible
//! cell is, by exploring its net.
//!
//! This crate knows nets, lines, cells and controllers, and asks everything that can be asked of them before anything moves.
//! It does not know how a question is put or an answer printed, and it has no clock: how far it looks is said in states
//! and bytes.

pub mod cell;
pub mod explore;
pub mod generate;
pub mod parts;
pub mod positions;
pub mod structure;
