//! The plan for what is received now.

use linewright_coordinator_cell::AlarmId;
use linewright_coordinator_cell::exception::ExceptionStage;
use linewright_coordinator_cell::texts::recovery;
use linewright_coordinator_logic::ModeStanding;
use linewright_line::{Line, StationId};
use linewright_msgs::{ActivityState, AlarmState, CellState, LineState};
use linewright_node_line::{mode_from_code, report_from_message};
use linewright_recovery::{
    ActivityEnd, DecidedEnd, EndsReached, LineSituation, PanelButton, RecoveryAction, RecoveryEnd, RecoveryPlan,
    StandingAlarm, plan,
};

use super::progress::behind_signals;
use crate::cell::{CellClient, permitted};
use crate::client::OperatorClient;

/// A plan, with the reason of each step that needs one.
#[derive(Clone)]
pub struct ReasonedPlan {
    pub plan: RecoveryPlan,
    pub reasons: Vec<Option<String>>,
    /// The stations that a fault signal has stopped, and it is off now.
    pub signals_off: Vec<StationId>,
    /// Whether *return* alone leads home the station whose *advance* comes next.
    pub returns_home: bool,
}

/// The newest plan, with the situation that it was made for: the same situation needs no other search.
#[derive(Default)]
pub struct NewestPlan {
    known: Option<(LineSituation, ReasonedPlan)>,
    reached: EndsReached,
}

impl ReasonedPlan {
    /// Whether auto is in force.
    pub fn is_done(&self) -> bool {
        self.plan.end == RecoveryEnd::Auto && self.plan.steps.is_empty()
    }
}

impl NewestPlan {
    /// The plan for what is received now; none where the coordinator is not received.
    pub fn look(&mut self, client: &OperatorClient, cell: Option<&CellClient>) -> Option<&ReasonedPlan> {
        let mut now = situation_now(client, cell);
        if let Some(situation) = &mut now {
            self.reached.complete(client.line(), situation);
        }
        if self.known.as_ref().map(|(known, _)| known) != now.as_ref() {
            self.known = now.map(|situation| {
                let plan = plan(client.line(), &situation);
                let reasons = plan.reasons(client.line(), &situation).into_iter();
                let reasons = reasons.map(|why| why.map(|why| why.text(client.line()))).collect();
                let (line, signals_off) = (client.line(), situation.signals_off(client.line()));
                let next = behind_signals(&plan).map(|at| &plan.steps[at].action);
                let returns_home = match next {
                    Some(RecoveryAction::Press(station, PanelButton::Advance)) => {
                        plan.returns_home(line, &situation, *station)
                    }
                    _ => false,
                };
                (situation, ReasonedPlan { plan, reasons, signals_off, returns_home })
            });
        }
        self.known.as_ref().map(|(_, found)| found)
    }

    /// Whether a station moves, as it was received last.
    pub fn moves(&self, station: StationId) -> bool {
        let report = self.known.as_ref().and_then(|(now, _)| now.stations.get(station.index())?.as_ref());
        report.is_some_and(|report| !report.stopped)
    }
}

/// What is received now; none where the coordinator is not received, or was started with another description: what a plan by this one
/// leads to is not known there.
fn situation_now(client: &OperatorClient, cell: Option<&CellClient>) -> Option<LineSituation> {
    if client.other_coordinator().is_some() {
        return None;
    }
    let line = client.line();
    let state = client.coordinator()?;
    let mode = mode_from_code(state.mode).ok()?;
    // A station with another description is the misfit.
    let report = |id| {
        client
            .station(id)
            .and_then(|state| report_from_message((line, state.description), state).ok())
            .map(|(_, report)| report)
    };
    let stations = line.station_ids().map(report).collect();
    let mut situation = LineSituation::read(line, mode, state.enabled, standing(line, state), stations);
    situation.misfit = client.other_station();
    match cell.map(CellClient::heard_lately) {
        Some(Some(cell)) => (situation.alarms, situation.unsettled) = (alarms(line, cell), unsettled(cell)),
        // What has failed is not known, nor which of its stations belong together.
        Some(None) => situation.unsettled = vec!["the state of the cell is not received".to_owned()],
        None => {}
    }
    Some(situation)
}

fn named(line: &Line, names: &[String]) -> Vec<StationId> {
    names.iter().filter_map(|name| line.station_named(name)).collect()
}

/// What keeps the mode, as the coordinator reports it.
fn standing(line: &Line, state: &LineState) -> ModeStanding {
    ModeStanding {
        is_stopping: state.master_stop,
        is_latched: state.estop_latched,
        is_pressed: state.estop_pressed,
        without_console: state.console_lost,
        resumes: state.resume,
        restarted: named(line, &state.restarted),
        left_out: named(line, &state.left_out),
        obstacles: state.obstacles.to_vec(),
    }
}

fn alarms(line: &Line, cell: &CellState) -> Vec<StandingAlarm> {
    let alarm = |alarm: &AlarmState| StandingAlarm {
        id: alarm.id,
        text: alarm.text.clone(),
        answers: permitted(alarm),
        lead: named(line, &alarm.lead),
        reset: named(line, &alarm.reset),
        at_order: named(line, &alarm.at_order),
        end: led_to(alarm.lead_to).map(|end| DecidedEnd { end, because: alarm.lead_because.clone() }),
        bring: line.station_named(&alarm.bring).and_then(|id| Some((id, line.station(id).rest_named(&alarm.to_rest)?))),
    };
    cell.alarms.as_slice().iter().map(alarm).collect()
}

/// Failed activities that no alarm asks about: their stations are still on the way to rest, or sensors are compared with an answer.
fn unsettled(cell: &CellState) -> Vec<String> {
    let is_asked = |of: &ActivityState| {
        let waits = |alarm: &AlarmState| recovery(Some(&ExceptionStage::Waiting(AlarmId(alarm.id))));
        cell.alarms.as_slice().iter().any(|alarm| of.text.ends_with(&waits(alarm)))
    };
    let failed = cell.activities.as_slice().iter().filter(|of| !of.running && !is_asked(of));
    failed.map(|of| format!("`{}` of part {} {}", of.name, of.part, of.text)).collect()
}

/// A code that is not known is no decision.
fn led_to(code: u8) -> Option<ActivityEnd> {
    match code {
        AlarmState::LEAD_ON => Some(ActivityEnd::Done),
        AlarmState::LEAD_BACK => Some(ActivityEnd::TakenBack),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use linewright_msgs::Bounded;

    use super::*;

    #[test]
    fn a_failed_activity_without_an_alarm_is_unsettled() {
        let activity = |id: u64, running, stage: Option<ExceptionStage>| ActivityState {
            id,
            name: "load M1".to_owned(),
            part: 7,
            running,
            text: format!("failed, waits for {}", recovery(stage.as_ref())),
            ..ActivityState::default()
        };
        let waiting = |alarm| activity(1, false, Some(ExceptionStage::Waiting(AlarmId(alarm))));
        let cell = |activities, alarms: &[u64]| CellState {
            activities: Bounded::new(activities).expect("few"),
            alarms: Bounded::new(alarms.iter().map(|&id| AlarmState { id, ..AlarmState::default() }).collect())
                .expect("few"),
            ..CellState::default()
        };
        let securing = || activity(2, false, Some(ExceptionStage::Securing));
        let text = "`load M1` of part 7 failed, waits for its stations to come to rest";
        assert_eq!(unsettled(&cell(vec![securing()], &[])), [text]);
        assert_eq!(unsettled(&cell(vec![waiting(31), securing()], &[3, 31])), [text]);
        assert_eq!(unsettled(&cell(vec![waiting(31)], &[1])).len(), 1);
        assert!(unsettled(&cell(vec![waiting(31), activity(2, true, None)], &[31])).is_empty());
    }
}
