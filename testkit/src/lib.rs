//! Test support that several crates share: small lines, shipped cells, nets, and crowds of simulated devices.
//!
//! What a test compares with stays in the crate under test: here is what it begins from. Nothing but tests, benches and
//! fuzz targets depends on this crate.

pub mod built;
pub mod cases;
pub mod cells;
pub mod coloured;
pub mod crowd;
pub mod device_frames;
pub mod manager_frames;
pub mod presses;
pub mod published_cell;
pub mod samples;
