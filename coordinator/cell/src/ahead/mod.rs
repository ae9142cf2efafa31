//! Looking ahead: forward simulation of the cell from its present state.
//!
//! # Map
//! - [`SimulationBasis`]: table and bounds for forward simulations, made once.
//! - [`ForwardSimulation`]: a copy of the cell's state that goes on without stations, by nominal times, until a horizon; it changes by
//!   records as the real one does.
//! - [`RolloutPolicy`]: what decides there: the rules ([`DispatchConfiguration`](super::production::DispatchConfiguration)),
//!   one other decision and then the rules ([`DeviatingPolicy`]), or a plan ([`PlanPolicy`]).
//! - [`Score`]: the measures of a simulated future.
//! - [`LookAhead`]: the dispatcher that tries out each decision before it makes it.
//!
//! Effort is counted in firings: the same question has the same answer on every machine, however slow. What is
//! played is the compiled table, the one that was checked and is run; nothing of the cell is modelled a second time.

mod bounds;
mod forward_simulation;
mod look_ahead;
mod rollout_policy;
mod score;

pub(super) use bounds::CostBound;
pub use bounds::SimulationBasis;
pub(super) use bounds::weight;
pub use forward_simulation::{Ending, ForwardSimulation, SimulatedActivity};
pub use look_ahead::{EFFORT, LookAhead};
pub use rollout_policy::{DeviatingPolicy, PlanPolicy, PlannedStart, PolicyChoice, RolloutPolicy};
pub use score::Score;
