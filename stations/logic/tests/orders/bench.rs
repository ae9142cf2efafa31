//! The machine on a bench: its switches follow what is said to arrive, time passes when told to, and everything that is
//! sent over and over is sent over and over.

use std::time::Duration;

use linewright_line::net::{Block, ControlMode, StationPlace};
use linewright_line::{Line, MotionSignals, OpId, OperationModule, StationId, Tick, parse};
use linewright_station_logic::{
    Controller, ModeOrder, NO_DELAY, OrderKey, PanelCommand, Restore, Rules, StationInput, StationOutbox,
    StationSnapshot, TaskCommand, TaskOrder, TaskOrderReport, TaskOutcome, TaskReply,
};

const BASE: &str = include_str!("../../../../model/line/tests/descriptions/on_order.toml");

/// The memory of the station's first life.
pub const MEMORY: u64 = 7;

pub struct Bench {
    pub line: Line,
    pub station: StationId,
    pub controller: Controller,
    pub now: Tick,
    pub outputs: u128,
    order: ModeOrder,
    held: Vec<PanelCommand>,
    /// What it was told last was not ignored.
    pub is_taken: bool,
    image: u128,
    valid: bool,
    out: StationOutbox,
    events: Vec<String>,
}

pub fn key(epoch: u64, id: u64) -> OrderKey {
    OrderKey { epoch, id }
}

/// An order of epoch 1.
pub fn order(id: u64, task: &str) -> TaskOrder {
    let parameters = if task == "machine" { vec![("program".into(), 5)] } else { Vec::new() };
    TaskOrder { key: key(1, id), memory: MEMORY, task: task.into(), parameters, limit: Duration::from_secs(20) }
}

impl Bench {
    /// The machine at home, in auto, with a part in front of the clamp.
    pub fn new() -> Self {
        let mut bench = Bench::of(Restore::Fresh, MEMORY);
        bench.mode(ControlMode::Auto);
        bench.set("part_present", true);
        bench.events();
        bench
    }

    pub fn of(restore: Restore, boot_id: u64) -> Self {
        let line = parse("on_order.toml", BASE).unwrap_or_else(|problems| panic!("{problems:#}")).line;
        let station = StationId(0);
        let controller = Controller::new(&line, station, boot_id, restore).expect("the machine compiles");
        // Its images say nothing of where mechanisms stand.
        let controller = controller.with_rules(Rules::COUNTS);
        let order = ModeOrder { manual_all: true, ..ModeOrder::of(1, 1, ControlMode::StandBy, line.timing.lease) };
        let mut bench = Bench {
            line,
            station,
            controller,
            now: Tick::from_millis(1000),
            outputs: 0,
            order,
            held: Vec::new(),
            is_taken: true,
            image: 0,
            valid: true,
            out: StationOutbox::default(),
            events: Vec::new(),
        };
        bench.image = bench.input("C_0") | bench.input("L_0");
        bench.refresh();
        bench.events();
        bench
    }

    pub fn input(&self, name: &str) -> u128 {
        let names = &self.line.station(self.station).inputs;
        1 << names.iter().position(|input| input == name).unwrap_or_else(|| panic!("no input {name}"))
    }

    /// The outputs that are on, by name.
    pub fn on(&self) -> Vec<&str> {
        let names = self.line.station(self.station).outputs.iter().enumerate();
        names.filter(|(bit, _)| self.outputs & (1 << bit) != 0).map(|(_, name)| name.as_str()).collect()
    }

    pub fn step(&mut self) {
        self.controller.step(self.now, &mut self.out);
        self.outputs = self.out.outputs;
        for event in self.out.events.drain(..) {
            self.events.push(event.text(&self.line, self.station));
        }
    }

    fn send_image(&mut self) {
        let (bits, valid) = (self.image, self.valid);
        self.controller.handle(self.now, StationInput::Inputs { bits, valid, until: Tick::NEVER, under: NO_DELAY });
        self.step();
    }

    fn refresh(&mut self) {
        self.send_image();
        self.controller.handle(self.now, StationInput::Order(self.order));
        for command in self.held.clone() {
            self.controller.handle(self.now, StationInput::Panel(command));
        }
        self.step();
    }

    pub fn set(&mut self, input: &str, on: bool) {
        let bit = self.input(input);
        self.image = if on { self.image | bit } else { self.image & !bit };
        self.send_image();
    }

    pub fn devices(&mut self, valid: bool) {
        self.valid = valid;
        self.send_image();
    }

    /// Says that the motion under way has arrived: the switches of its axis say so, one after the other.
    pub fn arrive(&mut self) {
        let place = self.marking();
        assert!(place.is_operating(), "{place} moves nothing");
        let axis = self.line.operation((self.station, place.op)).motion.axis;
        for bit in self.switches_of(axis) {
            self.image &= !bit;
        }
        self.send_image();
        self.image |= 1 << self.signals(place).complete.0;
        self.send_image();
    }

    fn signals(&self, place: StationPlace) -> MotionSignals {
        let operation = self.line.operation((self.station, place.op));
        match (&operation.module, place.block) {
            (OperationModule::Reversible { recovery, .. }, Block::Recovery) => *recovery,
            (OperationModule::Reversible { .. } | OperationModule::Irreversible { .. }, _) => operation.normal,
        }
    }

    fn switches_of(&self, axis: linewright_line::AxisId) -> Vec<u128> {
        let ops = (0..self.line.station(self.station).operations.len()).map(OpId::at);
        let mine = ops.filter(|&op| self.line.operation((self.station, op)).motion.axis == axis);
        let both = mine.flat_map(|op| [StationPlace::operating(op), StationPlace::undoing(op)]);
        both.map(|place| 1 << self.signals(place).complete.0).collect()
    }

    pub fn mode(&mut self, mode: ControlMode) {
        self.order.mode = mode;
        self.order.epoch += 1;
        self.send_order();
    }

    pub fn master_stop(&mut self, stop: bool) {
        self.order.master_stop = stop.then_some(0);
        self.send_order();
    }

    fn send_order(&mut self) {
        self.controller.handle(self.now, StationInput::Order(self.order));
        self.step();
    }

    /// A button of the console goes down and up again.
    pub fn press(&mut self, button: &str) {
        let index = self.line.buttons.iter().position(|name| name == button).expect("there is such a button");
        self.order.buttons |= 1 << index;
        self.send_order();
    }

    pub fn release(&mut self) {
        self.order.buttons = 0;
        self.send_order();
    }

    pub fn hold(&mut self, commands: &[PanelCommand]) {
        self.held = commands.to_vec();
        for command in [PanelCommand::Advance(false), PanelCommand::Retract(false)].into_iter().chain(self.held.clone())
        {
            self.controller.handle(self.now, StationInput::Panel(command));
        }
        self.step();
    }

    /// Held at the panel until the motion has arrived.
    pub fn through(&mut self, command: PanelCommand) {
        self.hold(&[command]);
        self.arrive();
        self.hold(&[]);
    }

    pub fn wait(&mut self, time: Duration) {
        let end = self.now + time;
        while self.now < end {
            self.now = (self.now + self.line.timing.refresh).min(end);
            self.refresh();
        }
    }

    /// What it answers to an order.
    pub fn run(&mut self, order: &TaskOrder) -> TaskReply {
        self.told(TaskCommand::Run(order), order.key)
    }

    pub fn secure(&mut self, key: OrderKey) -> TaskReply {
        self.told(TaskCommand::Secure(key), key)
    }

    /// Told to stop at once.
    pub fn stop(&mut self, key: OrderKey) -> TaskReply {
        self.told(TaskCommand::Stop(key), key)
    }

    fn told(&mut self, command: TaskCommand<'_>, key: OrderKey) -> TaskReply {
        self.is_taken = self.controller.handle(self.now, StationInput::Task(command)).is_taken();
        self.step();
        let mut replies = std::mem::take(&mut self.out.replies);
        let reply = replies.pop().expect("whatever it is told it answers");
        assert_eq!((replies.len(), reply.0), (0, key));
        reply.1
    }

    /// Does a task from its order to its end.
    pub fn done(&mut self, order: &TaskOrder) {
        assert_eq!(self.run(order), TaskReply::Running);
        while self.slot().is_some() {
            self.arrive();
        }
        assert_eq!(self.result(order.key), Some(TaskOutcome::Done));
    }

    pub fn orders(&self) -> TaskOrderReport {
        self.controller.report().order.expect("it works on order")
    }

    pub fn slot(&self) -> Option<OrderKey> {
        self.orders().slot.map(|slot| slot.key)
    }

    pub fn result(&self, key: OrderKey) -> Option<TaskOutcome> {
        self.orders().results.iter().find(|(known, _)| *known == key).map(|(_, outcome)| *outcome)
    }

    /// The rest it stands at, by name.
    pub fn rest(&self) -> Option<String> {
        self.orders().rest.map(|rest| self.line.station(self.station).rests[rest.index()].name.clone())
    }

    pub fn marking(&self) -> StationPlace {
        self.controller.marking().next().expect("one token")
    }

    pub fn doing(&self) -> String {
        self.controller.operation_text(&self.line)
    }

    pub fn blocked_by(&self) -> Vec<String> {
        self.controller.blocked_by(&self.line, self.now)
    }

    pub fn events(&mut self) -> Vec<String> {
        std::mem::take(&mut self.events)
    }

    /// The same machine after its controller has been killed, with what it kept.
    pub fn killed(&self, boot_id: u64) -> Self {
        self.restarted(self.controller.snapshot(), boot_id)
    }

    fn restarted(&self, snapshot: StationSnapshot, boot_id: u64) -> Self {
        let mut bench = Bench::of(Restore::From(snapshot), boot_id);
        bench.now = self.now;
        bench.image = self.image;
        bench.refresh();
        bench
    }
}
