//! Lower bounds of every schedule, from the ways of parts and from what they compete for.
//!
//! Of every kind of token that comes back by itself (capacities, carriers) it is known how many there are, since parts that
//! hold some give them back: marking, parts and activities in progress always add up to the same number, a P-invariant with
//! one token cell. So the work that is left on such tokens, divided by how many there are, is time that has to pass; and so
//! is the work that is left on any single part. A token for which no such sum exists gives no bound, which is never wrong.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use linewright_line::Tick;

use super::super::dispatch::{PartPriority, ShortestRoutes, shortest, time};
use super::super::firing::ActivityPhase;
use super::super::ids::{CellId, ModeId, TokenDemand};
use super::super::plan::CellKind;
use super::super::production::DispatchConfiguration;
use super::super::state::PartPlace;
use super::super::table::CellTable;
use super::forward_simulation::ForwardSimulation;

/// At most so many numbers of token cells and cells are kept.
const ENTRIES_MAX: usize = 1_000_000;

/// A kind of token that parts hold and give back.
#[derive(Clone, Debug)]
struct SharedResource {
    cell: CellId,
    /// For each cell of parts how many each part on it holds.
    held: Vec<u64>,
    /// For each cell of parts the least token time before a part on it.
    ahead: Vec<Duration>,
}

/// Bounds for a table.
#[derive(Clone, Debug)]
pub(in super::super) struct CostBounds {
    shared: Vec<SharedResource>,
}

/// Basis of forward simulations: the table without orders, and its bounds.
#[derive(Clone, Debug)]
pub struct SimulationBasis {
    table: Arc<CellTable>,
    bounds: Arc<CostBounds>,
}

impl SimulationBasis {
    pub fn new(table: &CellTable) -> Self {
        let table = table.without_orders();
        SimulationBasis { bounds: Arc::new(CostBounds::new(&table)), table: Arc::new(table) }
    }

    /// Table that is played.
    pub fn table(&self) -> &Arc<CellTable> {
        &self.table
    }

    /// Bounds on any future; also used for a simulation that ends early.
    pub(in super::super) fn bounds(&self) -> &CostBounds {
        &self.bounds
    }
}

/// Lower bound of every continuation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in super::super) struct CostBound {
    pub tardiness: u64,
    pub makespan: u64,
}

fn weight_of(tokens: &[TokenDemand], cell: CellId) -> u64 {
    tokens.iter().find(|(of, _)| *of == cell).map_or(0, |&(_, weight)| u64::from(weight))
}

impl SharedResource {
    /// None if the sum does not exist.
    fn new(table: &CellTable, cell: CellId) -> Option<Self> {
        let moved = |mode: ModeId| (weight_of(table.takes(mode), cell), weight_of(table.gives(mode), cell));
        let mut held: Vec<Option<u64>> = vec![None; table.cell_count()];
        let mut open = VecDeque::new();
        let settle =
            |at: CellId, count: u64, held: &mut Vec<Option<u64>>, open: &mut VecDeque<CellId>| match held[at.index()] {
                Some(known) => known == count,
                None => {
                    held[at.index()] = Some(count);
                    open.push_back(at);
                    true
                }
            };
        for mode in table.modes() {
            let (takes, gives) = moved(mode);
            match (table.part_in(mode), table.part_out(mode)) {
                (None, None) if takes != gives => return None,
                (None, Some(to)) if !settle(to, takes.checked_sub(gives)?, &mut held, &mut open) => return None,
                (None, _) | (Some(_), _) => (),
            }
        }
        let parts = table.cells().filter(|&cell| matches!(table.kind(cell), CellKind::Parts(_)));
        for start in parts {
            if held[start.index()].is_none() {
                settle(start, 0, &mut held, &mut open);
            }
            while let Some(from) = open.pop_front() {
                let count = held[from.index()]?;
                for &mode in table.consumers(from).iter().filter(|&&mode| table.part_in(mode) == Some(from)) {
                    let (takes, gives) = moved(mode);
                    let after = (count + takes).checked_sub(gives)?;
                    match table.part_out(mode) {
                        Some(to) if !settle(to, after, &mut held, &mut open) => return None,
                        None if after != 0 => return None,
                        Some(_) | None => (),
                    }
                }
            }
        }
        let held: Vec<u64> = held.into_iter().map(Option::unwrap_or_default).collect();
        let during = |mode: ModeId| -> Duration {
            let before = table.part_in(mode).map_or(0, |from| held[from.index()]);
            let count = before + weight_of(table.takes(mode), cell);
            time(table, mode).saturating_mul(u32::try_from(count).unwrap_or(u32::MAX))
        };
        let ahead = shortest(table, |mode| Some(during(mode)));
        Some(SharedResource { cell, ahead, held })
    }

    fn during(&self, table: &CellTable, mode: ModeId) -> u64 {
        let before = table.part_in(mode).map_or(0, |from| self.held[from.index()]);
        before + weight_of(table.takes(mode), self.cell)
    }

    /// Least time for which these tokens are needed from now on.
    fn need(&self, simulation: &ForwardSimulation, desk: &DispatchConfiguration) -> Duration {
        let (state, table) = (simulation.state(), simulation.state().table());
        let mut has = state.marking().count(self.cell);
        let mut need = Duration::ZERO;
        for part in state.parts() {
            if let PartPlace::On { cell, arrival: _ } = part.place {
                has += self.held[cell.index()];
                need += self.ahead[cell.index()];
            }
        }
        for firing in state.firings() {
            match firing.phase {
                // It keeps what it has.
                ActivityPhase::Failed(_) => continue,
                ActivityPhase::Running => (),
            }
            let during = self.during(table, firing.mode);
            has += during;
            let end = firing.due(table.activity(firing.mode)).unwrap_or(simulation.now());
            need += end.since(simulation.now()).saturating_mul(u32::try_from(during).unwrap_or(u32::MAX));
            need += table.part_out(firing.mode).map_or(Duration::ZERO, |to| self.ahead[to.index()]);
        }
        for order in desk.production().into_iter().flat_map(|production| production.missing()) {
            let entrances = desk.production().into_iter().flat_map(|production| production.entrances(order.product));
            let one = entrances.map(|mode| {
                let after = table.part_out(mode).map_or(Duration::ZERO, |to| self.ahead[to.index()]);
                let during = u32::try_from(self.during(table, mode)).unwrap_or(u32::MAX);
                time(table, mode).saturating_mul(during) + after
            });
            need += one.min().unwrap_or_default().saturating_mul(order.missing());
        }
        // Where none is left there is no bound on the time it takes.
        u32::try_from(has).ok().filter(|&has| has > 0).map_or(Duration::ZERO, |has| need / has)
    }
}

impl CostBounds {
    /// Of a table. A cell too large for it has the bounds of its parts alone.
    pub fn new(table: &CellTable) -> Self {
        let tokens: Vec<CellId> = table.cells().filter(|&cell| table.kind(cell) == CellKind::Tokens).collect();
        let fits = tokens.len().saturating_mul(table.cell_count()) <= ENTRIES_MAX;
        let tokens = tokens.into_iter().filter(|_| fits);
        CostBounds { shared: tokens.filter_map(|cell| SharedResource::new(table, cell)).collect() }
    }

    /// Least time until nothing is left to be done.
    pub fn need(&self, simulation: &ForwardSimulation, desk: &DispatchConfiguration) -> Duration {
        self.shared.iter().map(|shared| shared.need(simulation, desk)).max().unwrap_or_default()
    }

    /// Lower bound of every continuation, in the measures of [`super::Score`].
    pub fn bound(&self, simulation: &ForwardSimulation, desk: &DispatchConfiguration) -> CostBound {
        let (state, table, ways) = (simulation.state(), simulation.state().table(), desk.rules.ways());
        let micros = |span: Duration| u64::try_from(span.as_micros()).unwrap_or(u64::MAX);
        let mut bound = CostBound { tardiness: 0, makespan: 0 };
        let (began, now) = (simulation.began(), simulation.now());
        let mut finish = |job: PartPriority, at: Tick, count: u32| {
            let late = job.due.map_or(Duration::ZERO, |due| at.since(due));
            let late = micros(late).saturating_mul(weight(&job)).saturating_mul(u64::from(count));
            bound.tardiness = bound.tardiness.saturating_add(late);
            bound.makespan = bound.makespan.max(micros(at.since(began)));
        };
        simulation.left().iter().for_each(|&(job, at)| finish(job, at, 1));
        for part in state.parts() {
            let at = match part.place {
                PartPlace::On { cell, arrival: _ } if is_last(table, cell) => part.since,
                PartPlace::On { cell, arrival: _ } => now + ways.remaining(cell),
                PartPlace::In(firing) => {
                    let Some(firing) = state.firing(firing) else { continue };
                    // What has failed is as late as it is, whatever else is done.
                    let Some(end) = firing.due(table.activity(firing.mode)) else { continue };
                    end + table.part_out(firing.mode).map_or(Duration::ZERO, |cell| ways.remaining(cell))
                }
            };
            finish(desk.job(part.id), at, 1);
        }
        for order in desk.production().into_iter().flat_map(|production| production.missing()) {
            finish(order.job(), now + entering(desk, table, ways, order.product), order.missing());
        }
        let need = self.need(simulation, desk);
        bound.makespan = bound.makespan.max(micros((now + need).since(began)));
        bound
    }
}

/// Whether nothing takes a part on from there.
pub(in super::super) fn is_last(table: &CellTable, cell: CellId) -> bool {
    table.consumers(cell).is_empty()
}

/// The work on a part of a product that has still to enter.
pub(in super::super) fn entering(
    desk: &DispatchConfiguration,
    table: &CellTable,
    ways: &ShortestRoutes,
    product: usize,
) -> Duration {
    let modes = desk.production().into_iter().flat_map(|production| production.entrances(product));
    let work =
        modes.map(|mode| time(table, mode) + table.part_out(mode).map_or(Duration::ZERO, |to| ways.remaining(to)));
    work.min().unwrap_or_default()
}

/// Weight of a part's tardiness.
pub(in super::super) fn weight(job: &PartPriority) -> u64 {
    1 + u64::try_from(job.priority).unwrap_or(0)
}
