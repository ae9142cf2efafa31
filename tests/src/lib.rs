//! A whole line in virtual time.
//!
//! ```text
//!   operator ──────┬──────────────┬──────────────┐  commands, panel buttons
//!                  ▼              ▼              ▼
//!            Coordinator     Controller ◀──▶ Controller ...     a network: delay, loss, reordering,
//!            + Gateway  ◀──▶ (station 0)     (station 1)        duplicates, partitions, all from a seed
//!                  │
//!               Manager
//!                  │ CAN frames
//!                Rack: devices + Plant ◀── faults               Observer looks at positions alone
//! ```
//!
//! Everything between the operator's finger and the mechanism is the code that runs on a shop floor: controllers,
//! coordinator, gateway, CANopen manager, devices. What is simulated is what lies between them — the network, the
//! clock, the shells that die and come back. There are no sockets and no threads, and the same seed gives the same
//! run to the microsecond, so a failure found after a million cycles is found again at once.
//!
//! A scenario is a short story:
//!
//! ```no_run
//! # use linewright_tests::{Sim, transfer_line};
//! # use linewright_coordinator_logic::Command;
//! # use linewright_plant::Fault;
//! let mut sim = Sim::new(&transfer_line(1.0), 7);
//! sim.start_auto();
//! sim.fail("mill_1", "feed main slide", Fault::Break);
//! sim.run_until("the mill stops", |s| s.is_incomplete("mill_1"));
//! ```

mod bus;
mod coordinator;
mod ledger;
mod network;
mod observer;
mod operator;
mod queue;
mod scenario;
mod sim;
mod station;

pub use ledger::Ledger;
pub use linewright_simulation::{Entry, Log, Rng, What};
pub use network::{Conditions, Message, Node};
pub use observer::Observer;
pub use scenario::{hand_button, soak, transfer_line, transfer_line_with};
pub use sim::Sim;
