//! Manual of single stations of a cell, while the others stay in auto.
//!
//! It leads one station with fewer commands than manual of the whole line, and nothing is stopped for it. For two it takes as many, so
//! these are led in manual of the line, unless they are in manual by themselves already. What the coordinator refuses is left out
//! here as far as a situation shows it (decision 0033); the rest it refuses with its reason.

use std::rc::Rc;

use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId};
use linewright_station_logic::StationReport;

use crate::first::fault_signals;
use crate::plan::{RecoveryEnd, RecoveryPlan, by_commands_and_presses};
use crate::restore::{RestoreMisfit, is_unknown, unit};
use crate::situation::LineSituation;
use crate::step::{Need, RecoveryAction, RecoveryStep};
use crate::units::PlayedStations;

/// In auto: stations in manual by themselves are led to a rest where an alarm asks for it, and given auto again; so is one other station
/// that may be led so. None where no station is led beside auto.
pub(crate) fn plan(
    line: &Line,
    situation: &LineSituation,
    led: &[StationId],
    reports: &[StationReport],
) -> Option<RecoveryPlan> {
    let is_alone = |id: &StationId| reports[id.index()].mode == Some(ControlMode::Manual);
    let mut alone: Vec<StationId> = line.station_ids().filter(is_alone).collect();
    let joining: Vec<StationId> = led.iter().copied().filter(|id| !is_alone(id)).collect();
    match joining[..] {
        [] if !alone.is_empty() => Some(led_alone(line, situation, (&alone, led), reports)),
        [only] if may_be_led(line, situation, only, &reports[only.index()]) => {
            let mut reports = reports.to_vec();
            let mut steps = before_manual(line, situation, only, &mut reports[only.index()]);
            alone.push(only);
            let mut found = led_alone(line, situation, (&alone, led), &reports);
            let is_possible =
                |step: &RecoveryStep| matches!(step.action, RecoveryAction::Press(..) | RecoveryAction::AutoAgain(_));
            // Its place is not confirmed in manual by itself, and its panel is not that of resume.
            if found.end != RecoveryEnd::Auto || !found.steps.iter().all(is_possible) {
                return None;
            }
            steps.append(&mut found.steps);
            Some(RecoveryPlan { steps, ..found })
        }
        _ => None,
    }
}

/// Whether the coordinator grants a station manual by itself, as far as it can be seen: the activity of its task has failed, and the others
/// of it stand.
fn may_be_led(line: &Line, situation: &LineSituation, id: StationId, report: &StationReport) -> bool {
    let station = line.station(id);
    let mut asking = situation.alarms.iter().filter(|alarm| alarm.lead.contains(&id)).peekable();
    let turns = station.op_ids().any(|op| station.index_of(op).is_some());
    let is_to_bring = situation.alarms.iter().any(|alarm| alarm.bring.is_some());
    let stands = report.stopped && !report.selector_manual;
    let is_left_out = situation.left_out.contains(&id);
    // A station that is to be brought to another rest needs hand mode of the line.
    station.is_task_driven()
        && is_left_out
        && stands
        && !turns
        && !is_to_bring
        && !situation.is_stopping
        && asking.peek().is_some()
        && !is_unknown(station, report)
        && asking.all(|alarm| alarm.at_order.is_empty())
}

/// What comes before the presses: its emergency stop is reset, its fault signals go off, and manual is given to it.
fn before_manual(
    line: &Line,
    situation: &LineSituation,
    id: StationId,
    report: &mut StationReport,
) -> Vec<RecoveryStep> {
    let is_stopped = situation.alarms.iter().any(|alarm| alarm.reset.contains(&id));
    let mut actions: Vec<RecoveryAction> =
        is_stopped.then_some(RecoveryAction::First(Need::Reset(id))).into_iter().collect();
    // Before a person goes to the mechanism: the others move, as this step says.
    actions.push(RecoveryAction::ManualAlone(id));
    for input in fault_signals(line.station(id), report) {
        actions.push(RecoveryAction::First(Need::FaultSignal(id, input)));
        report.measured &= !input.bit();
    }
    actions.into_iter().map(in_auto).collect()
}

/// A step without a motion, after which the line is in auto.
fn in_auto(action: RecoveryAction) -> RecoveryStep {
    RecoveryStep { action, moves: Vec::new(), is_doubtful: false, mode: ControlMode::Auto, after: None }
}

/// Stations in manual by themselves: presses, then auto again.
fn led_alone(
    line: &Line,
    situation: &LineSituation,
    (alone, led): (&[StationId], &[StationId]),
    reports: &[StationReport],
) -> RecoveryPlan {
    let mut plan = RecoveryPlan::ends(Vec::new(), RecoveryEnd::Auto);
    if !led.is_empty() {
        let left_out = line.station_ids().collect();
        let manual = LineSituation { mode: ControlMode::Manual, left_out, ..situation.clone() };
        let units: Result<PlayedStations, RestoreMisfit> =
            line.station_ids().zip(reports).map(|(id, report)| unit(line, id, report).map(Rc::new)).collect();
        if let Ok(units) = units {
            plan = by_commands_and_presses(line, &manual, led, units);
            let is_of_all =
                |step: &RecoveryStep| matches!(step.action, RecoveryAction::Command(_) | RecoveryAction::Hold { .. });
            plan.steps.retain(|step| !is_of_all(step));
        }
    }
    plan.steps.extend(alone.iter().map(|&station| in_auto(RecoveryAction::AutoAgain(station))));
    plan
}
