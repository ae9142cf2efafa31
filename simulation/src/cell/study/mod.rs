//! A cell and a scenario, simulated often enough for an estimate.
//!
//! ```text
//!   scenario ──▶ Course: orders come, stations break down ──▶ CellSim ──▶ records ──▶ figures of one replication
//!                                                                                        │ as many as asked for, in threads
//!                                                                                        ▼
//!                                                              mean ± half width, by [`super::Estimate`]
//! ```
//!
//! Replications differ in their seed alone and share nothing, so it does not matter how many are played at once. Everything
//! random has a stream of its own by name, so replication 3 of one variant of a cell meets the same breakdowns as
//! replication 3 of another, and a difference between the two is one of the cells.

mod course;
mod figures;
mod play;
mod several;

use std::sync::Arc;
use std::time::Duration;

use linewright_cell::net::Supply;
use linewright_cell::{Cell, ResourceId};
use linewright_coordinator_cell::CellTable;
use linewright_coordinator_cell::compile::{CompiledCell, OrderTiming, Unplayable, compile_cell};
use linewright_coordinator_cell::schedule::ScheduleFollower;
use linewright_line::{Line, Tick};
use linewright_random::mix;

use super::scenario::CellScenario;
use super::sim::CellSim;

pub use figures::{OrderFigures, ReplicationFigures, ResourceFigures};
pub use several::ReplicationGoal;

/// Nothing is lost, so nothing is repeated, and the coordinator is not killed.
pub const UNDISTURBED: OrderTiming =
    OrderTiming { repeat_interval: Duration::from_secs(3600), grace: Duration::from_secs(10) };
/// Period of the reports of stations whose states do not change.
pub const UNCHANGED: Duration = Duration::from_secs(86_400);
/// Time limit of an order: what stands is repaired and goes on, so no time limit of the description counts.
const NO_LIMIT: Duration = Duration::from_secs(3_000_000_000);

/// Options of a study, beside its scenario.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StudyOptions {
    /// Seed of everything random.
    pub seed: u64,
    /// Delay of a message, least and most.
    pub delay: (Duration, Duration),
    /// Where the scenario draws no times: longest deviation from the described time, as a fraction.
    pub spread: f64,
    /// By look-ahead and schedule of the description, and not by its rules alone.
    pub planned: bool,
}

/// A cell with its production.
pub struct CellStudy {
    cell: Cell,
    scenario: CellScenario,
    options: StudyOptions,
    played: CompiledCell,
    table: Arc<CellTable>,
    stations: usize,
}

/// One replication, played.
pub struct PlayedReplication {
    pub sim: CellSim,
    /// Schedule it followed, if it was planned.
    pub plan: Option<ScheduleFollower>,
    /// Standstills of resources, in the order of their repairs.
    pub stood: Vec<Standstill>,
    /// End of the observation.
    pub end: Tick,
    /// Reason why it ended before its time, if it did.
    pub problem: Option<StudyProblem>,
}

/// A resource stood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standstill {
    pub resource: ResourceId,
    pub from: Tick,
    pub to: Tick,
}

/// Reason why a replication ended before its time.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StudyProblem {
    /// More is ordered than the cell makes.
    #[error("{open} orders are open after {at_s:.0} s: orders come faster than the cell makes them")]
    TooManyOrders { open: usize, at_s: f64 },
    #[error("an order was refused after {at_s:.0} s: {why}")]
    Refused { why: String, at_s: f64 },
    #[error("endless loop of activities without duration at {at_s:.3} s, last `{activity}`: give it a `time_s`")]
    Spins { activity: String, at_s: f64 },
    #[error("{left} parts finished, {inside} are inside; no further event after {at_s:.3} s")]
    Stuck { left: u64, inside: usize, at_s: f64 },
}

impl CellStudy {
    /// A cell, and its production. Stations are those of `line`, or else those that the cell names. Its time limits do not
    /// count.
    ///
    /// # Errors
    /// Reasons why the cell cannot be played.
    pub fn new(
        cell: &Cell,
        line: Option<&Line>,
        scenario: CellScenario,
        options: StudyOptions,
    ) -> Result<Self, Unplayable> {
        let mut cell = cell.clone();
        let orders = cell.activities.iter_mut().flat_map(|activity| &mut activity.orders);
        orders.for_each(|order| order.limit = Some(NO_LIMIT));
        let played = compile_cell(&cell, line, Supply::Open, UNDISTURBED)?;
        let stations = line.map_or(cell.controllers.len(), |line| line.stations.len());
        let table = Arc::new(played.table.clone());
        Ok(CellStudy { cell, scenario, options, played, table, stations })
    }

    pub fn cell(&self) -> &Cell {
        &self.cell
    }

    pub fn scenario(&self) -> &CellScenario {
        &self.scenario
    }

    pub fn played(&self) -> &CompiledCell {
        &self.played
    }

    /// Seed of a replication.
    fn seed_of(&self, replication: usize) -> u64 {
        mix(self.options.seed).wrapping_add(replication as u64)
    }
}
