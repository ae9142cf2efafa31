//! A line of real processes, observed and operated from outside.
//!
//! ```text
//!   Rig ── starts ──▶ linewright run ──▶ plant, coordinator, stations
//!   Eye ◀── CAN frames ── the virtual bus           (reads switches and outputs, bit by bit)
//!   Operator ◀── ROS topics ──▶ the nodes           (what any ROS user could do)
//! ```
//!
//! A controller's own report is not used where the machine can be observed instead: [`eye`] decodes frames by hand,
//! with bit numbers from the description's text, and shares no code with the programs it watches.
// No test uses all of it.
#![allow(dead_code)]

pub mod bus;
pub mod chart;
pub mod command;
pub mod eye;
pub mod faster;
pub mod gate;
pub mod operator;
pub mod plan;
pub mod rig;
pub mod stranger;
pub mod turn;

use std::time::{Duration, Instant};

/// Most time to wait for an expected event: this machine may be busy with other things.
pub const PATIENCE: Duration = Duration::from_secs(30);
/// Period of checks while waiting.
const LOOK_EVERY: Duration = Duration::from_millis(2);

/// Waits until `holds`; gives whether it came true within `long`.
pub fn wait_for(long: Duration, mut holds: impl FnMut() -> bool) -> bool {
    let until = Instant::now() + long;
    loop {
        if holds() {
            return true;
        }
        if Instant::now() > until {
            return false;
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

/// Lets time pass.
pub fn pause(millis: u64) {
    std::thread::sleep(Duration::from_millis(millis));
}
