//! Looking ahead: the same cell, played in thought from where it is now.
//!
//! # Map
//! - [`Thought`]: what it takes to imagine a cell, made once.
//! - [`Imagined`]: a copy of the cell's state that goes on without stations, by nominal times, until a horizon; it changes by
//!   records as the real one does.
//! - [`Lead`]: who decides there: the rules as ever ([`Desk`](super::production::Desk)), one other decision and then the
//!   rules ([`Otherwise`]), or a plan ([`Follow`]).
//! - [`Score`]: what has come of it.
//! - [`LookAhead`]: the dispatcher that tries out each decision before it makes it.
//!
//! How much is thought is counted in firings: the same question has the same answer on every machine, however slow. What is
//! played is the compiled table, the one that was checked and is run; nothing of the cell is modelled a second time.

mod bounds;
mod imagined;
mod lead;
mod look_ahead;
mod score;

pub(super) use bounds::Bound;
pub use bounds::Thought;
pub use imagined::{Act, Ending, Imagined};
pub use lead::{Choice, Follow, Lead, Otherwise, PlannedStart};
pub use look_ahead::{EFFORT, LookAhead};
pub use score::Score;
pub(super) use score::weight;
