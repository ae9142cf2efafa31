//! A described cell that is really played, by the token player, with stations that take exactly the times given.
//!
//! Real times can differ from those of the dispatcher, since it plans by the description and not by this.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use linewright_cell::Cell;
use linewright_cell::net::Supply;
use linewright_coordinator_cell::compile::{CompiledCell, OrderTiming, compile_cell};
use linewright_coordinator_cell::production::{Production, ProductionChange, ProductionOrderRequest};
use linewright_coordinator_cell::{
    CellMessage, CellTable, Coordination, Dispatcher, ModeId, OrderKey, PartId, PlayerInput, PlayerOutbox, PlayerState,
    ProductionCommand, ProductionCommandError, ProductionId, Record, RecordKind, TaskOutcome, TaskReply, TaskReport,
};
use linewright_line::{StationId, Tick};
use linewright_orders::TaskFailure;

pub const C1: &str = include_str!("../../../../launch-config/lines/workcell-c1/cell.toml");
pub const ASSEMBLY: &str = include_str!("../../../../launch-config/lines/assembly-cell/cell.toml");

/// A cell and what is played of it.
pub struct Made {
    pub cell: Cell,
    pub made: CompiledCell,
    pub table: Arc<CellTable>,
}

impl Made {
    pub fn new(text: &str) -> Self {
        let cell =
            linewright_cell::parse("cell.toml", text, None).unwrap_or_else(|problems| panic!("{problems:#}")).cell;
        let pace = OrderTiming { repeat_interval: Duration::from_millis(200), grace: Duration::from_secs(1) };
        let made = compile_cell(&cell, None, Supply::Open, pace).unwrap_or_else(|why| panic!("{why}"));
        let table = Arc::new(made.table.clone());
        Made { cell, made, table }
    }

    pub fn mode(&self, name: &str) -> ModeId {
        let named = |&mode: &ModeId| self.table.mode_name(mode) == name;
        self.table.modes().find(named).unwrap_or_else(|| panic!("no mode {name}"))
    }

    /// The cell with orders of so many parts of each product, in this order, due after so many seconds.
    pub fn with(&self, orders: &[(&str, u32, Option<u64>)]) -> PlayerState {
        let mut state = PlayerState::new(self.table.clone());
        let requests: Vec<ProductionOrderRequest> = (1..).zip(orders).map(|(key, of)| request(key, of)).collect();
        for change in state.production().submit(&requests).unwrap() {
            state.apply(&changed(Tick::ZERO, change)).unwrap();
        }
        state
    }

    /// Those orders alone.
    pub fn ordered(&self, orders: &[(&str, u32, Option<u64>)]) -> Production {
        self.with(orders).production().clone()
    }
}

/// Record of a change.
pub fn changed(at: Tick, change: ProductionChange) -> Record {
    Record { at, fact: RecordKind::Production { change } }
}

pub fn request(key: u128, &(product, quantity, due): &(&str, u32, Option<u64>)) -> ProductionOrderRequest {
    ProductionOrderRequest {
        key,
        name: format!("order {key}"),
        product: product.to_owned(),
        quantity,
        due: due.map(|seconds| Tick::from_millis(seconds * 1000)),
        ..ProductionOrderRequest::default()
    }
}

/// A cell in which something happens.
pub struct Shop {
    pub table: Arc<CellTable>,
    pub player: Coordination,
    pub log: Vec<Record>,
    pub now: Tick,
    /// Real time of orders of a mode, if not the nominal one.
    pub really: BTreeMap<ModeId, Duration>,
    /// Failures of an order of a mode before it succeeds.
    pub fails: BTreeMap<ModeId, usize>,
    doing: BTreeMap<(Tick, OrderKey), (StationId, TaskOutcome)>,
}

impl Shop {
    pub fn new(table: &Arc<CellTable>) -> Self {
        Shop::begin(PlayerState::new(table.clone()))
    }

    /// One in which something has happened already.
    pub fn begin(state: PlayerState) -> Self {
        let (mut out, table) = (PlayerOutbox::default(), state.table().clone());
        let player = Coordination::begin(state, Tick::ZERO, 1, &mut out).unwrap();
        Shop {
            table,
            player,
            log: out.records,
            now: Tick::ZERO,
            really: BTreeMap::new(),
            fails: BTreeMap::new(),
            doing: BTreeMap::new(),
        }
    }

    pub fn state(&self) -> &PlayerState {
        self.player.state()
    }

    /// Another life of the coordinator, from a state. Stations go on.
    pub fn restart(&mut self, state: PlayerState) {
        let (mut out, epoch) = (PlayerOutbox::default(), state.epoch() + 1);
        self.player = Coordination::begin(state, self.now, epoch, &mut out).unwrap();
        self.log.extend(out.records);
    }

    /// A change of production orders.
    pub fn command(
        &mut self,
        command: ProductionCommand<'_>,
        dispatcher: &mut dyn Dispatcher,
    ) -> Result<Vec<ProductionId>, ProductionCommandError> {
        let mut out = PlayerOutbox::default();
        self.player.step(
            self.now,
            &[PlayerInput::Starts(false), PlayerInput::Production(3, command)],
            dispatcher,
            &mut out,
        );
        self.log.extend(out.records);
        assert_eq!((out.replies.len(), out.replies[0].0, out.sends.len()), (1, 3, 0));
        out.replies.remove(0).1
    }

    fn stations(&self) -> impl Iterator<Item = StationId> {
        let orders = self.table.modes().flat_map(|mode| &self.table.activity(mode).orders);
        let all: std::collections::BTreeSet<StationId> = orders.map(|order| order.station).collect();
        all.into_iter()
    }

    /// Plays until a time, or until nothing will happen any more.
    pub fn run(&mut self, dispatcher: &mut dyn Dispatcher, until: Tick) {
        let heard = TaskReport { memory: 1, ..TaskReport::default() };
        let mut inputs: Vec<PlayerInput<'_>> = vec![PlayerInput::Starts(true)];
        inputs.extend(self.stations().map(|station| PlayerInput::Station(station, &heard)));
        loop {
            let mut out = PlayerOutbox::default();
            self.player.step(self.now, &inputs, dispatcher, &mut out);
            assert_eq!(out.events, [], "every answer could be followed");
            self.log.extend(out.records);
            inputs.clear();
            for send in out.sends {
                let order = match send {
                    CellMessage::Order(order) => order,
                    CellMessage::Secure { station, key, way } => {
                        inputs.push(PlayerInput::Secured(
                            station,
                            key,
                            way,
                            TaskReply::Ended(TaskOutcome::Failed(TaskFailure::Waiting(7))),
                        ));
                        continue;
                    }
                };
                let (firing, _) = self.player.state().order(order.order.key).unwrap();
                let kind = self.table.activity(firing.mode).kind;
                let linewright_coordinator_cell::ActivityTiming::Decided { time, .. } = kind else { unreachable!() };
                let takes = self.really.get(&firing.mode).copied().unwrap_or(time);
                let fails = self.fails.get_mut(&firing.mode).filter(|left| **left > 0);
                let outcome = fails.map_or(TaskOutcome::Done, |left| {
                    *left -= 1;
                    TaskOutcome::Failed(TaskFailure::Waiting(7))
                });
                let key = (firing.began + takes, order.order.key);
                self.doing.insert(key, (order.station, outcome));
                inputs.push(PlayerInput::Reply(order.station, order.order.key, TaskReply::Running));
            }
            if !inputs.is_empty() {
                continue;
            }
            let ends = self.doing.keys().next().map(|&(at, _)| at);
            let Some(next) = ends.into_iter().chain(self.player.next_deadline()).min() else { return };
            if next > until || next == Tick::NEVER {
                self.now = self.now.max(until);
                return;
            }
            self.now = self.now.max(next);
            while let Some(entry) = self.doing.first_entry().filter(|entry| entry.key().0 <= self.now) {
                let (_, key) = *entry.key();
                let (station, outcome) = entry.remove();
                inputs.push(PlayerInput::Reply(station, key, TaskReply::Ended(outcome)));
            }
        }
    }

    /// Times of all starts, in ms, with modes and parts.
    pub fn starts(&self) -> Vec<(u64, &str, Option<PartId>)> {
        let started = self.log.iter().filter_map(|record| match record.fact {
            RecordKind::Started { mode, part, .. } => {
                Some((record.at.as_micros() / 1000, self.table.mode_name(mode), part))
            }
            _ => None,
        });
        started.collect()
    }

    /// End of the last activity.
    pub fn makespan(&self) -> Tick {
        let ends = self.log.iter().filter(|record| matches!(record.fact, RecordKind::Ended { .. }));
        ends.map(|record| record.at).max().unwrap_or(Tick::ZERO)
    }
}
