//! A scenario of a cell as text: what it has to make, what takes longer or breaks down by chance, and how often it is
//! simulated.
//!
//! TOML, read like a description: all problems at once, each with its place and advice, and the names of the cell checked
//! while reading. What comes out is a [`CellScenario`], which has no text.

mod raw;
mod resolve;

use std::time::Duration;

use linewright_cell::{ActivityId, Cell, ResourceId};
use linewright_coordinator_cell::production::ProductionOrderRequest;
use linewright_line::{Problems, Tick};
use linewright_text::{Keys, Report, Shape};

use super::distribution::Distribution;

pub use raw::{FailureClock, PRECISION_PERCENT, REPLICATIONS_MAX};

/// Orders and events of a cell in a simulation.
#[derive(Clone, Debug)]
pub struct CellScenario {
    pub title: Option<String>,
    /// Duration of a replication; by default until all orders are done.
    pub duration: Option<Duration>,
    /// Time at the beginning that counts in no figure.
    pub warm_up: Duration,
    /// Number of replications; the least, where a precision is given.
    pub replications: Option<usize>,
    /// Precision of figures to be reached, as a fraction.
    pub precision: Option<f64>,
    /// Between 0 and 1.
    pub confidence: f64,
    /// Known from the beginning.
    pub orders: Vec<ProductionOrderRequest>,
    pub arrivals: Vec<OrderArrivals>,
    /// Factor of the described time, for each activity whose time is drawn.
    pub times: Vec<(ActivityId, Distribution)>,
    pub breakdowns: Vec<BreakdownPattern>,
    /// In the order of their times.
    pub faults: Vec<ScriptedFault>,
}

/// Orders that come one after the other.
#[derive(Clone, Debug)]
pub struct OrderArrivals {
    /// Name of its orders, followed by a number.
    pub name: String,
    pub product: String,
    pub quantity: u32,
    /// Seconds from one to the next.
    pub every: Distribution,
    /// Time of the first one; by default after the first time between two.
    pub first: Option<Tick>,
    /// None comes later.
    pub until: Tick,
    /// Number of orders.
    pub count: u64,
    /// Seconds from the coming of an order until it is due.
    pub due_after: Option<Distribution>,
    pub priority: i32,
}

/// A resource that breaks down by chance.
#[derive(Clone, Debug)]
pub struct BreakdownPattern {
    pub resource: ResourceId,
    /// Name of the stream, with the resource that breaks.
    pub name: String,
    /// Seconds from a repair to the next failure.
    pub between: Distribution,
    /// Seconds from a failure to the end of its repair.
    pub repair: Distribution,
    pub clock: FailureClock,
}

/// Something that happens to a resource at a certain time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScriptedFault {
    pub at: Tick,
    pub resource: ResourceId,
    pub fault: StationFault,
}

/// Effect of a scenario on the station of a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StationFault {
    /// It stands, and that is known: the resource is left out until it is repaired.
    Break,
    /// It stands, and this is not known: it is ordered to work as before, and its orders wait.
    Stick,
    /// It works again.
    Clear,
}

impl Default for CellScenario {
    /// Nothing is ordered, nothing fails, and everything takes as long as it should.
    fn default() -> Self {
        CellScenario {
            title: None,
            duration: None,
            warm_up: Duration::ZERO,
            replications: None,
            precision: None,
            confidence: raw::CONFIDENCE / 100.0,
            orders: Vec::new(),
            arrivals: Vec::new(),
            times: Vec::new(),
            breakdowns: Vec::new(),
            faults: Vec::new(),
        }
    }
}

impl CellScenario {
    /// Reads the scenario `text` for `cell`; `file_name` is for messages.
    ///
    /// # Errors
    /// All problems of the text at once, each with its place.
    pub fn parse(cell: &Cell, file_name: &str, text: &str) -> Result<Self, Problems> {
        let mut report = Report::default();
        let is_bounded = linewright_text::is_bounded(text, "the scenario", &mut report);
        let raw = if is_bounded { raw::read(text, &mut report) } else { None };
        let scenario = raw.map(|raw| resolve::resolve(cell, &raw, &mut report));
        let (scenario, _) = report.close(scenario, file_name, text)?;
        Ok(scenario)
    }

    /// Keys of a scenario of a cell, with types and bounds.
    pub fn schema() -> Shape {
        raw::RawCellScenario::shape()
    }

    /// Whether any order is in it.
    pub fn has_orders(&self) -> bool {
        !self.orders.is_empty() || !self.arrivals.is_empty()
    }
}

/// A moment so many seconds after the beginning.
fn moment(seconds: f64) -> Tick {
    Tick::ZERO + Duration::from_secs_f64(seconds)
}
