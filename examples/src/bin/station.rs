//! One station in a loop, without ROS and without devices: the caller owns the time, the cylinder and its switches.
//!
//! `cargo run -p linewright-examples --bin station`

use std::error::Error;
use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_line::{StationId, Tick, parse};
use linewright_station_logic::{Controller, ModeOrder, NO_DELAY, Restore, StationInput, StationOutbox};

/// The outputs of `feeder io`, by bit.
const PULL: u128 = 1 << 0;
const PUSH: u128 = 1 << 1;
/// Its inputs, by bit.
const PULLED: u128 = 1 << 0;
const PUSHED: u128 = 1 << 1;
/// Full stroke of the cylinder in mm, and how far it moves in a millisecond.
const STROKE: i32 = 200;
const PER_MS: i32 = 1;

fn main() -> Result<(), Box<dyn Error>> {
    let line =
        parse("feeder.toml", include_str!("../../feeder.toml")).map_err(|problems| format!("{problems:?}"))?.line;
    let mut feeder = Controller::new(&line, StationId(0), 1, Restore::Fresh)?;
    let mut out = StationOutbox::default();
    let mut position = 0;
    for ms in 0..5_000 {
        let now = Tick::from_micros(ms * 1000);
        // What has arrived: the switches, and the coordinator's mode command, renewed before its lease ends.
        let switches = (u128::from(position == 0) * PULLED) | (u128::from(position == STROKE) * PUSHED);
        feeder.handle(now, StationInput::Inputs { bits: switches, valid: true, until: Tick::NEVER, under: NO_DELAY });
        if ms % 100 == 0 {
            let mode = if ms < 4_000 { ControlMode::Auto } else { ControlMode::StandBy };
            let epoch = if ms < 4_000 { 1 } else { 2 };
            feeder.handle(now, StationInput::Order(ModeOrder::of(1, epoch, mode, Duration::from_millis(250))));
        }
        feeder.step(now, &mut out);
        // What comes of it: the outputs move the cylinder, the events are for people.
        match out.outputs {
            PUSH => position = (position + PER_MS).min(STROKE),
            PULL => position = (position - PER_MS).max(0),
            _ => {}
        }
        for event in out.events.drain(..) {
            println!("{:>7.3} s  cycle {}: {}", now.as_secs_f64(), event.cycle, event.text(&line, StationId(0)));
        }
    }
    println!("at the end: {}", feeder.operation_text(&line));
    Ok(())
}
