//! Tasks in conflict: what a station looks at before it moves, beside its order.

use std::time::Duration;

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{Line, StationId, Tick, parse};
use linewright_station_logic::{
    Controller, ModeOrder, NO_DELAY, Program, Restore, StationInput, StationOutbox, StationReport, TaskCommand,
    TaskFailure, TaskOutcome,
};

use super::bench::order;

const BASE: &str = include_str!("../../../../model/line/tests/descriptions/task_driven.toml");
const M1: StationId = StationId(0);
const ROBOT: StationId = StationId(1);

/// The arm must not come while the slide is away.
fn line() -> Line {
    let conflict = "[[conflict]]\nwhy = \"the slide is in the way\"\na = { station = \"m1\", task = \"machine\" }\n\
                    b = { station = \"robot\", task = \"load m1\" }\n\n[console]";
    let text = BASE.replacen("[console]", conflict, 1);
    parse("task_driven.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

struct Arm {
    line: Line,
    robot: Controller,
    m1: StationReport,
    now: Tick,
    out: StationOutbox,
}

impl Arm {
    /// At home, in auto; it receives that the slide is home.
    fn new() -> Self {
        let line = line();
        let start = |station| Controller::new(&line, station, 7, Restore::Fresh).expect("it compiles");
        let mut m1 = start(M1).report();
        (m1.devices_valid, m1.measured_age) = (true, Duration::ZERO);
        let robot = start(ROBOT);
        let mut arm = Arm { robot, m1, now: Tick::from_millis(1000), out: StationOutbox::default(), line };
        arm.sees(&["A_0", "G_0"]);
        arm.robot.handle(arm.now, StationInput::Order(ModeOrder::of(1, 1, ControlMode::Auto, ModeOrder::FOR_GOOD)));
        arm.hears(&["C_0", "L_0"]);
        arm
    }

    fn step(&mut self) {
        self.robot.step(self.now, &mut self.out);
    }

    fn sees(&mut self, on: &[&str]) {
        let bits = inputs(&self.line, ROBOT, on);
        self.robot.handle(self.now, StationInput::Inputs { bits, valid: true, until: Tick::NEVER, under: NO_DELAY });
        self.step();
    }

    fn hears(&mut self, on: &[&str]) {
        self.m1.measured = inputs(&self.line, M1, on);
        self.robot.handle(self.now, StationInput::View(M1, &self.m1));
        self.step();
    }

    fn ordered(&mut self, id: u64, task: &str) {
        let mut order = order(id, task);
        order.parameters = vec![("slot".into(), 1)];
        self.robot.handle(self.now, StationInput::Task(TaskCommand::Run(&order)));
        self.step();
    }

    /// The motions that are driven, by name.
    fn drives(&self) -> Vec<&str> {
        let names = self.line.station(ROBOT).outputs.iter().enumerate();
        let on = names.filter(|(bit, _)| self.out.outputs & (1 << bit) != 0).map(|(_, name)| name.as_str());
        on.filter(|name| name.starts_with('Y')).collect()
    }
}

fn inputs(line: &Line, station: StationId, on: &[&str]) -> u128 {
    let names = line.station(station).inputs.iter().enumerate();
    names.filter(|(_, name)| on.contains(&name.as_str())).fold(0, |bits, (bit, _)| bits | 1 << bit)
}

#[test]
fn a_task_begins_only_while_the_other_station_is_measured_out_of_the_way() {
    let mut arm = Arm::new();
    arm.hears(&["C_60"]);
    arm.ordered(1, "load m1");
    assert_eq!(arm.drives(), [] as [&str; 0], "the slide is away");
    arm.now = arm.now + Duration::from_secs(1);
    arm.step();
    assert_eq!(arm.drives(), [] as [&str; 0], "nor while nothing is heard");
    arm.hears(&["C_60", "L_0"]);
    assert_eq!(arm.drives(), ["Y_50"]);
}

#[test]
fn a_motion_of_it_stops_when_the_other_one_is_measured_in_the_way() {
    let mut arm = Arm::new();
    arm.ordered(1, "load m1");
    arm.sees(&["G_0"]);
    assert_eq!(arm.drives(), ["Y_50"]);
    arm.hears(&["C_60"]);
    assert_eq!(arm.drives(), [] as [&str; 0]);
    let results = arm.robot.report().order.expect("it is task-driven").results;
    assert_eq!(results.last().map(|(_, end)| *end), Some(TaskOutcome::Failed(TaskFailure::Fault)));
}

#[test]
fn other_tasks_do_not_ask() {
    let mut arm = Arm::new();
    arm.hears(&["C_60"]);
    arm.ordered(1, "unload m1");
    assert_eq!(arm.drives(), ["Y_100"]);
}

/// No switch of the arm distinguishes its two tasks: the machine has nothing to check, and does not wait.
#[test]
fn what_no_switches_tell_of_is_not_looked_at() {
    let line = line();
    let program = Program::compile(&line, M1).expect("it compiles");
    assert!(line.station(M1).op_ids().all(|op| { program.guards(StationPlace::operating(op), None).next().is_none() }));
}
