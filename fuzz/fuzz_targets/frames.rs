//! Anything from the bus, in any order: to a manager among its devices, and to simulated devices. No panic, bounded
//! answers, and no output but those of the owner's image, or of the process data last sent.
//!
//! The benches, shared with the property tests of `linewright_plant` and `linewright_canopen`, describe how a script of
//! bytes is played and what is checked.

#![cfg_attr(feature = "engine", no_main)]

use libfuzzer_sys::fuzz_target;
use linewright_testkit::{device_frames, manager_frames};

fuzz_target!(|input: &[u8]| {
    let Some((which, script)) = input.split_first() else { return };
    if which & 1 == 0 {
        manager_frames::ManagerFramesBench::set_up().play(script);
    } else {
        device_frames::DeviceBench::set_up().play(script);
    }
});

/// Without the engine a target only links.
#[cfg(not(feature = "engine"))]
fn main() {}
