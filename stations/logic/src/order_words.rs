//! Orders in words: what a station on order waits for.

use linewright_line::net::{Block, ControlMode, StationPlace};
use linewright_line::{InputId, Line, Owner, StationId, TaskId};

use crate::controller::Controller;

pub(crate) fn task_name(line: &Line, station: StationId, task: TaskId) -> &str {
    &line.station(station).task(task).name
}

impl Controller {
    /// Where a station on order stands between two motions: what it waits for. Gives false where it waits for what every
    /// station waits for.
    pub(crate) fn explain_order(&self, line: &Line, place: StationPlace, reasons: &mut Vec<String>) -> bool {
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
