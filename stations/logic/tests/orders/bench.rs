//! A task-driven station on the rig: its switches follow its motions, and it is given task orders.

use std::ops::{Deref, DerefMut};
use std::time::Duration;

use linewright_line::net::{Block, ControlMode, StationPlace};
use linewright_line::{AxisId, MotionSignals, OpId, OperationModule, StationId, parse};
use linewright_station_logic::{
    LeaveWay, OrderKey, PanelCommand, Restore, StationInput, StationSnapshot, TaskCommand, TaskFailure, TaskOrder,
    TaskOrderReport, TaskOutcome, TaskReply,
};

use crate::controller::rig::Rig;

const BASE: &str = include_str!("../../../../model/line/tests/descriptions/task_driven.toml");

/// The memory of the station's first life.
pub const MEMORY: u64 = 7;

pub struct OrderBench {
    rig: Rig,
    /// The last task command was not ignored.
    pub is_taken: bool,
}

impl Deref for OrderBench {
    type Target = Rig;

    fn deref(&self) -> &Rig {
        &self.rig
    }
}

impl DerefMut for OrderBench {
    fn deref_mut(&mut self) -> &mut Rig {
        &mut self.rig
    }
}

pub fn key(epoch: u64, id: u64) -> OrderKey {
    OrderKey { epoch, id }
}

/// An order of epoch 1.
pub fn order(id: u64, task: &str) -> TaskOrder {
    let parameters = match task {
        "machine" => vec![("program".into(), 5)],
        "load m1" => vec![("slot".into(), 3)],
        _ => Vec::new(),
    };
    TaskOrder { key: key(1, id), memory: MEMORY, task: task.into(), parameters, limit: Duration::from_secs(20) }
}

pub fn ended(failure: TaskFailure) -> TaskReply {
    TaskReply::Ended(TaskOutcome::Failed(failure))
}

impl OrderBench {
    /// The machine at home, in auto, with a part in front of the clamp.
    pub fn new() -> Self {
        let mut bench = OrderBench::of(Restore::Fresh, MEMORY);
        bench.mode(ControlMode::Auto);
        bench.set("part_present", true);
        bench.events();
        bench
    }

    /// The machine holds the part, by order 1.
    pub fn clamped() -> Self {
        let mut bench = OrderBench::new();
        bench.done(&order(1, "clamp"));
        bench
    }

    /// On its way in with the part, by order 2.
    pub fn machining() -> Self {
        let mut bench = OrderBench::clamped();
        bench.run(&order(2, "machine"));
        bench
    }

    pub fn of(restore: Restore, boot_id: u64) -> Self {
        OrderBench::standing(StationId(0), restore, boot_id, &["C_0", "L_0"])
    }

    /// The machine by itself, which judges measured positions, with these inputs on.
    pub fn measured(restore: Restore, on: &[&str]) -> Self {
        let line = parse("task_driven.toml", BASE).unwrap_or_else(|problems| panic!("{problems:#}")).line;
        let names = line.station(StationId(0)).inputs.iter().enumerate();
        let image = names.filter(|(_, name)| on.contains(&name.as_str())).fold(0, |bits, (bit, _)| bits | 1 << bit);
        OrderBench { rig: Rig::alone(line, StationId(0), restore, image), is_taken: true }
    }

    /// A station of the description with these inputs on.
    pub fn standing(station: StationId, restore: Restore, boot_id: u64, on: &[&str]) -> Self {
        OrderBench::changed(|text| text, station, restore, boot_id, on)
    }

    /// A station of the description as `change` leaves it, with these inputs on.
    pub fn changed(
        change: impl Fn(String) -> String,
        station: StationId,
        restore: Restore,
        boot_id: u64,
        on: &[&str],
    ) -> Self {
        let line =
            parse("task_driven.toml", &change(BASE.to_owned())).unwrap_or_else(|problems| panic!("{problems:#}")).line;
        let names = line.station(station).inputs.iter().enumerate();
        let image = names.filter(|(_, name)| on.contains(&name.as_str())).fold(0, |bits, (bit, _)| bits | 1 << bit);
        OrderBench { rig: Rig::standing(line, station, boot_id, restore, image), is_taken: true }
    }

    fn input(&self, name: &str) -> u128 {
        let names = &self.line.station(self.station).inputs;
        1 << names.iter().position(|input| input == name).unwrap_or_else(|| panic!("no input {name}"))
    }

    /// The outputs that are on, by name.
    pub fn on(&self) -> Vec<&str> {
        let names = self.line.station(self.station).outputs.iter().enumerate();
        names.filter(|(bit, _)| self.outputs & (1 << bit) != 0).map(|(_, name)| name.as_str()).collect()
    }

    pub fn set(&mut self, input: &str, on: bool) {
        let bit = self.input(input);
        self.rig.set(bit, on);
    }

    /// The motion under way arrives: the switches of its axis change one after the other.
    pub fn arrive(&mut self) {
        let place = self.marking();
        assert!(place.is_operating(), "{place} moves nothing");
        let axis = self.line.operation((self.station, place.op)).motion.axis;
        let switches = self.switches_of(axis);
        self.rig.set(switches, false);
        let complete = 1 << self.signals(place).complete.0;
        self.rig.set(complete, true);
    }

    fn signals(&self, place: StationPlace) -> MotionSignals {
        let operation = self.line.operation((self.station, place.op));
        match (&operation.module, place.block) {
            (OperationModule::Reversible { recovery, .. }, Block::Recovery) => *recovery,
            (OperationModule::Reversible { .. } | OperationModule::Irreversible { .. }, _) => operation.normal,
        }
    }

    fn switches_of(&self, axis: AxisId) -> u128 {
        let ops = (0..self.line.station(self.station).operations.len()).map(OpId::at);
        let mine = ops.filter(|&op| self.line.operation((self.station, op)).motion.axis == axis);
        let both = mine.flat_map(|op| [StationPlace::operating(op), StationPlace::undoing(op)]);
        both.fold(0, |bits, place| bits | 1 << self.signals(place).complete.0)
    }

    pub fn master_stop(&mut self, stop: bool) {
        self.order.master_stop = stop.then_some(0);
        self.rig.order();
    }

    /// A button of the console goes down.
    pub fn press(&mut self, button: &str) {
        let index = self.line.buttons.iter().position(|name| name == button).expect("there is such a button");
        self.rig.hold(index as u16);
    }

    pub fn release(&mut self) {
        self.order.buttons = 0;
        self.rig.order();
    }

    /// The panel's buttons that are held from now on.
    pub fn hold(&mut self, commands: &[PanelCommand]) {
        self.advance(commands.contains(&PanelCommand::Advance(true)));
        self.retract(commands.contains(&PanelCommand::Retract(true)));
    }

    /// Held at the panel until the motion has arrived.
    pub fn through(&mut self, command: PanelCommand) {
        self.hold(&[command]);
        self.arrive();
        self.hold(&[]);
    }

    pub fn wait(&mut self, time: Duration) {
        self.wait_ms(time.as_millis() as u64);
    }

    pub fn run(&mut self, order: &TaskOrder) -> TaskReply {
        self.command(TaskCommand::Run(order), order.key)
    }

    pub fn secure(&mut self, key: OrderKey) -> TaskReply {
        self.leave(key, LeaveWay::Back)
    }

    pub fn stop(&mut self, key: OrderKey) -> TaskReply {
        self.leave(key, LeaveWay::Stop)
    }

    pub fn leave(&mut self, key: OrderKey, way: LeaveWay) -> TaskReply {
        self.command(TaskCommand::Leave(key, way), key)
    }

    fn command(&mut self, command: TaskCommand<'_>, key: OrderKey) -> TaskReply {
        let now = self.now;
        self.is_taken = self.controller.handle(now, StationInput::Task(command)).is_taken();
        self.step();
        let mut replies = std::mem::take(&mut self.out.replies);
        let reply = replies.pop().expect("each task command is answered");
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
        self.controller.report().order.expect("it is task-driven")
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

    /// The same machine after its controller has been killed, with its record.
    pub fn killed(&self, boot_id: u64) -> Self {
        self.restarted(self.controller.snapshot(), boot_id)
    }

    fn restarted(&self, snapshot: StationSnapshot, boot_id: u64) -> Self {
        let mut bench = OrderBench::of(Restore::From(snapshot), boot_id);
        (bench.now, bench.image) = (self.now, self.image);
        bench.refresh();
        bench
    }
}
