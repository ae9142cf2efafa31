//! A station of an activity: its real controller, its switches, and its node's part of the reports.
//!
//! Each situation it can be in has a number, and so has each possible report; the controller computes the result of an
//! event in a situation once. Time stands still but for the time of orders, which only [`TaskStationAct::Expire`] lets
//! pass.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::time::Duration;

use linewright_coordinator_cell::{OrderMessage, StationUnavailable, TaskReport};
use linewright_coordinator_shell::orders::heard;
use linewright_line::net::{Block, ControlMode, StationPlace};
use linewright_line::{Line, OpId, OperationModule, StationId, Tick};
use linewright_orders::{LeaveWay, OrderKey, TaskCommand, TaskOrder, TaskOutcome, TaskRefusal, TaskReply};
use linewright_station_logic::{
    CompileError, Controller, ModeOrder, NO_DELAY, OrderRules, PanelCommand, RequestWriter, Restore, StationInput,
    StationOutbox,
};
use rustc_hash::FxHashMap;

use crate::explore::{actuator, bits_of};

/// Time limit of every order: it runs out by [`TaskStationAct::Expire`].
const LIMIT: Duration = Duration::from_micros(1);
const NOW: Tick = Tick::from_millis(1);

/// Something that may happen to a station by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum TaskStationAct {
    /// Its motion arrives.
    Arrive,
    /// Its motion fails.
    Fail,
    /// All inputs that its operations wait for come on, or go off.
    Sensors(bool),
    /// The time of its order is over, by its own clock.
    Expire,
    /// Its node is started again, with what it kept.
    Restart,
    /// The same, without.
    Forget,
    /// A person leads it on by one motion in manual mode, or back, and gives it back.
    Led {
        /// With the key that leads on.
        on: bool,
    },
}

/// Report of a station, all of it in one message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct StationAnswer {
    pub heard: TaskReport,
    pub secured: Option<(OrderKey, LeaveWay, TaskReply)>,
    pub refused: Vec<(OrderKey, TaskRefusal)>,
}

/// A controller and what is around it.
#[derive(Clone, Debug)]
pub(super) struct TaskStationModel {
    pub controller: Controller,
    now: Tick,
    switches: u128,
    sensors: bool,
    outputs: u128,
    boots: u64,
    /// Of the mode orders it was given in this life.
    epoch: u64,
    secured: Option<(OrderKey, LeaveWay)>,
    /// The orders of which it has begun something, in all its lives.
    begun: BTreeSet<OrderKey>,
    /// One of them was begun again.
    pub twice: bool,
    /// Orders left, in any of its lives, for which nothing may move any more.
    stopped: BTreeSet<OrderKey>,
    /// Something has moved all the same.
    pub moves_on: bool,
    /// The newest order before the activity.
    before: Option<OrderKey>,
    /// It stands in a handshake, or has completed its order; as it was when its memory was lost, if it was.
    is_involved: bool,
    is_forgotten: bool,
    /// A person has led it since.
    is_led: bool,
    rules: OrderRules,
}

impl TaskStationModel {
    /// A station without memory yet, in auto, at its home.
    pub fn new(line: &Line, id: StationId) -> Result<Self, CompileError> {
        let controller = Controller::new(line, id, 1, Restore::Fresh)?;
        let station = line.station(id);
        let mut switches = 0;
        if let Some(rest) = station.rests.first() {
            for op in station.op_ids() {
                let operation = line.operation((id, op));
                let at = rest.at.get(operation.motion.axis.index()).copied();
                switches |= if at == Some(operation.motion.to) { operation.normal.complete.bit() } else { 0 };
            }
        }
        let mut machine = TaskStationModel {
            controller,
            now: NOW,
            switches,
            sensors: true,
            outputs: 0,
            boots: 1,
            epoch: 0,
            secured: None,
            begun: BTreeSet::new(),
            twice: false,
            stopped: BTreeSet::new(),
            moves_on: false,
            before: None,
            is_involved: false,
            is_forgotten: false,
            is_led: false,
            rules: OrderRules::default(),
        };
        machine.wake(line);
        Ok(machine)
    }

    /// The same before an activity, with some rules switched off.
    pub fn with_rules(mut self, rules: OrderRules) -> Self {
        self.before = self.results().last().map(|(key, _)| *key);
        self.controller = self.controller.with_order_rules(rules);
        self.rules = rules;
        self
    }

    fn wake(&mut self, line: &Line) {
        self.image(line, true);
        self.epoch = 0;
        self.obey(ControlMode::Auto);
    }

    fn obey(&mut self, mode: ControlMode) {
        self.epoch += 1;
        let manual_all = mode == ControlMode::Manual;
        let order = ModeOrder { manual_all, ..ModeOrder::of(1, self.epoch, mode, ModeOrder::FOR_GOOD) };
        self.controller.handle(self.now, StationInput::Order(order));
        self.step();
    }

    fn hold(&mut self, on: bool, held: bool) {
        let key = if on { PanelCommand::Advance(held) } else { PanelCommand::Retract(held) };
        self.controller.handle(self.now, StationInput::Panel(key));
        self.step();
    }

    fn lead(&mut self, line: &Line, on: bool) {
        self.is_led = true;
        self.obey(ControlMode::Manual);
        self.hold(on, false);
        self.hold(on, true);
        self.act(line, TaskStationAct::Arrive);
        self.hold(on, false);
        self.obey(ControlMode::Auto);
    }

    fn step(&mut self) {
        let mut out = StationOutbox::default();
        self.controller.step(self.now, &mut out);
        self.outputs = out.outputs;
    }

    fn image(&mut self, line: &Line, valid: bool) {
        let id = self.controller.station();
        let bits = self.switches | if self.sensors { sensors_of(line, id) } else { 0 };
        self.controller.handle(self.now, StationInput::Inputs { bits, valid, until: Tick::NEVER, under: NO_DELAY });
        self.step();
    }

    /// Receives an order.
    pub fn order(&mut self, message: &OrderMessage) {
        let key = message.order.key;
        let order = TaskOrder { limit: LIMIT, ..message.order.clone() };
        let before = self.slot();
        self.controller.handle(self.now, StationInput::Task(TaskCommand::Run(&order)));
        self.step();
        if before != Some(key) && self.slot() == Some(key) {
            self.twice |= !self.begun.insert(key);
        }
    }

    /// Receives the message to leave an order; `alarmed` if nothing may move for it any more.
    pub fn secure(&mut self, key: OrderKey, way: LeaveWay, alarmed: bool) {
        if way != LeaveWay::Hold {
            let before = self.secured.filter(|(of, _)| *of == key).map(|(_, way)| way);
            self.secured = Some((key, before.map_or(way, |before| before.max(way))));
        }
        if alarmed {
            self.stopped.insert(key);
        }
        self.controller.handle(self.now, StationInput::Task(TaskCommand::Leave(key, way)));
        self.step();
    }

    /// Looks whether it drives what it should not.
    fn look(&mut self, line: &Line) {
        if !self.is_forgotten {
            let has_done = |(key, end): &(OrderKey, TaskOutcome)| Some(*key) > self.before && *end == TaskOutcome::Done;
            let is_in_handshake = self.controller.report().order.is_some_and(|order| order.is_in_handshake);
            self.is_involved = is_in_handshake || self.results().iter().any(has_done);
        }
        let is_stopped = !self.stopped.is_empty() && self.slot().is_none_or(|slot| self.stopped.contains(&slot));
        self.moves_on |= is_stopped && self.moving(line).is_some();
    }

    fn slot(&self) -> Option<OrderKey> {
        self.controller.report().order.and_then(|order| order.slot).map(|slot| slot.key)
    }

    /// The motion that is driven.
    fn moving(&self, line: &Line) -> Option<StationPlace> {
        let id = self.controller.station();
        let drives = |place: &StationPlace| self.outputs & actuator(line, id, place.op, place.block) != 0;
        self.controller.marking().find(|place| place.is_operating() && drives(place))
    }

    /// Whether it reports the end of an order which it is still at, and which it was not ordered to leave.
    pub fn goes_on(&self) -> bool {
        let Some(report) = self.controller.report().order else { return false };
        let slot =
            report.slot.map(|slot| slot.key).filter(|key| self.secured.is_none_or(|(secured, _)| secured != *key));
        slot.is_some_and(|slot| report.results.iter().any(|(key, _)| *key == slot))
    }

    fn results(&self) -> Vec<(OrderKey, TaskOutcome)> {
        self.controller.report().order.map(|order| order.results).unwrap_or_default()
    }

    /// Whether it goes back, and whether it is a reason for others not to.
    pub fn retreat(&self) -> Retreat {
        let order = self.controller.report().order.unwrap_or_default();
        let goes_back = order.slot.is_some_and(|slot| slot.is_securing) && order.rest.is_none();
        let goes_on = order.slot.is_some_and(|slot| !slot.is_securing);
        Retreat { goes_back, is_involved: !self.is_led && (goes_on || self.is_involved) }
    }

    /// The order it has or goes back from, if it does, and whether anything moves.
    pub fn is_at(&self, line: &Line) -> (Option<OrderKey>, bool) {
        (self.slot(), self.moving(line).is_some())
    }

    pub fn acts(&self, line: &Line, acts: &mut Vec<TaskStationAct>) {
        if self.moving(line).is_some() {
            acts.extend([TaskStationAct::Arrive, TaskStationAct::Fail]);
        }
        let slot = self.controller.report().order.and_then(|order| order.slot);
        if slot.is_some_and(|slot| !slot.is_securing) {
            acts.push(TaskStationAct::Expire);
            // Inputs that went off stay off until the order is over: a wait that ends equals a shorter one.
            if self.sensors && sensors_of(line, self.controller.station()) != 0 {
                acts.push(TaskStationAct::Sensors(false));
            }
        }
        acts.extend([
            TaskStationAct::Restart,
            TaskStationAct::Forget,
            TaskStationAct::Led { on: true },
            TaskStationAct::Led { on: false },
        ]);
    }

    pub fn act(&mut self, line: &Line, act: TaskStationAct) {
        let id = self.controller.station();
        match act {
            TaskStationAct::Arrive => {
                let Some(place) = self.moving(line) else { return };
                self.switches &= !switches_of(line, id, place.op);
                self.image(line, true);
                self.switches |= bits_of(line, id, place.op, place.block).0;
                self.image(line, true);
            }
            TaskStationAct::Fail => {
                let Some(place) = self.moving(line) else { return };
                self.switches &= !switches_of(line, id, place.op);
                self.image(line, true);
                match bits_of(line, id, place.op, place.block).1 {
                    Some(fault) => {
                        self.switches |= fault;
                        self.image(line, true);
                        self.switches &= !fault;
                    }
                    None => self.image(line, false),
                }
                self.image(line, true);
            }
            TaskStationAct::Sensors(on) => {
                self.sensors = on;
                self.image(line, true);
            }
            TaskStationAct::Led { on } => self.lead(line, on),
            TaskStationAct::Expire => {
                self.now = self.now + LIMIT;
                self.step();
            }
            TaskStationAct::Restart | TaskStationAct::Forget => {
                self.boots += 1;
                self.is_forgotten |= act == TaskStationAct::Forget;
                let kept = match act {
                    TaskStationAct::Restart => Restore::From(self.controller.snapshot()),
                    _ => Restore::Fresh,
                };
                // It did compile.
                let Ok(controller) = Controller::new(line, id, self.boots, kept) else { return };
                self.controller = controller.with_order_rules(self.rules);
                (self.secured, self.outputs) = (None, 0);
                self.wake(line);
            }
        }
    }

    /// Completes its order, without a fault.
    pub fn finish(&mut self, line: &Line) {
        for _ in 0..200 {
            if self.slot().is_none() {
                return;
            }
            self.act(line, TaskStationAct::Arrive);
        }
    }

    pub fn says(&self) -> StationAnswer {
        let report = self.controller.report();
        let order = report.order.unwrap_or_default();
        let unable = if !report.devices_valid {
            Some(StationUnavailable::Devices)
        } else {
            self.controller.marking().any(StationPlace::is_incomplete).then_some(StationUnavailable::Incomplete)
        };
        let heard = TaskReport { unable, ..heard(&order) };
        let secured = self.secured.map(|(key, way)| (key, way, heard.secured(key)));
        StationAnswer { heard, secured, refused: order.refused }
    }

    /// Writes everything that decides its further behaviour and reports.
    fn write(&self, out: &mut String) {
        let mut words = Vec::new();
        self.controller.situation(self.controller.cycle(), |_| RequestWriter { boot_id: 0, open: None }, &mut words);
        let order = self.controller.report().order;
        // Writing to a string does not fail.
        let _ = write!(
            out,
            "{words:?} {order:?} {} {} {:?} {:?} {} {:?} {} {} {} {} {}",
            self.switches,
            self.sensors,
            self.secured,
            self.begun,
            self.twice,
            self.stopped,
            self.moves_on,
            self.is_led,
            self.is_involved,
            self.is_forgotten,
            self.outputs
        );
    }
}

/// Whether a station goes back, and whether it is a reason for others not to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Retreat {
    pub goes_back: bool,
    /// It has an order that goes on, or has completed one, or stands in a handshake; and no person has led it since.
    pub is_involved: bool,
}

/// All situations of a station that have been met.
pub(super) struct TaskStationModels<'l> {
    line: &'l Line,
    numbers: FxHashMap<String, u32>,
    pub all: Vec<TaskStationModel>,
    pub acts: Vec<Vec<TaskStationAct>>,
    /// By situation, the number of its report.
    pub says: Vec<u32>,
    pub said: Vec<StationAnswer>,
    /// By situation: see [`TaskStationModel::is_at`].
    pub at: Vec<(Option<OrderKey>, bool)>,
    /// By situation: see [`TaskStationModel::retreat`].
    pub retreats: Vec<Retreat>,
    acted: FxHashMap<(u32, TaskStationAct), u32>,
    heard: FxHashMap<(u32, u32), u32>,
    scratch: String,
}

impl<'l> TaskStationModels<'l> {
    pub fn new(line: &'l Line) -> Self {
        TaskStationModels {
            line,
            numbers: FxHashMap::default(),
            all: Vec::new(),
            acts: Vec::new(),
            says: Vec::new(),
            said: Vec::new(),
            at: Vec::new(),
            retreats: Vec::new(),
            acted: FxHashMap::default(),
            heard: FxHashMap::default(),
            scratch: String::new(),
        }
    }

    pub fn enter(&mut self, machine: TaskStationModel) -> u32 {
        self.scratch.clear();
        machine.write(&mut self.scratch);
        if let Some(&number) = self.numbers.get(&self.scratch) {
            return number;
        }
        let number = self.all.len() as u32;
        let said = machine.says();
        let says = self.said.iter().position(|known| *known == said).unwrap_or_else(|| {
            self.said.push(said);
            self.said.len() - 1
        });
        let mut acts = Vec::new();
        machine.acts(self.line, &mut acts);
        self.numbers.insert(self.scratch.clone(), number);
        self.acts.push(acts);
        self.says.push(says as u32);
        self.at.push(machine.is_at(self.line));
        self.retreats.push(machine.retreat());
        self.all.push(machine);
        number
    }

    pub fn act(&mut self, from: u32, act: TaskStationAct) -> u32 {
        if let Some(&to) = self.acted.get(&(from, act)) {
            return to;
        }
        let mut next = self.all[from as usize].clone();
        next.act(self.line, act);
        next.look(self.line);
        let to = self.enter(next);
        self.acted.insert((from, act), to);
        to
    }

    /// A message arrives that has this number.
    pub fn hear(&mut self, from: u32, number: u32, tell: impl FnOnce(&mut TaskStationModel)) -> u32 {
        if let Some(&to) = self.heard.get(&(from, number)) {
            return to;
        }
        let mut next = self.all[from as usize].clone();
        tell(&mut next);
        next.look(self.line);
        let to = self.enter(next);
        self.heard.insert((from, number), to);
        to
    }
}

fn sensors_of(line: &Line, station: StationId) -> u128 {
    line.station(station).awaited_inputs().fold(0, |bits, input| bits | input.bit())
}

/// The switches of the axis that an operation moves.
fn switches_of(line: &Line, station: StationId, op: OpId) -> u128 {
    let axis = line.operation((station, op)).motion.axis;
    let same = line.station(station).op_ids().filter(|&op| line.operation((station, op)).motion.axis == axis);
    same.fold(0, |bits, op| {
        let back = match line.operation((station, op)).module {
            OperationModule::Reversible { .. } => bits_of(line, station, op, Block::Recovery).0,
            OperationModule::Irreversible { .. } => 0,
        };
        bits | back | bits_of(line, station, op, Block::Normal).0
    })
}
