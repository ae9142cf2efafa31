//! Whole lines in the simulation, on their buses: what people do to them, and what must hold.
//!
//! ```text
//!   scenario ──▶ Sim: what a person does, by name ──▶ the simulation: nodes, network, frames, devices, plant
//!                  after every event                     │ events            │ positions
//!                                                        ▼                   ▼
//!                                                   its record        IndependentObserver
//! ```
//!
//! The same seed gives the same run to the microsecond, so a failure found after a million cycles is found again at once.
//!
//! A scenario is a short story:
//!
//! ```no_run
//! # use linewright_tests::{WatchedLine, transfer_line};
//! # use linewright_plant::MotionFault;
//! let mut sim = WatchedLine::new(&transfer_line(1.0), 7);
//! sim.start_auto();
//! sim.fail("mill_1", "feed main slide", MotionFault::Break);
//! sim.run_until("the mill stops", |s| s.is_incomplete("mill_1"));
//! ```

mod observer;
mod operator;
mod scenario;
mod sim;

pub use linewright_simulation::{LogKind, Network, NodeProcess, Rng, RunLog, SimLogEntry};
pub use observer::IndependentObserver;
pub use scenario::{hand_button, moments, transfer_line, transfer_line_with};
pub use sim::{QUIET, ROUGH, WatchedLine, network};
