//! A flexible cell in virtual time: the real token player and dispatcher against stations that are pretended.
//!
//! ```text
//!   Dispatcher ◀──▶ Coordination ──▶ records ──▶ Store, from which the next life begins
//!                     │      ▲
//!              orders ▼      │ replies, whole states        messages take time, get lost, come twice
//!                    Station … Station                      their ledgers have what has really been done
//! ```
//!
//! [`CellSim`] plays it, from a seed; [`SimulatedStation`] stands for a task-driven station, without axes and sensors;
//! [`SimulatedPlanner`] plans beside the decisions and takes its time;
//! or [`ShopFloor`] has the real ones, with mechanisms and parts; [`RecordStore`] keeps records. With pretended stations
//! [`PartTruth`] has the true places of parts, which [`SimulatedOperator`] sees. The coordinator can be killed at each of its
//! steps, of which every record and every message is one. The caller sets what stations do, and what happens to them, between
//! two calls.
//!
//! [`CellStudy`] is for plants that are being planned: a [`CellScenario`] has the orders and breakdowns, and several
//! replications give the expected figures, each with its confidence interval ([`Estimate`]).

mod distribution;
mod estimate;
mod floor;
mod operator;
mod planner;
mod scenario;
mod sim;
mod station;
mod store;
mod study;
mod task_times;
mod truth;

pub use distribution::Distribution;
pub use estimate::Estimate;
pub use floor::{ShopFloor, Work, nests};
pub use operator::SimulatedOperator;
pub use planner::SimulatedPlanner;
pub use scenario::{
    BreakdownPattern, CellScenario, FailureClock, OrderArrivals, PRECISION_PERCENT, REPLICATIONS_MAX, ScriptedFault,
    StationFault,
};
pub use sim::{CellSim, CellSimOptions, StationSpeed};
pub use station::{BegunTask, SimulatedStation};
pub use store::{InMemory, RecordStore};
pub use study::{
    CellStudy, OrderFigures, PlayedReplication, ReplicationFigures, ReplicationGoal, ResourceFigures, Standstill,
    StudyOptions, StudyProblem, UNCHANGED, UNDISTURBED,
};
pub use task_times::TaskTimes;
pub use truth::{InspectionResult, PartTruth};
