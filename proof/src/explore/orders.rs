//! Events of a task-driven station besides those of every station: orders, their end from outside, and the inputs its
//! operations wait for.
//!
//! Orders have a number each, which grows for ever; what a station does with one does not depend on it. Time stands still
//! but for the time of an order: each has the shortest there is, and only [`StationAct::Expire`] lets it pass. An order whose
//! motion has not had its result in time ends as one whose time is over, but for the code.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId};
use linewright_station_logic::{OrderKey, TaskOrder, TaskOutcome};

use super::station::{Situation, StationAct};

/// The time of every order.
pub(super) const LIMIT: Duration = Duration::from_micros(1);

pub(super) fn key(id: u64) -> OrderKey {
    OrderKey { epoch: 1, id }
}

/// An order for a task, with every bit of its parameters on.
pub(super) fn order(line: &Line, station: StationId, task: linewright_line::TaskId, id: u64) -> TaskOrder {
    let task = line.station(station).task(task);
    TaskOrder {
        key: key(id),
        // Its first life is its first memory.
        memory: 1,
        task: task.name.as_str().into(),
        parameters: task
            .parameters
            .iter()
            .map(|parameter| (parameter.name.as_str().into(), parameter.most()))
            .collect(),
        limit: LIMIT,
    }
}

/// The inputs that a station's operations wait for.
pub(super) fn sensors_of(line: &Line, station: StationId) -> u128 {
    line.station(station).awaited_inputs().fold(0, |bits, input| bits | input.bit())
}

/// The outputs that carry the parameters of the order it has; of the task that it stands within, where a person leads it.
pub(super) fn parameters(line: &Line, station: StationId, situation: &Situation) -> u128 {
    let Some(order) = situation.controller.report().order else { return 0 };
    let described = line.station(station);
    let is_led = matches!(situation.mode, ControlMode::Hand | ControlMode::Manual) && order.rest.is_none();
    let within = || {
        let step = described.step_of(situation.controller.marking().next()?.op);
        described.task_ids().find(|&task| described.task(task).steps.contains(&step))
    };
    let task = order.slot.map(|slot| slot.task).or_else(|| within().filter(|_| is_led));
    let bits = task.into_iter().flat_map(|task| &described.task(task).parameters).flat_map(|parameter| &parameter.bits);
    bits.fold(0, |bits, output| bits | output.bit())
}

/// Possible events.
pub(super) fn acts(line: &Line, station: StationId, situation: &Situation, acts: &mut Vec<StationAct>) {
    let Some(report) = situation.controller.report().order else { return };
    match (report.slot, report.rest) {
        (Some(slot), _) => {
            acts.push(StationAct::Secure);
            if !slot.is_securing {
                acts.push(StationAct::Expire);
            }
        }
        (None, Some(rest)) if situation.mode == ControlMode::Auto => {
            acts.extend(line.station(station).tasks_from(rest).map(StationAct::Order));
        }
        (None, Some(_)) => {}
        (None, None) => {
            let failed = report.results.last().is_some_and(|(_, outcome)| matches!(outcome, TaskOutcome::Failed(_)));
            acts.extend(failed.then_some(StationAct::Secure));
        }
    }
    if sensors_of(line, station) != 0 {
        acts.push(StationAct::Sensors(!situation.has_sensors()));
    }
}
