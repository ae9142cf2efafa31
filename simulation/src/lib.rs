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
//! gives. Images reach the plant at once or, with [`SimOptions::frames`], as they do there:
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
//! Without files or displays. [`LineSim`] plays, [`RunRecord`] keeps the record, [`Script`] is what people do.

pub mod cell;
mod condition;
mod critical;
mod error;
mod field;
mod held_buttons;
mod idle;
mod link;
mod lives;
mod log;
mod network;
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

pub use condition::{Compare, OperationCondition, ScenarioCondition, StationCondition};
pub use critical::{CriticalMotion, CriticalPath};
pub use error::StartError;
pub use log::{LogKind, RunLog, SimLogEntry};
pub use observer::{ConflictObserver, SeenConflict};
pub use operator::{MotionSelection, NodeProcess, OperatorAction};
pub use options::{Network, NetworkChange, SimOptions};
pub use plan::{Circuit, EarliestSchedule, LinePlan, PlannedTimes};
pub use record::{ArrowWait, FaultSeen, LastWait, MotionEnd, RecordedMotion, RunRecord};
pub use rng::Rng;
pub use run::{RunEnd, RunGoal, run};
pub use scenario::Scenario;
pub use script::{Script, ScriptAction, ScriptFailure, ScriptStep};
pub use sim::LineSim;
