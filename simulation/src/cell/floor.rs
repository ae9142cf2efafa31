//! The shop floor of a cell: the real controllers of its stations, and the plant with parts behind them.
//!
//! Orders come and whole states go as with pretended stations; between the order and the part stands the code that runs in a
//! plant. Images reach controllers at once, and outputs the plant; other tests cover that simplification. Simulated people
//! put parts in and take them out by the records, and use nothing else: from there on the parts are the truth, which no
//! controller and no coordinator sees.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use linewright_cell::Cell;
use linewright_coordinator_cell::{
    ActivityStep, CellTable, FiringId, ModeId, OrderKey, OrderMessage, PartId, PartPlace, PlayerState, Record,
    TaskReply, TaskReport,
};
use linewright_coordinator_shell::orders;
use linewright_line::net::ControlMode;
use linewright_line::{HolderId, Line, OpId, Owner, StationId, Tick};
use linewright_orders::LeaveWay;
use linewright_plant::{NestPosition, PartNo, Plant, PlantOptions};
use linewright_station_logic::{
    self as station, CompileError, Controller, ModeOrder, NO_DELAY, OrderRules, PanelCommand, RejoinAt, Restore,
    StationInput, StationSnapshot, TaskCommand, TaskOrder, TaskOrderReport,
};

/// Stations answer each other's motions so often at one moment at most.
const PASSES_MAX: usize = 100;
/// More motions than any task has.
const LED_MAX: usize = 100;
/// Longer than any motion takes.
const HELD: Duration = Duration::from_secs(6);
const PRESSED_EVERY: Duration = Duration::from_millis(50);

/// Something that was really done to a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Work {
    /// The part that lay there, if there was one.
    pub part: Option<PartId>,
    pub station: StationId,
    /// The operation that was complete.
    pub op: OpId,
    /// The numbers that stood on its outputs meanwhile.
    pub numbers: Vec<i32>,
}

/// A station's process.
struct Running {
    controller: Controller,
    out: station::StationOutbox,
    /// Last image it received.
    image: Option<u128>,
    /// Its last report.
    said: TaskOrderReport,
    /// Its journal while it is down, and when its outputs go off then.
    down: Option<(StationSnapshot, Tick)>,
}

pub struct ShopFloor {
    line: Line,
    plant: Plant,
    processes: Vec<Running>,
    now: Tick,
    lives: u64,
    order_rules: OrderRules,
    /// The mode of all stations, but for those that are in emergency stop by themselves.
    order: ModeOrder,
    stopped: BTreeSet<StationId>,
    /// By store of the table.
    stores: Vec<HolderId>,
    /// By the name of a resource that is no store: where it has its part.
    nests: BTreeMap<String, HolderId>,
    firings: BTreeMap<FiringId, (ModeId, Option<PartId>)>,
    watched: Vec<(StationId, OpId, HolderId, bool)>,
    /// By so much the time of an order is over sooner than it was given: the clocks of stations run fast.
    pub fast: Duration,
    /// Work done on parts, in order.
    pub done: Vec<Work>,
    /// The parts that people have taken out, in order.
    pub left: Vec<PartId>,
    /// Actions of people that were impossible.
    pub trouble: Vec<String>,
}

/// Where each resource that is no store has its part: the nest of its station.
pub fn nests<'c>(cell: &'c Cell, line: &Line) -> Vec<(&'c str, HolderId)> {
    let stations = cell.resources.iter().filter_map(|resource| {
        let station = &cell.controllers[resource.controller?.index()];
        let mine = |name: &str| name.strip_prefix(station.as_str()).is_some_and(|rest| rest.starts_with('.'));
        let holders = &line.handling.holders;
        let nest = holders.iter().position(|holder| mine(&holder.name) && !holder.is_hand())?;
        Some((resource.name.as_str(), HolderId::at(nest)))
    });
    stations.collect()
}

impl ShopFloor {
    /// All stations at home, in auto, and no part anywhere. Of each resource that is no store, where it has its part.
    ///
    /// # Errors
    /// When a station does not compile.
    pub fn new(
        line: &Line,
        table: &CellTable,
        nests: &[(&str, HolderId)],
        options: PlantOptions,
    ) -> Result<Self, CompileError> {
        let mut floor = ShopFloor {
            plant: Plant::new(line, options),
            processes: Vec::new(),
            now: Tick::ZERO,
            lives: 0,
            order_rules: OrderRules::default(),
            order: ModeOrder { manual_all: true, ..ModeOrder::of(1, 1, ControlMode::Auto, ModeOrder::FOR_GOOD) },
            stopped: BTreeSet::new(),
            stores: table.stores().iter().filter_map(|store| line.handling.holder_named(&store.name)).collect(),
            nests: nests.iter().map(|(name, nest)| ((*name).to_owned(), *nest)).collect(),
            firings: BTreeMap::new(),
            watched: Vec::new(),
            fast: Duration::ZERO,
            done: Vec::new(),
            left: Vec::new(),
            trouble: Vec::new(),
            line: line.clone(),
        };
        for id in line.station_ids() {
            let process = floor.started(id, Restore::Fresh)?;
            floor.processes.push(process);
        }
        floor.settle();
        Ok(floor)
    }

    /// Notes it as work on the part in this nest whenever this operation is complete.
    pub fn watch(&mut self, station: StationId, op: OpId, nest: HolderId) {
        self.watched.push((station, op, nest, false));
    }

    /// The mechanisms and the parts.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// The same, for faults, and for people who put parts right.
    pub fn plant_mut(&mut self) -> &mut Plant {
        &mut self.plant
    }

    /// A station's controller.
    pub fn controller(&self, station: StationId) -> &Controller {
        &self.processes[station.index()].controller
    }

    /// Whether a station's process runs.
    pub fn is_up(&self, station: StationId) -> bool {
        self.processes[station.index()].down.is_none()
    }

    /// A person confirms where a station stands. Of the parameters of its task nobody sees the number: each is given as 0.
    pub fn rejoin(&mut self, station: StationId, at: RejoinAt) {
        let controller = &mut self.processes[station.index()].controller;
        let numbers = controller.numbers_to_confirm(at).iter().map(|of| (of.name.as_str().into(), 0));
        let numbers: Vec<(Arc<str>, i32)> = numbers.collect();
        controller.handle(self.now, StationInput::Rejoin(at, &numbers));
        self.settle();
    }

    /// Ends a station's process. Its outputs stay until its devices miss it.
    pub fn kill(&mut self, station: StationId) {
        let process = &mut self.processes[station.index()];
        if process.down.is_none() {
            process.down = Some((process.controller.snapshot(), self.now + self.line.timing.stale));
        }
    }

    /// Starts it again, from its journal.
    ///
    /// # Errors
    /// When it does not compile any more.
    pub fn restart(&mut self, station: StationId) -> Result<(), CompileError> {
        self.start_again(station, Restore::From)
    }

    /// Starts it again without its journal.
    ///
    /// # Errors
    /// When it does not compile any more.
    pub fn restart_without_journal(&mut self, station: StationId) -> Result<(), CompileError> {
        self.start_again(station, |_| Restore::Fresh)
    }

    fn start_again(
        &mut self,
        station: StationId,
        restore: impl Fn(StationSnapshot) -> Restore,
    ) -> Result<(), CompileError> {
        let Some((kept, _)) = self.processes[station.index()].down.take() else { return Ok(()) };
        self.plant.set_outputs(self.now, Owner::Station(station), 0);
        self.processes[station.index()] = self.started(station, restore(kept))?;
        self.settle();
        Ok(())
    }

    /// The same with some rules of orders switched off, in all lives of all stations.
    #[must_use]
    pub fn with_order_rules(mut self, rules: OrderRules) -> Self {
        self.order_rules = rules;
        for process in &mut self.processes {
            process.controller = process.controller.clone().with_order_rules(rules);
        }
        self
    }

    /// All stations are in this mode from now on.
    pub fn mode(&mut self, mode: ControlMode) {
        self.order = ModeOrder { mode, epoch: self.order.epoch + 1, ..self.order };
        for index in 0..self.processes.len() {
            self.tell_mode(index);
        }
        self.settle();
    }

    /// These stations are in emergency stop by themselves, and no others; as the mode decision orders it.
    pub(super) fn stop(&mut self, stations: BTreeSet<StationId>) {
        if self.stopped != stations {
            self.order.epoch += u64::from(!self.stopped.is_subset(&stations));
            self.stopped = stations;
            for index in 0..self.processes.len() {
                self.tell_mode(index);
            }
            self.settle();
        }
    }

    /// Gives a station an order of its mode, as a coordinator does.
    pub fn order(&mut self, station: StationId, order: ModeOrder) {
        self.processes[station.index()].controller.handle(self.now, StationInput::Order(order));
        self.settle();
    }

    fn tell_mode(&mut self, index: usize) {
        let order = self.order_for(StationId::at(index));
        self.processes[index].controller.handle(self.now, StationInput::Order(order));
    }

    fn order_for(&self, station: StationId) -> ModeOrder {
        let mode = if self.stopped.contains(&station) { ControlMode::EStop } else { self.order.mode };
        ModeOrder { mode, ..self.order }
    }

    /// Holds this button of a station in manual, motion by motion, until it stands at a rest. Returns when it does.
    pub fn lead(&mut self, station: StationId, button: PanelCommand) -> Tick {
        let release = match button {
            PanelCommand::Advance(_) => PanelCommand::Advance(false),
            PanelCommand::Retract(_) | PanelCommand::Selector(_) => PanelCommand::Retract(false),
        };
        for _ in 0..LED_MAX {
            if self.is_at_rest(station) {
                break;
            }
            self.press(station, release);
            // A button is held by repetition.
            let end = self.now + HELD;
            while self.now < end {
                self.press(station, button);
                self.now = self.now + PRESSED_EVERY;
                self.settle();
            }
        }
        assert!(self.is_at_rest(station), "{} reaches no rest", self.line.station(station).name);
        self.now
    }

    fn is_at_rest(&self, station: StationId) -> bool {
        let controller = self.controller(station);
        let moves = controller.marking().any(|place| place.is_operating());
        !moves && controller.report().order.is_some_and(|order| order.rest.is_some())
    }

    /// A button or the selector of a station's panel, once.
    pub fn press(&mut self, station: StationId, button: PanelCommand) {
        self.processes[station.index()].controller.handle(self.now, StationInput::Panel(button));
        self.settle();
    }

    fn started(&mut self, id: StationId, restore: Restore) -> Result<Running, CompileError> {
        self.lives += 1;
        let mut controller = Controller::new(&self.line, id, self.lives, restore)?.with_order_rules(self.order_rules);
        controller.handle(self.now, StationInput::Order(self.order_for(id)));
        let (out, said) = (station::StationOutbox::default(), TaskOrderReport::default());
        Ok(Running { controller, out, image: None, said, down: None })
    }

    /// Time of the next event that happens by itself.
    pub(super) fn next(&self) -> Option<Tick> {
        let deadlines = self.processes.iter().filter_map(|process| match process.down {
            Some((_, runs_out)) => Some(runs_out),
            None => process.controller.next_deadline(),
        });
        deadlines.chain(self.plant.next_change()).filter(|at| *at > self.now && *at < Tick::NEVER).min()
    }

    /// Lets time pass. Returns the stations with something to send.
    pub(super) fn go_on(&mut self, now: Tick) -> Vec<usize> {
        while let Some(at) = self.next().filter(|at| *at <= now) {
            self.now = at;
            self.settle();
        }
        self.now = self.now.max(now);
        self.settle();
        let mut news = Vec::new();
        for (index, process) in self.processes.iter_mut().enumerate().filter(|(_, process)| process.down.is_none()) {
            let report = process.controller.report().order.unwrap_or_default();
            if report != process.said {
                process.said = report;
                news.push(index);
            }
        }
        news
    }

    /// Images to controllers and outputs to the plant, until nothing follows any more.
    fn settle(&mut self) {
        let now = self.now;
        self.plant.advance(now);
        self.look();
        for _ in 0..PASSES_MAX {
            let mut moved = false;
            for (index, process) in self.processes.iter_mut().enumerate() {
                let owner = Owner::Station(StationId::at(index));
                let outputs = match process.down {
                    Some((_, runs_out)) if runs_out <= now => 0,
                    Some(_) => continue,
                    None => process.step(now, self.plant.inputs(owner)),
                };
                if outputs != self.plant.outputs(owner) {
                    self.plant.set_outputs(now, owner, outputs);
                    moved = true;
                }
            }
            self.look();
            if !moved {
                return;
            }
        }
    }

    /// Notes the work that has just been completed.
    fn look(&mut self) {
        for (station, op, nest, was) in &mut self.watched {
            let owner = Owner::Station(*station);
            let is = self.plant.inputs(owner) & self.line.operation((*station, *op)).normal.complete.bit() != 0;
            if std::mem::replace(was, is) || !is {
                continue;
            }
            let of = self.line.station(*station);
            let parameters = of.task_of(*op).map(|task| &of.task(task).parameters[..]).unwrap_or_default();
            let image = self.plant.outputs(owner);
            let on = |bits: &[linewright_line::OutputId]| {
                bits.iter().enumerate().fold(0, |number, (nth, bit)| number | i32::from(image & bit.bit() != 0) << nth)
            };
            let part = self.plant.part_at(NestPosition { nest: *nest, position: 1 }).map(|part| PartId(part.0));
            let numbers = parameters.iter().map(|parameter| on(&parameter.bits)).collect();
            self.done.push(Work { part, station: *station, op: *op, numbers });
        }
    }

    /// Report of a station; none while it is down.
    pub(super) fn heard(&self, index: usize) -> Option<TaskReport> {
        let process = self.processes.get(index).filter(|process| process.down.is_none())?;
        let report = process.controller.report().order.as_ref().map(orders::heard)?;
        Some(TaskReport { fault: process.controller.fault_text(&self.line), ..report })
    }

    /// Reply of a station to an order.
    pub(super) fn told(&mut self, now: Tick, message: &OrderMessage) -> Option<TaskReply> {
        let limit = message.order.limit.saturating_sub(self.fast);
        let order = TaskOrder { limit, ..message.order.clone() };
        self.command(now, message.station, TaskCommand::Run(&order))
    }

    /// Reply of a station to the order to leave an order.
    pub(super) fn told_to_leave(
        &mut self,
        now: Tick,
        to: StationId,
        key: OrderKey,
        way: LeaveWay,
    ) -> Option<TaskReply> {
        self.command(now, to, TaskCommand::Leave(key, way))
    }

    fn command(&mut self, now: Tick, to: StationId, command: TaskCommand<'_>) -> Option<TaskReply> {
        self.now = self.now.max(now);
        let process = self.processes.get_mut(to.index()).filter(|process| process.down.is_none())?;
        process.controller.handle(now, StationInput::Task(command));
        let outputs = process.step(now, self.plant.inputs(Owner::Station(to)));
        let reply = process.out.replies.pop().map(|(_, reply)| reply);
        process.out.replies.clear();
        self.plant.set_outputs(now, Owner::Station(to), outputs);
        self.settle();
        reply
    }

    /// People's part of a record: parts come in and go out.
    pub(super) fn note(&mut self, record: &Record, state: &PlayerState) {
        match record.fact.activity_step() {
            Some(ActivityStep::Started { firing, mode, part, orders: _ }) => {
                self.firings.insert(firing, (mode, part));
            }
            Some(ActivityStep::Ended { firing }) => {
                if let Some((mode, part)) = self.firings.remove(&firing) {
                    self.carry(mode, part, state);
                }
            }
            Some(ActivityStep::Fired { mode, part }) => self.carry(mode, part, state),
            Some(ActivityStep::Raised { .. } | ActivityStep::Closed { .. }) | None => {}
        }
    }

    fn carry(&mut self, mode: ModeId, part: Option<PartId>, state: &PlayerState) {
        let (table, Some(part)) = (state.table(), part) else { return };
        let no = PartNo(part.0);
        match (table.part_in(mode), table.part_out(mode)) {
            (None, Some(to)) => {
                let nest = table.store_of(to).and_then(|store| self.stores.get(store).copied());
                let position = state.part(part).and_then(|part| u16::try_from(part.position?).ok());
                let spot = nest.zip(position).map(|(nest, position)| NestPosition { nest, position });
                let put = spot.map(|spot| self.plant.put(self.now, no, spot));
                if put != Some(Ok(())) {
                    self.trouble.push(format!("{part} cannot come in at {spot:?}: {put:?}"));
                }
            }
            (Some(_), None) => match self.plant.take(self.now, no) {
                Ok(_) => self.left.push(part),
                Err(why) => self.trouble.push(format!("{part} cannot be taken out: {why:?}")),
            },
            (Some(_), Some(_)) | (None, None) => {}
        }
        self.settle();
    }

    /// Differences between the plant and a state: parts that rest must be where the state has them.
    pub fn differences(&self, state: &PlayerState) -> Vec<String> {
        let table = state.table();
        let mut found = Vec::new();
        for part in state.parts() {
            let PartPlace::On { cell, .. } = part.place else { continue };
            let name = table.cell_name(cell);
            let resource = name.split('.').next().unwrap_or_default();
            let spot = match table.store_of(cell).and_then(|store| self.stores.get(store)) {
                Some(&nest) => part.position.and_then(|position| u16::try_from(position).ok()).map(|p| (nest, p)),
                None => self.nests.get(resource).map(|&nest| (nest, 1)),
            };
            let there = spot.and_then(|(nest, position)| self.plant.part_at(NestPosition { nest, position }));
            if there != Some(PartNo(part.id.0)) {
                found.push(format!("{} should be on {name} {:?}, there is {there:?}", part.id, part.position));
            }
        }
        let (here, known) = (self.plant.parts().count(), state.parts().len());
        if state.firings().next().is_none() && here != known {
            found.push(format!("{here} parts are there, {known} are known"));
        }
        found
    }
}

impl Running {
    /// One step with this image; the outputs it drives.
    fn step(&mut self, now: Tick, image: u128) -> u128 {
        if self.image.replace(image) != Some(image) {
            let input = StationInput::Inputs { bits: image, valid: true, until: Tick::NEVER, under: NO_DELAY };
            self.controller.handle(now, input);
        }
        self.controller.step(now, &mut self.out);
        self.out.events.clear();
        self.out.outputs
    }
}
