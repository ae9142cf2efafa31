//! The tests of this crate as one program.

mod acknowledged;
mod answers;
mod bench;
mod cell;
mod desk;
mod frames;
mod lanes;
mod next;
mod operate;
mod page;
mod requests;
