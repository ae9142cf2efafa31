//! Wait of a task-driven station between two motions.

use linewright_line::net::{Block, ControlMode, StationPlace};
use linewright_line::{InputId, Line, OpId, Owner};

use crate::controller::Controller;
use crate::rejoin::RejoinAt;
use crate::texts::{PositionDoubt, RejoinAdvice, StationWait, numbers_text};

impl Controller {
    /// Where a task-driven station stands between two motions: what it waits for. False where its wait is one of every
    /// station.
    pub(crate) fn explain_order(&self, line: &Line, place: StationPlace, reasons: &mut Vec<String>) -> bool {
        let Some(tasks) = &self.program.tasks else { return false };
        let station = line.station(self.program.station);
        match self.mode() {
            ControlMode::Auto => {
                if self.master_stop_is_given() {
                    reasons.push(StationWait::MasterStopOfOrders.text());
                }
                match self.next_step() {
                    Some(step) => self.explain_missing(line, step, reasons),
                    None if self.rest().is_some() => reasons.push(StationWait::TaskOrder.text()),
                    None => reasons.push(StationWait::Rest.text()),
                }
                true
            }
            ControlMode::Hand => match (self.rest(), place.block) {
                (Some(rest), Block::Normal) => {
                    let choices = station.tasks_from(rest).map(|task| {
                        let forward = station.operations[station.first_of(task).index()].hand.forward();
                        StationWait::task_button(&line.buttons[usize::from(forward.0)], &station.task(task).name)
                    });
                    let choices: Vec<String> = choices.collect();
                    for task in station.tasks_from(rest) {
                        self.explain_missing(line, station.task(task).steps.start as u8, reasons);
                    }
                    reasons.push(StationWait::TaskButton { choices: &choices }.text());
                    true
                }
                (_, Block::Normal) => {
                    let step = self.program.step_of[place.op.index()] + 1;
                    if usize::from(step) < tasks.waits.len() {
                        self.explain_missing(line, step, reasons);
                    }
                    false
                }
                (_, Block::Recovery) => {
                    if station.operations[place.op.index()].hand.restarts_by().is_some() {
                        self.explain_missing(line, self.program.step_of[place.op.index()], reasons);
                    }
                    false
                }
            },
            ControlMode::Manual if self.panel_is_live() && self.rest().is_some() => {
                if place.block == Block::Normal {
                    reasons.push(StationWait::PanelAtRest.text());
                } else {
                    let op = &station.operations[place.op.index()].name;
                    self.explain_missing(line, self.program.step_of[place.op.index()], reasons);
                    reasons.push(StationWait::TakenBackAtRest { op }.text());
                }
                true
            }
            ControlMode::Home | ControlMode::StandBy | ControlMode::Manual | ControlMode::EStop => false,
        }
    }

    /// The way back of a task-driven station that does not stand where its chart has it.
    pub(crate) fn explain_lost_rest(&self, line: &Line, reasons: &mut Vec<String>) {
        if !self.is_to_be_confirmed() {
            return;
        }
        let doubt = if self.is_not_at_home() { PositionDoubt::NoJournal } else { PositionDoubt::AxisOff };
        let station = line.station(self.program.station);
        let rests: Vec<&str> =
            self.rests_read_off().map(|(rest, _)| station.rests[rest.index()].name.as_str()).collect();
        let name = |op: OpId| station.operations[op.index()].name.as_str();
        let ends: Vec<&str> = self.steps_read_off().flat_map(|step| self.ops_of_step(step)).map(name).collect();
        let within: Vec<&str> = station.op_ids().filter(|&op| self.stands_within(op)).map(name).collect();
        let advice = match (rests.as_slice(), ends.as_slice(), within.as_slice()) {
            ([rest], ..) => RejoinAdvice::Rest { rest },
            ([_, ..], ..) => RejoinAdvice::Rests { rests: &rests },
            ([], [op], _) => RejoinAdvice::Confirm { ops: op },
            ([], [_, ..], _) => RejoinAdvice::Several { ops: &ends },
            ([], [], [_, ..]) => RejoinAdvice::Between { ops: &within },
            ([], [], []) => RejoinAdvice::NoPlace,
        };
        let places = match (rests.as_slice(), ends.as_slice()) {
            ([_, ..], _) => Vec::new(),
            ([], [_, ..]) => self.steps_read_off().flat_map(|step| self.ops_of_step(step)).collect(),
            ([], []) => station.op_ids().filter(|&op| self.stands_within(op)).collect(),
        };
        let mut asked: Vec<&str> = Vec::new();
        for op in places {
            let names = self.numbers_to_confirm(RejoinAt::Within(op)).iter().map(|of| of.name.as_str());
            names.for_each(|name| {
                if !asked.contains(&name) {
                    asked.push(name)
                }
            });
        }
        reasons.push(StationWait::Rejoin(doubt, advice).text() + &numbers_text(&asked));
    }

    /// The inputs that a step waits for and that are off; first the result of the step before it.
    pub(crate) fn explain_missing(&self, line: &Line, step: u8, reasons: &mut Vec<String>) {
        let station = self.program.station;
        let mut missing = self.missing(step);
        let before = line.station(station).result_before(usize::from(step));
        if let Some((op, result)) = before.filter(|(_, result)| missing & result.input.bit() != 0) {
            let input = line.input_text(Owner::Station(station), result.input);
            reasons.push(StationWait::Result { input: &input, of: &line.operation((station, op)).name }.text());
            missing &= !result.input.bit();
        }
        let name = &line.operation((station, line.station(station).steps[usize::from(step)][0])).name;
        for input in (0..128).filter(|bit| missing & (1 << bit) != 0).map(InputId) {
            let input = line.input_text(Owner::Station(station), input);
            reasons.push(StationWait::Input { input: &input, own: name }.text());
        }
    }
}
