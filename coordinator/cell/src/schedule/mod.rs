//! The schedule: planned starts and ends for all open production orders, made in advance and anew when it does not hold.
//!
//! # Map
//! - [`Schedule`], [`ScheduleSlot`]: what is to start when, in which window, and what has become of it; the dispatcher's rule
//!   `schedule` follows the windows.
//! - [`Scheduler`]: makes one. [`RolloutScheduler`] compares forward simulations: by rules, by looking ahead, and, where the
//!   cell is small, through all that can be decided, until nothing better can exist.
//! - [`ScheduleFollower`]: the dispatcher that has schedules made, follows them, and has them revised: at once, within the
//!   decision, in virtual time; or beside the decisions, which then never wait ([`PlanningRequest`]).
//! - [`PlanActualBar`]: plan against actual, for a Gantt chart.
//!
//! A schedule is made by playing the table that is run, so it never plans what the net forbids; and it is only ever advice:
//! the dispatcher requests it, the player checks the dispatcher's answer.

mod beside;
mod builtin;
mod randomised_rollouts;
mod schedule_follower;
mod search;
mod slots;
mod timetable;

pub use beside::{PlanningRequest, WITHIN};
pub use builtin::RolloutScheduler;
pub use schedule_follower::{Revision, ScheduleFollower};
pub use slots::{PlanActualBar, Schedule, ScheduleSlot};
pub use timetable::RevisionReason;

use linewright_line::Tick;

use super::ahead::SimulationBasis;
use super::production::DispatchConfiguration;
use super::state::PlayerState;

/// Planning problem.
#[derive(Clone, Copy, Debug)]
pub struct PlanningSituation<'a> {
    pub now: Tick,
    /// Time up to which it is planned; [`Tick::NEVER`] for everything.
    pub until: Tick,
    /// The cell.
    pub state: &'a PlayerState,
    /// Rules and production orders.
    pub desk: &'a DispatchConfiguration,
    pub basis: &'a SimulationBasis,
    /// The plan before, and its progress.
    pub previous: Option<&'a Schedule>,
}

/// Makes schedules. Others than [`RolloutScheduler`] may use more of a cell; their schedules are followed in the same
/// way.
pub trait Scheduler {
    /// A schedule for parts inside and parts that production orders have yet to let in. It has to come to an end within
    /// a bound that does not depend on time.
    fn plan(&mut self, situation: &PlanningSituation<'_>) -> Schedule;
}
