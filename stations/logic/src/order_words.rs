//! Orders in words: what a station on order waits for, and why it has not done what it was told.

use linewright_line::net::{Block, ControlMode, Place};
use linewright_line::{InputId, Line, Owner, StationId, TaskId};

use crate::controller::Controller;
use crate::order::{Failure, Refusal};

pub(crate) fn task_name(line: &Line, station: StationId, task: TaskId) -> &str {
    &line.station(station).task(task).name
}

impl Failure {
    /// In words, for the operator.
    pub fn text(self) -> String {
        match self {
            Failure::Waiting(code) => format!("what it waited for did not come (code {code})"),
            Failure::TimedOut => "its time was over".to_owned(),
            Failure::Fault => "a fault".to_owned(),
            Failure::Interrupted => "the mode was changed".to_owned(),
            Failure::Restarted => "the controller was restarted".to_owned(),
            Failure::Cancelled => "it was taken back".to_owned(),
            Failure::Held => "it was taken back, as far as it could be".to_owned(),
            Failure::Stopped => "it was stopped where it was".to_owned(),
        }
    }
}

impl Refusal {
    /// In words, for the operator.
    pub const fn text(self) -> &'static str {
        match self {
            Refusal::Busy => "it has another one",
            Refusal::Mode => "it is not in auto, or is to stop",
            Refusal::OtherMemory => "it was meant for a memory that is gone",
            Refusal::OldEpoch => "it knows a later life of the coordinator",
            Refusal::Old => "it has had it before",
            Refusal::Late => "its time was over before it began",
            Refusal::NotThere => "it does not stand where the task begins",
            Refusal::Devices => "its devices are not there",
            Refusal::Unknown => "it has no such task, or not with these parameters",
            Refusal::Incomplete => "an operation was stopped before its end",
        }
    }
}

impl Controller {
    /// Where a station on order stands between two motions: what it waits for. Gives false where it waits for what every
    /// station waits for.
    pub(crate) fn explain_order(&self, line: &Line, place: Place, reasons: &mut Vec<String>) -> bool {
        let Some(tasks) = &self.program.on_order else { return false };
        let station = line.station(self.program.station);
        match self.mode() {
            ControlMode::Auto => {
                if self.master_stop_is_given() {
                    reasons.push("master stop: no order is taken on".to_owned());
                }
                match self.next_step() {
                    Some(step) => self.explain_missing(line, step, reasons),
                    None if self.rest().is_some() => reasons.push("an order".to_owned()),
                    None => reasons.push("somebody to lead it to a rest: no order goes on from here".to_owned()),
                }
                true
            }
            ControlMode::Hand => match (self.rest(), place.block) {
                (Some(rest), Block::Normal) => {
                    let choices = station.tasks_from(rest).map(|task| {
                        let forward = station.operations[station.first_of(task).index()].hand.forward();
                        format!("{} for {}", line.buttons[usize::from(forward.0)], station.task(task).name)
                    });
                    reasons.push(format!("a button: {}", choices.collect::<Vec<_>>().join(", ")));
                    true
                }
                (_, Block::Normal) => {
                    let step = self.program.step_of[place.op.index()] + 1;
                    if usize::from(step) < tasks.waits.len() {
                        self.explain_missing(line, step, reasons);
                    }
                    false
                }
                (_, Block::Recovery) => false,
            },
            ControlMode::Home | ControlMode::StandBy | ControlMode::Manual | ControlMode::EStop => false,
        }
    }

    fn explain_missing(&self, line: &Line, step: u8, reasons: &mut Vec<String>) {
        let station = self.program.station;
        let missing = self.missing(step);
        let name = &line.operation((station, line.station(station).steps[usize::from(step)][0])).name;
        for input in (0..128).filter(|bit| missing & (1 << bit) != 0).map(InputId) {
            reasons.push(format!("{}, for {name}", line.input_text(Owner::Station(station), input)));
        }
    }
}
