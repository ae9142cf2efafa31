//! A whole line in virtual time: the real station and mode controllers against the simulated plant.
//!
//! ```text
//!   operator ──────┬──────────────┬──────────────┐  commands, buttons
//!                  ▼              ▼              ▼
//!            Coordinator ◀──▶ Controller ◀──▶ Controller ...   links: delay, jitter, loss, all from a seed
//!                                 │  ▲            │  ▲
//!                        outputs  ▼  │  inputs    ▼  │
//!                          Field: Plant behind devices         Observer looks at positions alone
//! ```
//!
//! Between the operator's word and the mechanism stands the code that runs on a shop floor. Messages take what [`Network`]
//! gives. Images reach the plant at once or, with [`Options::frames`], as they do there:
//!
//! ```text
//!            Coordinator     Controller ◀──▶ Controller ...     every message whole and numbered
//!            + Gateway  ◀──▶ (station 0)     (station 1)
//!                  │                              │
//!               Manager                        Manager          of a bus of its own
//!                  │ CAN frames                   │
//!                Rack: devices + Plant          Rack ...
//! ```
//!
//! There is no clock, no socket and no thread, and the same seed gives the same run to the microsecond.
//!
//! [`cell`] is the same for a flexible cell and its orders.
//!
//! It does not know files or how anything is shown. [`Sim`] plays, [`Record`] remembers, [`Script`] is what people do.

pub mod cell;
mod condition;
mod critical;
mod field;
mod hands;
mod idle;
mod link;
mod lives;
mod log;
mod node;
mod observer;
mod operator;
mod options;
mod plan;
mod record;
mod rng;
mod run;
mod scenario;
mod script;
mod sim;
mod talk;
mod timers;
mod view;
mod whole;

pub use condition::{Compare, Condition, OperationState, StationState};
pub use critical::{CriticalPath, Link};
pub use lives::StartError;
pub use log::{Entry, Log, What};
pub use observer::Seen;
pub use operator::{Action, Process, Way};
pub use options::{Network, NetworkChange, Options};
pub use plan::{Circuit, Plan, Planned, Schedule};
pub use record::{By, Ended, FaultSeen, Motion, Record, Wait};
pub use rng::Rng;
pub use run::{End, Goal, run};
pub use scenario::Scenario;
pub use script::{Deed, Failure, Script, Step};
pub use sim::Sim;
