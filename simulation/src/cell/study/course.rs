//! External events of a cell in one replication, with times: orders, failures and repairs.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use linewright_cell::{Cell, ResourceId};
use linewright_coordinator_cell::production::{ProductionOrderRequest, QUANTITY_MAX};
use linewright_line::Tick;

use super::super::distribution::Distribution;
use super::super::scenario::{
    BreakdownPattern, CellScenario, FailureClock, OrderArrivals, ScriptedFault, StationFault,
};
use crate::rng::Rng;

/// Keys of orders that come begin here; those of the scenario's own list are below.
const KEYS: u128 = 1 << 64;

/// Reason why a resource stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum StandstillCause {
    Breakdown(usize),
    Script,
}

/// Next event.
pub(super) enum CourseEvent {
    /// An order comes.
    Order(ProductionOrderRequest),
    /// A resource breaks down or is repaired, or has to be looked at: something may follow of
    /// [`Course::stands`] and [`Course::is_left_out`].
    Resource(ResourceId),
}

/// External events.
pub(super) struct Course {
    arrivals: Vec<ArrivalStream>,
    breakdowns: Vec<BreakdownStream>,
    script: VecDeque<ScriptedFault>,
    /// Reasons why each resource stands, and whether the coordinator has each.
    standing: BTreeMap<ResourceId, BTreeMap<StandstillCause, bool>>,
    made: u128,
}

struct ArrivalStream {
    of: OrderArrivals,
    /// Time of the next one; none after the last.
    next: Option<Tick>,
    made: u64,
    every: Rng,
    due: Rng,
}

struct BreakdownStream {
    of: BreakdownPattern,
    state: BreakdownState,
    between: Rng,
    repair: Rng,
}

enum BreakdownState {
    /// By the calendar it fails then.
    Fails(Tick),
    /// It fails when its station has worked for so long in all; not before `look`.
    Works { fails_at: Duration, look: Tick },
    /// It is repaired then.
    Down(Tick),
}

impl BreakdownState {
    fn next(&self) -> Tick {
        match *self {
            BreakdownState::Fails(at) | BreakdownState::Works { look: at, .. } | BreakdownState::Down(at) => at,
        }
    }
}

impl Course {
    /// Each from a stream of its own name.
    pub fn new(cell: &Cell, scenario: &CellScenario, seed: u64) -> Self {
        let arrivals = scenario.arrivals.iter().map(|of| {
            let mut every = Rng::named(seed, &format!("arrivals/{}", of.name));
            let next = of.first.unwrap_or_else(|| Tick::ZERO + of.every.draw_seconds(&mut every));
            let due = Rng::named(seed, &format!("due/{}", of.name));
            ArrivalStream { of: of.clone(), next: Some(next).filter(|at| *at <= of.until), made: 0, every, due }
        });
        let breakdowns = scenario.breakdowns.iter().map(|of| {
            let name = format!("{}/{}", cell.resource(of.resource).name, of.name);
            let mut between = Rng::named(seed, &format!("failure/{name}"));
            let repair = Rng::named(seed, &format!("repair/{name}"));
            let state = up(of, &mut between, Tick::ZERO, Duration::ZERO);
            BreakdownStream { of: of.clone(), state, between, repair }
        });
        Course {
            arrivals: arrivals.collect(),
            breakdowns: breakdowns.collect(),
            script: scenario.faults.iter().copied().collect(),
            standing: BTreeMap::new(),
            made: 0,
        }
    }

    /// Time of the next event; none if there is none.
    pub fn next(&self) -> Option<Tick> {
        let arrive = self.arrivals.iter().filter_map(|stream| stream.next);
        let fail = self.breakdowns.iter().map(|stream| stream.state.next());
        arrive.chain(fail).chain(self.script.front().map(|fault| fault.at)).min()
    }

    /// Whether no order and nothing of the script will come.
    pub fn is_over(&self) -> bool {
        self.script.is_empty() && self.arrivals.iter().all(|stream| stream.next.is_none())
    }

    /// Whether anything is being repaired.
    pub fn repairs(&self) -> bool {
        self.breakdowns.iter().any(|stream| matches!(stream.state, BreakdownState::Down(_)))
    }

    /// Takes what is due at `now`, one thing after the other: repairs and failures, the script, orders. `worked` is how
    /// long the station of a resource has worked so far.
    pub fn take(&mut self, now: Tick, mut worked: impl FnMut(ResourceId) -> Duration) -> Option<CourseEvent> {
        if let Some(index) = self.breakdowns.iter().position(|stream| stream.state.next() <= now) {
            let resource = self.breakdowns[index].of.resource;
            let cause = StandstillCause::Breakdown(index);
            match self.breakdowns[index].go_on(now, worked(resource)) {
                Some(true) => self.stand(resource, cause, true),
                Some(false) => self.clear(resource, cause),
                None => (),
            }
            return Some(CourseEvent::Resource(resource));
        }
        if let Some(fault) = self.script.pop_front_if(|fault| fault.at <= now) {
            match fault.fault {
                StationFault::Break => self.stand(fault.resource, StandstillCause::Script, true),
                StationFault::Stick => self.stand(fault.resource, StandstillCause::Script, false),
                StationFault::Clear => self.clear(fault.resource, StandstillCause::Script),
            }
            return Some(CourseEvent::Resource(fault.resource));
        }
        let stream = self.arrivals.iter_mut().find(|stream| stream.next.is_some_and(|next| next <= now))?;
        self.made += 1;
        Some(CourseEvent::Order(stream.take(now, KEYS + self.made)))
    }

    fn stand(&mut self, resource: ResourceId, cause: StandstillCause, known: bool) {
        self.standing.entry(resource).or_default().insert(cause, known);
    }

    fn clear(&mut self, resource: ResourceId, cause: StandstillCause) {
        if let Some(causes) = self.standing.get_mut(&resource) {
            causes.remove(&cause);
        }
    }

    /// Whether a resource stands.
    pub fn stands(&self, resource: ResourceId) -> bool {
        self.standing.get(&resource).is_some_and(|causes| !causes.is_empty())
    }

    /// Whether it is known to stand, so that nothing is ordered of it.
    pub fn is_left_out(&self, resource: ResourceId) -> bool {
        self.standing.get(&resource).is_some_and(|causes| causes.values().any(|&known| known))
    }
}

impl ArrivalStream {
    fn take(&mut self, now: Tick, key: u128) -> ProductionOrderRequest {
        self.made += 1;
        let next = now + self.of.every.draw_seconds(&mut self.every).max(Duration::from_micros(1));
        self.next = Some(next).filter(|at| *at <= self.of.until && self.made < self.of.count);
        let after = self.of.due_after.map(|after: Distribution| after.draw_seconds(&mut self.due));
        ProductionOrderRequest {
            key,
            name: format!("{} {}", self.of.name, self.made),
            product: self.of.product.clone(),
            quantity: self.of.quantity.min(QUANTITY_MAX),
            release: None,
            due: after.map(|after| now + after),
            priority: self.of.priority,
            after: Vec::new(),
        }
    }
}

impl BreakdownStream {
    /// Its time has come: whether it fails or is repaired; none if it is only later that it fails.
    fn go_on(&mut self, now: Tick, worked: Duration) -> Option<bool> {
        match self.state {
            BreakdownState::Works { fails_at, .. } if worked < fails_at => {
                // Not before it has worked all the time from now on.
                self.state = BreakdownState::Works { fails_at, look: now + (fails_at - worked) };
                None
            }
            BreakdownState::Fails(_) | BreakdownState::Works { .. } => {
                self.state = BreakdownState::Down(now + self.of.repair.draw_seconds(&mut self.repair));
                Some(true)
            }
            BreakdownState::Down(_) => {
                self.state = up(&self.of, &mut self.between, now, worked);
                Some(false)
            }
        }
    }
}

/// It works again, until it fails the next time.
fn up(of: &BreakdownPattern, between: &mut Rng, now: Tick, worked: Duration) -> BreakdownState {
    let time = of.between.draw_seconds(between).max(Duration::from_micros(1));
    match of.clock {
        FailureClock::Calendar => BreakdownState::Fails(now + time),
        FailureClock::Operating => BreakdownState::Works { fails_at: worked + time, look: now + time },
    }
}
