//! The schedule: when everything that is on order starts and ends, made in advance and made anew when it does not hold.
//!
//! # Map
//! - [`Schedule`], [`Slot`]: what is to start when, in which window, and what has become of it; the dispatcher's rule
//!   `schedule` follows the windows.
//! - [`Scheduler`]: who makes one. [`Builtin`] plays the cell in thought: by rules, by looking ahead, and, where the cell is
//!   small, through all that can be decided, until nothing better can exist.
//! - [`Foreman`]: the dispatcher that has schedules made, follows them, and has them revised.
//! - [`Bar`]: plan against actual, for a Gantt chart.
//!
//! A schedule is made by playing the table that is run, so it never plans what the net forbids; and it is only ever advice:
//! the dispatcher asks for it, the player looks at what the dispatcher says.

mod builtin;
mod foreman;
mod sample;
mod search;
mod slots;
mod timetable;

pub use builtin::Builtin;
pub use foreman::{Foreman, Revision};
pub use slots::{Bar, Schedule, Slot};
pub use timetable::Deviation;

use linewright_line::Tick;

use super::ahead::Thought;
use super::production::Desk;
use super::state::State;

/// What there is to be planned.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// The time.
    pub now: Tick,
    /// The cell.
    pub state: &'a State,
    /// Rules and production orders.
    pub desk: &'a Desk,
    /// What things are imagined with.
    pub thought: &'a Thought,
    /// What was planned before, and what has become of it.
    pub previous: Option<&'a Schedule>,
}

/// Makes schedules. Others than [`Builtin`] may know more of a cell; what they make is followed in the same way.
pub trait Scheduler {
    /// A schedule for what is inside and on order. It has to come to an end within a bound that does not depend on time.
    fn plan(&mut self, situation: &Situation<'_>) -> Schedule;
}
