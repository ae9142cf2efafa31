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
//! Between the operator's word and the mechanism stands the code that runs on a shop floor; what is left out is how
//! images and messages travel. Images reach the plant at once, messages take what [`Network`] says. There is no clock,
//! and the same seed gives the same run to the microsecond.
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

pub use condition::{Compare, Condition, OperationState, StationState};
pub use critical::{CriticalPath, Link};
pub use hands::{Hands, RELEASES};
pub use log::{Entry, Log, What};
pub use observer::Seen;
pub use operator::{Action, Process, Way};
pub use options::{Network, NetworkChange, Options};
pub use plan::{Circuit, Plan, Planned, Schedule};
pub use record::{By, Ended, FaultSeen, Motion, Record, Wait};
pub use rng::{Rng, mix};
pub use run::{End, Goal, run};
pub use scenario::Scenario;
pub use script::{Deed, Failure, Script, Step};
pub use sim::Sim;
